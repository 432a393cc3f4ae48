import pytest
import trimesh

from vh_drake.errors import BadInput, UnknownName
from vh_drake.objects.folders import list_objects, read_folder
from vh_drake.objects.loading import load_object

BALL = trimesh.creation.icosphere(2, 0.03)


@pytest.fixture
def folder(tmp_path):
    path = tmp_path / "ycb" / "055_baseball" / "google_16k" / "textured.obj"
    path.parent.mkdir(parents=True)
    BALL.export(path)
    (path.parent / "texture_map.png").write_bytes(b"not read")
    BALL.export(tmp_path / "ycb" / "plain.ply")
    single = tmp_path / "ycb" / "boxed"
    single.mkdir()
    BALL.export(single / "whatever.stl")
    (tmp_path / "ycb" / "empty").mkdir()
    (tmp_path / "ycb" / "README.md").write_text("hello")
    return tmp_path / "ycb"


def test_the_layout_of_the_ycb_download_and_plain_files_are_understood(folder):
    assert list_objects(folder) == ["055_baseball", "boxed", "plain"]
    assert read_folder(folder)["055_baseball"].path.name == "textured.obj"


def test_masses_and_splits_come_from_the_table(folder):
    (folder / "objects.csv").write_text("name,split,mass_kg\n055_baseball,test,0.148\nother,x,1\n")
    entry = read_folder(folder)["055_baseball"]
    assert (entry.mass_kg, entry.split) == (0.148, "test")
    model = load_object("055_baseball", folder=folder)
    assert (model.mass_kg, model.mass_source) == (0.148, "objects.csv")


def test_an_unknown_name_lists_what_the_folder_holds(folder):
    with pytest.raises(UnknownName, match="055_baseball, boxed, plain"):
        load_object("baseball", folder=folder)


@pytest.mark.parametrize(
    ("table", "fault"),
    [
        ("title,mass_kg\na,1\n", "no column 'name'"),
        ("name,mass_kg\nplain,heavy\n", "not a number"),
        ("name,mass_kg\nplain,-1\n", "between 0 and 100"),
        ("name,mass_kg\nplain,nan\n", "between 0 and 100"),
    ],
)
def test_a_bad_table_is_refused(folder, table, fault):
    (folder / "objects.csv").write_text(table)
    with pytest.raises(BadInput, match=fault):
        read_folder(folder)


def test_a_table_of_binary_rubbish_is_refused(folder):
    (folder / "objects.csv").write_bytes(b"\xff\xfe\x00\x81name")
    with pytest.raises(BadInput, match=r"objects\.csv"):
        read_folder(folder)


def test_a_missing_and_an_empty_folder_are_refused(tmp_path):
    with pytest.raises(BadInput, match="no such folder"):
        read_folder(tmp_path / "nothing")
    with pytest.raises(BadInput, match="no mesh in it"):
        read_folder(tmp_path)
