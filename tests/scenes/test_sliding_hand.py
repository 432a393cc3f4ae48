"""The wrist feels a light brick before it has been pushed away, in simulated physics."""

import numpy as np
import pytest
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator
from scenery import right_hand

from vh_drake.objects.lathe import box
from vh_drake.objects.model import make_object
from vh_drake.objects.primitives import BoxShape
from vh_drake.scenes.sliding_hand import WAIT_S, make_sliding_hand

SIZE = (0.05, 0.08, 0.05)  # of the brick [m]
GAP, SPEED = 0.04, 0.03  # [m], [m/s]


@pytest.mark.slow
@pytest.mark.parametrize("mass", [0.028, 0.066])
def test_a_light_object_is_felt_before_it_has_moved_two_millimetres(mass):
    brick = make_object("brick", box(SIZE), mass, primitive=BoxShape(SIZE, (0, 0, SIZE[2] / 2)))
    X_TO = RigidTransform([GAP + SIZE[0] / 2, 0.0, 0.0])
    scene = make_sliding_hand(right_hand(), brick, X_TO, pad_height_m=0.03, speed_m_s=SPEED, seed=1)
    simulator = Simulator(scene.diagram)
    context = simulator.get_mutable_context()
    plant_context = scene.plant.GetMyContextFromRoot(context)
    place = scene.plant.EvalBodyPoseInWorld(plant_context, scene.object).translation().copy()
    mine = scene.estimator.GetMyContextFromRoot(context)
    while not scene.estimator.GetOutputPort("contact").Eval(mine)[0] and context.get_time() < 3.0:
        simulator.AdvanceTo(context.get_time() + 0.01)
    assert context.get_time() > WAIT_S + 0.9 * GAP / SPEED  # not before they meet
    simulator.AdvanceTo(context.get_time() + 0.1)
    found = scene.estimator.GetOutputPort("contact_point").Eval(mine)
    now = scene.plant.EvalBodyPoseInWorld(plant_context, scene.object).translation()
    assert len(found) == 1
    assert np.linalg.norm(now - place) < 0.002
    assert abs(found.p_WC[0, 0] - (now[0] - 0.5 * SIZE[0])) < 0.004
    assert abs(found.p_WC[0, 1] - place[1]) < 0.035  # Any of the fingers may come first.
    assert np.rad2deg(np.arccos(-found.n_WC[0, 0])) < 20.0
