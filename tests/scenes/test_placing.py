import dataclasses as dc

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from vh_drake.objects.loading import load_object
from vh_drake.scenes.placing import draw_object_pose, place_object
from vh_drake.scenes.scenario import Scenario
from vh_drake.scenes.station import make_station

SCENARIO = Scenario(object="fruit_drink", contact="point")
MODEL = load_object(SCENARIO.object)


def pose(seed):
    return draw_object_pose(dc.replace(SCENARIO, seed=seed), MODEL)


def test_the_seed_alone_decides_on_the_pose():
    assert pose(3).IsExactlyEqualTo(pose(3))
    assert not pose(3).IsNearlyEqualTo(pose(4), 1e-3)


def test_objects_stand_on_the_table_within_the_placement():
    center, radius = np.array(SCENARIO.placement.center), SCENARIO.placement.radius_m
    for seed in range(12):
        X_WO = pose(seed)
        lowest = (X_WO @ MODEL.mesh.vertices.T)[2].min()
        assert lowest == pytest.approx(SCENARIO.table.height_m, abs=0.001)
        middle = X_WO @ MODEL.com
        assert np.linalg.norm(middle[:2] - center) < radius + 0.05


@pytest.mark.parametrize("seed", [0, 5])
def test_a_placed_object_rests(seed):
    scenario = dc.replace(SCENARIO, seed=seed)
    station = make_station(scenario, MODEL)
    simulator = Simulator(station)
    context = simulator.get_mutable_context()
    X_WO = draw_object_pose(scenario, MODEL)
    place_object(station, context, X_WO)
    station.GetInputPort("spatial_velocity").FixValue(context, np.zeros(6))
    station.GetInputPort("motor_command").FixValue(context, np.zeros(2))
    simulator.AdvanceTo(0.3)
    plant = station.world.plant
    moved = plant.EvalBodyPoseInWorld(plant.GetMyContextFromRoot(context), station.world.object)
    way = moved @ MODEL.mesh.vertices.T - X_WO @ MODEL.mesh.vertices.T
    assert np.linalg.norm(way, axis=0).max() < 0.002
