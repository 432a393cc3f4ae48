import json
import struct

import numpy as np
import pytest
import trimesh

from vh_drake.errors import BadInput
from vh_drake.geometry import mesh_files
from vh_drake.geometry.mesh_files import load_mesh


@pytest.fixture
def peer() -> trimesh.Trimesh:
    mesh = trimesh.creation.torus(0.04, 0.01)
    mesh.apply_translation([0.1, 0.2, 0.3])
    return mesh


@pytest.mark.parametrize("suffix", ["obj", "ply", "stl", "glb"])
def test_every_format_keeps_the_shape(tmp_path, peer, suffix):
    path = tmp_path / f"torus.{suffix}"
    peer.export(path)
    mesh = load_mesh(path)
    assert mesh.volume == pytest.approx(peer.volume, rel=1e-5)
    np.testing.assert_allclose(mesh.bounds, peer.bounds, atol=1e-6)


@pytest.mark.parametrize(("suffix", "kind"), [("ply", "ascii"), ("stl", "stl_ascii")])
def test_text_variants_keep_the_shape(tmp_path, peer, suffix, kind):
    path = tmp_path / f"torus.{suffix}"
    options = {"encoding": "ascii"} if suffix == "ply" else {"file_type": kind}
    peer.export(path, **options)
    assert load_mesh(path).volume == pytest.approx(peer.volume, rel=1e-5)


def test_a_glb_scene_applies_the_poses_of_its_nodes(tmp_path, peer):
    X = trimesh.transformations.rotation_matrix(0.5, [0, 1, 0], [0.1, 0, 0])
    scene = trimesh.Scene()
    scene.add_geometry(peer, transform=X)
    scene.export(tmp_path / "scene.glb")
    expected = peer.copy().apply_transform(X)
    np.testing.assert_allclose(load_mesh(tmp_path / "scene.glb").bounds, expected.bounds, atol=1e-6)


def test_materials_named_by_an_obj_are_not_opened(tmp_path, peer):
    path = tmp_path / "torus.obj"
    path.write_text("mtllib /dev/zero\nusemtl x\n" + peer.export(file_type="obj"))
    assert load_mesh(path).volume == pytest.approx(peer.volume, rel=1e-5)


def test_a_glb_with_an_outside_buffer_is_refused(tmp_path):
    text = json.dumps({"asset": {}, "buffers": [{"uri": "../secret.bin", "byteLength": 9}]})
    chunk = text.encode() + b" " * (-len(text) % 4)
    header = struct.pack("<4sIIII", b"glTF", 2, 20 + len(chunk), len(chunk), 0x4E4F534A)
    (tmp_path / "a.glb").write_bytes(header + chunk)
    with pytest.raises(BadInput, match="outside the file"):
        load_mesh(tmp_path / "a.glb")


POINTS_PLY = (
    "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
    "property float z\nend_header\n0 0 0\n1 1 1\n"
)
BAD_FILES = {
    "empty.obj": ("", "empty"),
    "blank.stl": (" \n", "empty"),
    "cloud.ply": (POINTS_PLY, "point cloud"),
    "cloud.obj": ("v 0 0 0\nv 1 0 0\n", "point cloud"),
    "nan.obj": ("v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "NaN"),
    "infinite.obj": ("v inf 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "NaN or infinite"),
    "index.obj": ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "index.obj"),
    "huge.ply": (
        POINTS_PLY.replace("vertex 2", "vertex 2\nelement face 999999999"),
        "promises",
    ),
    "wrong.ply": ("solid nothing", "header"),
    "wrong.stl": ("hello there, this is no mesh", "truncated"),
    "wrong.glb": ("hello there, this is no mesh", "glTF"),
    "mesh.step": ("ISO-10303-21;", "format"),
    "mesh.zip": ("PK", "format"),
}


@pytest.mark.parametrize("name", sorted(BAD_FILES))
def test_bad_files_are_named_with_their_fault(tmp_path, name):
    text, fault = BAD_FILES[name]
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(BadInput, match=fault) as caught:
        load_mesh(path)
    assert name in str(caught.value)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(BadInput, match="no such file"):
        load_mesh(tmp_path / "nothing.obj")


def test_a_folder_is_no_file(tmp_path):
    (tmp_path / "dir.obj").mkdir()
    with pytest.raises(BadInput, match="no such file"):
        load_mesh(tmp_path / "dir.obj")


def test_a_file_over_the_byte_limit_is_not_read(tmp_path):
    path = tmp_path / "large.stl"
    with path.open("wb") as file:
        file.truncate(mesh_files.MAX_BYTES + 1)
    with pytest.raises(BadInput, match="over the limit of 50 MB"):
        load_mesh(path)


@pytest.mark.parametrize("suffix", ["obj", "ply", "stl", "glb"])
def test_too_many_triangles_are_refused(tmp_path, peer, suffix, monkeypatch):
    monkeypatch.setattr(mesh_files, "MAX_TRIANGLES", 100)
    peer.export(tmp_path / f"torus.{suffix}")
    with pytest.raises(BadInput, match="decimate"):
        load_mesh(tmp_path / f"torus.{suffix}")
