import numpy as np
import pytest

from vh_drake.learning.scene import SceneSettings, camera_pose, look, place, vary
from vh_drake.learning.training_objects import object_mesh
from vh_drake.objects.library import library_object
from vh_drake.scenes.scenario import Scenario
from vh_drake.scenes.station import CAMERA_BODY, camera_pose_in_neck, make_station

SETTINGS = SceneSettings()


def test_the_camera_is_where_the_robot_has_it():
    station = make_station(Scenario(contact="point"), library_object("can"))
    plant = station.world.plant
    context = plant.GetMyContextFromRoot(station.CreateDefaultContext())
    X_WNeck = plant.GetBodyByName(CAMERA_BODY).EvalPoseInWorld(context)
    robot = (X_WNeck @ camera_pose_in_neck()).GetAsMatrix4()
    np.testing.assert_allclose(camera_pose(SETTINGS), robot, atol=1e-3)


def test_camera_and_table_are_those_of_the_scenario():
    scenario = Scenario()
    camera = scenario.camera
    assert (SETTINGS.width, SETTINGS.height) == (camera.width, camera.height)
    assert SETTINGS.fov_y_rad == camera.fov_y_rad
    assert SETTINGS.noise == camera.noise
    assert SETTINGS.table_height_m == scenario.table.height_m
    assert SETTINGS.center == scenario.placement.center
    assert SETTINGS.radius_m == scenario.placement.radius_m


def test_a_placed_object_stands_on_the_table_near_the_middle():
    for seed in range(5):
        rng = np.random.default_rng(seed)
        truth = place(object_mesh("shampoo", None), SETTINGS, rng)
        assert truth.mesh.bounds[0, 2] == pytest.approx(0.9)
        middle = truth.mesh.vertices.mean(axis=0)[:2]
        assert np.linalg.norm(middle - SETTINGS.center) < SETTINGS.radius_m + 0.06


def test_what_is_seen_lies_on_the_side_that_faces_the_camera():
    rng = np.random.default_rng(0)
    truth = place(object_mesh("can", None), SETTINGS, rng)
    view = look(truth, SETTINGS, rng)
    towards = view.p_WCamera - view.p_WO
    facing = np.einsum("ij,ij->i", view.n_WO, towards) / np.linalg.norm(towards, axis=1)
    assert len(view.p_WO) > 200
    assert (facing > 0).mean() > 0.99
    assert view.table.offset == pytest.approx(0.9, abs=0.003)
    np.testing.assert_array_equal(view.p_WO, view.p_WO.astype(np.float32))


def test_variations_stay_within_their_limits():
    mesh = object_mesh("fruit_drink", None)
    for seed in range(20):
        varied = vary(mesh, SETTINGS, np.random.default_rng(seed))
        factors = varied.extents / mesh.extents
        assert (factors > 0.8 * 0.9 - 1e-9).all()
        assert (factors < 1.2 * 1.1 + 1e-9).all()
        assert varied.is_watertight
