import numpy as np
import pytest
import trimesh

from vh_drake.errors import BadInput, UnknownName
from vh_drake.objects.loading import load_object


def write(folder, sides, name="box.obj"):
    trimesh.creation.box(sides).export(folder / name)
    return folder / name


def test_a_mesh_file_becomes_an_object_with_an_assumed_mass(tmp_path):
    model = load_object(write(tmp_path, (0.05, 0.06, 0.1)))
    assert model.name == "box"
    assert model.mass_kg == pytest.approx(0.12)
    assert "assumed" in model.mass_source
    np.testing.assert_allclose(model.com, 0, atol=1e-9)


def test_a_given_mass_wins_and_scales_the_inertia(tmp_path):
    path = write(tmp_path, (0.05, 0.06, 0.1))
    one, two = load_object(path, mass_kg=0.2), load_object(str(path), mass_kg=0.4)
    assert two.mass_source == "given"
    np.testing.assert_allclose(two.inertia, 2 * one.inertia)


def test_scaling_is_reported(tmp_path):
    model = load_object(write(tmp_path, (50, 60, 100)), scale=0.001)
    np.testing.assert_allclose(model.mesh.extents, [0.05, 0.06, 0.1])
    assert model.report[0] == "Scaled by 0.001."


def test_millimetres_are_recognised(tmp_path):
    with pytest.raises(BadInput, match=r"--scale 0\.001"):
        load_object(write(tmp_path, (50, 60, 100)))


def test_two_metres_are_too_large_in_any_unit(tmp_path):
    with pytest.raises(BadInput, match=r"2 m long, too large; the limit is 0\.5 m"):
        load_object(write(tmp_path, (2.0, 0.1, 0.1)))


def test_a_crumb_is_too_small(tmp_path):
    with pytest.raises(BadInput, match="1 mm long, too small"):
        load_object(write(tmp_path, (0.001, 0.001, 0.001)))


def test_unused_vertices_do_not_count_for_the_size(tmp_path):
    path = write(tmp_path, (0.05, 0.06, 0.1))
    path.write_text("v 9 9 9\n" + path.read_text().replace("f ", "# f ") + "\n")
    box = trimesh.creation.box((0.05, 0.06, 0.1))
    faces = "\n".join("f " + " ".join(str(i + 2) for i in face) for face in box.faces)
    vertices = "\n".join("v " + " ".join(map(str, vertex)) for vertex in box.vertices)
    path.write_text(f"v 9 9 9\n{vertices}\n{faces}\n")
    np.testing.assert_allclose(load_object(path).mesh.extents, [0.05, 0.06, 0.1])


def test_repairs_are_reported_and_the_file_is_named_where_they_fail(tmp_path):
    box = trimesh.creation.box((0.05, 0.06, 0.1)).subdivide()
    box.update_faces(np.arange(len(box.faces)) > 0)
    box.export(tmp_path / "open.ply")
    assert load_object(tmp_path / "open.ply").report == ("Closed 1 hole.",)
    (tmp_path / "flat.obj").write_text("v 0 0 0\nv 0.1 0 0\nv 0.1 0 0\nf 1 2 2\nf 3 3 1\n")
    with pytest.raises(BadInput, match=r"flat\.obj"):
        load_object(tmp_path / "flat.obj")


def test_heavy_meshes_are_simplified_in_place(tmp_path):
    ball = trimesh.creation.icosphere(6, 0.05)
    ball.export(tmp_path / "ball.stl")
    model = load_object(tmp_path / "ball.stl")
    assert len(model.mesh.faces) <= 20_000
    assert model.mesh.volume == pytest.approx(ball.volume, rel=1e-3)
    assert model.report[-1] == "Simplified from 81920 to 20000 triangles."


def test_a_library_name_takes_a_mass_and_a_scale():
    can = load_object("can")
    assert can.mass_source == "library"
    assert load_object("can", mass_kg=0.1).mass_kg == 0.1
    half = load_object("can", scale=0.5)
    np.testing.assert_allclose(half.mesh.extents, can.mesh.extents / 2)
    assert half.primitive is None


@pytest.mark.parametrize("mass", [0.0, -1.0, np.nan, 1e9])
def test_an_impossible_mass_is_refused(mass):
    with pytest.raises(BadInput, match="mass"):
        load_object("can", mass_kg=mass)


@pytest.mark.parametrize("scale", [0.0, -1.0, np.nan, np.inf, 100.0])
def test_an_impossible_scale_is_refused(scale):
    with pytest.raises(BadInput, match="scale"):
        load_object("can", scale=scale)


def test_unknown_names_list_the_library():
    with pytest.raises(UnknownName, match="banana"):
        load_object("mugg")


def test_a_folder_in_place_of_an_object_is_explained(tmp_path):
    with pytest.raises(BadInput, match="--objects"):
        load_object(tmp_path)
