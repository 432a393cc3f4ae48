from pathlib import Path

import pytest

from vh_drake.errors import BadInput
from vh_drake.objects.library import library_names, library_object
from vh_drake.objects.listing import folder_rows, library_rows

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


def test_every_embedded_object_has_one_row_with_its_mass_and_size():
    rows = library_rows()
    assert [row.name for row in rows] == library_names()
    assert {row.name: row.mass_g for row in rows}["can"] == library_object("can").mass_kg * 1000
    assert {row.name: row.size_mm for row in rows}["sugar_box"] == "92 x 45 x 176"


def test_a_folder_gives_one_row_for_each_mesh_with_what_its_table_says(tmp_path: Path):
    (tmp_path / "vase.obj").write_text(TRIANGLE)
    (tmp_path / "cup.obj").write_text(TRIANGLE)
    (tmp_path / "objects.csv").write_text("name,mass_kg,split\ncup,0.25,test\n")
    cup, vase = folder_rows(tmp_path)
    assert (cup.name, cup.mass_g, cup.split, cup.file) == ("cup", 250.0, "test", "cup.obj")
    assert (vase.name, vase.mass_g, vase.split, vase.file) == ("vase", None, "", "vase.obj")


def test_a_folder_without_meshes_is_refused(tmp_path: Path):
    with pytest.raises(BadInput, match="no mesh"):
        folder_rows(tmp_path)
