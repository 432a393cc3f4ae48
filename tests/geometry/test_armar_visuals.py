import logging
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image
from pydrake.geometry import Mesh, Role
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder
from scipy.spatial import KDTree

from vh_drake.geometry import armar_visuals as module
from vh_drake.geometry.armar_visuals import armar_visuals, repair_mesh_file
from vh_drake.geometry.robot_model import add_armar6

GREY = np.array([0.2, 0.3, 0.4])


def two_coloured_ball(folder: Path) -> Path:
    """A ball whose texture is red for x < 0 and blue for x > 0."""
    ball = trimesh.creation.icosphere(subdivisions=4)
    pixels = np.zeros((4, 4, 3), np.uint8)
    pixels[:, :2], pixels[:, 2:] = (255, 0, 0), (0, 0, 255)
    Image.fromarray(pixels).save(folder / "ball.png")
    (folder / "ball.mtl").write_text("newmtl skin\nKd 1 1 1\nTr 1.000000\nmap_Kd ball.png\n")
    centres = ball.triangles_center[:, 0]
    lines = ["mtllib ball.mtl", "usemtl skin", "vt 0.1 0.5", "vt 0.9 0.5"]
    lines += [f"v {x} {y} {z}" for x, y, z in ball.vertices]
    for (a, b, c), x in zip(ball.faces + 1, centres, strict=True):
        uv = 1 if x < 0 else 2
        lines.append(f"f {a}/{uv} {b}/{uv} {c}/{uv}")
    (folder / "ball.obj").write_text("\n".join(lines))
    return folder / "ball.obj"


def test_repaired_mesh_is_light_opaque_and_keeps_its_shape(tmp_path):
    target = tmp_path / "out" / "ball.obj"
    repair_mesh_file(two_coloured_ball(tmp_path), target, GREY, 500)
    mesh = trimesh.load(target, force="mesh")
    assert len(mesh.faces) <= 500
    np.testing.assert_allclose(np.linalg.norm(mesh.vertices, axis=1), 1.0, atol=0.02)
    material = target.with_suffix(".mtl").read_text()
    assert "d 1.0" in material
    assert "Tr" not in material


def test_repaired_mesh_keeps_the_textures_colours_in_their_places(tmp_path):
    target = tmp_path / "ball_repaired.obj"
    repair_mesh_file(two_coloured_ball(tmp_path), target, GREY, 500)
    parts = trimesh.load(target, split_object=False, group_material=True).geometry.values()
    colours = {}
    for part in parts:
        side = np.sign(part.triangles_center[:, 0].mean())
        colours[side] = part.visual.material.diffuse[:3].tolist()
    assert colours == {-1.0: [255, 0, 0], 1.0: [0, 0, 255]}


def test_mesh_without_texture_takes_the_given_colour(tmp_path):
    source, target = tmp_path / "box.obj", tmp_path / "light.obj"
    trimesh.creation.box().export(source, include_texture=False, include_color=False)
    repair_mesh_file(source, target, GREY, 100)
    assert "Kd 0.2000 0.3000 0.4000" in target.with_suffix(".mtl").read_text()


def test_without_the_package_there_are_no_meshes(monkeypatch):
    monkeypatch.setattr(module, "find_spec", lambda name: None)
    assert armar_visuals() == {}


def test_a_cache_that_cannot_be_written_leaves_the_robot_its_own_shapes(tmp_path, caplog):
    pytest.importorskip("armar")
    (tmp_path / "file").write_text("")
    with caplog.at_level(logging.WARNING):
        assert armar_visuals(tmp_path / "file" / "cache") == {}
    assert "left out" in caplog.text


def test_published_wrist_bracket_stays_within_a_millimetre_or_two_of_its_shape(tmp_path):
    pytest.importorskip("armar")
    meshes = Path(find_spec("armar").origin).parent / "description" / "meshes" / "armar6"
    source, target = meshes / "visual" / "arml_t8.obj", tmp_path / "arml_t8.obj"
    repair_mesh_file(source, target, np.ones(3), 2000)
    published = trimesh.load(source, force="mesh")
    points = trimesh.sample.sample_surface(published, 200_000, seed=0)[0]
    distance, _ = KDTree(points).query(trimesh.load(target, force="mesh").vertices)
    assert np.quantile(distance, 0.99) < 0.002


def test_robot_shows_real_meshes_and_no_rigid_right_hand():
    pytest.importorskip("armar")
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.0)
    add_armar6(plant, visuals=True)
    plant.Finalize()
    inspector = scene_graph.model_inspector()

    def shapes(link: str, role: Role) -> list[str]:
        frame = plant.GetBodyFrameIdOrThrow(plant.GetBodyByName(link).index())
        geometries = inspector.GetGeometries(frame, role)
        return [type(inspector.GetShape(g)).__name__ for g in geometries]

    for role in (Role.kIllustration, Role.kPerception):
        assert shapes("platform", role) == shapes("hand_fixed_r0", role) == [Mesh.__name__]
        assert shapes("hand_fixed_r1", role) == []
    assert Mesh.__name__ not in shapes("platform", Role.kProximity)
