import json

import numpy as np
import pytest

from vh_drake.errors import BadInput
from vh_drake.sensing.contact_files import load_contacts, load_table

ROWS = [[0.7, -0.3, 0.95, 0.0, 0.0, 2.0], [0.6, -0.3, 0.93, -1.0, 0.0, 0.0]]
NAMES = ["x", "y", "z", "nx", "ny", "nz"]


def write(folder, name, text):
    path = folder / name
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.csv", "\n".join(",".join(map(str, row)) for row in ROWS)),
        ("b.csv", "x, y, z, nx, ny, nz\n" + "\n".join(",".join(map(str, row)) for row in ROWS)),
        ("a.json", json.dumps(ROWS)),
        ("b.json", json.dumps({"contacts": [dict(zip(NAMES, r, strict=True)) for r in ROWS]})),
    ],
)
def test_every_way_to_write_contacts_gives_the_same(name, text, tmp_path):
    contacts = load_contacts(write(tmp_path, name, text))
    np.testing.assert_allclose(contacts.p_WC, np.array(ROWS)[:, :3])
    np.testing.assert_allclose(contacts.n_WC, [[0, 0, 1], [-1, 0, 0]])


def test_repeated_contacts_count_once(tmp_path):
    assert len(load_contacts(write(tmp_path, "a.json", json.dumps(ROWS + ROWS)))) == 2


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.csv", "", "is empty"),
        ("a.csv", "1,2,3\n", "3 values"),
        ("a.csv", "1,2,3,a,b,c\n", "no number"),
        ("a.csv", "1,2,nan,0,0,1\n", "NaN"),
        ("a.csv", "1,2,3,0,0,0\n", "no length"),
        ("a.csv", "1,2,3,0,0,1\n1,2,3,0,0,-1\n", "oppose each other"),
        ("a.csv", "1,2,3,0,0,1\n" * 1001, "1001 contacts"),
        ("a.json", "{", "no JSON"),
        ("a.json", "{}", "a list of contacts"),
        ("a.json", "[7]", "list of 6 numbers"),
        ("a.json", "[[1,2,3,0,0,null]]", "no number"),
        ("a.json", "[" * 100_000, "no JSON"),
        ("a.txt", "1", r"\.csv, \.json"),
    ],
)
def test_unusable_contacts_are_refused(name, text, message, tmp_path):
    with pytest.raises(BadInput, match=message):
        load_contacts(write(tmp_path, name, text))


def test_contacts_that_are_no_text_are_refused(tmp_path):
    path = tmp_path / "a.csv"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(BadInput, match="UTF-8"):
        load_contacts(path)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("t.json", '{"normal": [0.0, 0.0, 2.0], "offset": 1.8}'),
        ("t.yaml", "normal: [0, 0, -1]\noffset: -0.9\n"),
    ],
)
def test_a_table_is_the_same_plane_however_it_is_written(name, text, tmp_path):
    plane = load_table(write(tmp_path, name, text))
    np.testing.assert_allclose(plane.normal, [0, 0, 1])
    assert plane.offset == pytest.approx(0.9)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("normal: [0, 0]\noffset: 1", "3 finite values"),
        ("normal: [0, 0, 0]\noffset: 1", "not all zero"),
        ("normal: [0, 0, .nan]\noffset: 1", "finite"),
        ("normal: [1, 0, 0]\noffset: 1", "not vertical"),
        ("normal: up\noffset: 1", "TableFile"),
        ("normal: [0, 0, 1]\nheight: 1", "TableFile"),
        ("[", "TableFile"),
    ],
)
def test_unusable_tables_are_refused(text, message, tmp_path):
    with pytest.raises(BadInput, match=message):
        load_table(write(tmp_path, "t.yaml", text))


def test_a_table_file_of_unknown_kind_is_refused(tmp_path):
    with pytest.raises(BadInput, match="json"):
        load_table(write(tmp_path, "t.txt", "normal: [0, 0, 1]"))
