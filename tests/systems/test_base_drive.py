import numpy as np
import pytest
from leaf import Leaf
from pydrake.math import RigidTransform, RollPitchYaw
from scenery import right_hand

from vh_drake.grasping.base_joints import base_position
from vh_drake.systems.base_drive import PERIOD_S, BaseDrive

X_START = RigidTransform(RollPitchYaw(0.1, 0.2, 0.3), [0.1, 0.2, 0.3])
X_THERE = RigidTransform(RollPitchYaw(0.1, 0.2, 0.4), [0.11, 0.2, 0.3])


def drive(**options):
    given = {"target_pose": X_THERE}
    leaf = Leaf(BaseDrive(right_hand()), **(given | options))
    leaf.system.place(leaf.context, X_START.GetAsMatrix4())
    return leaf


@pytest.mark.parametrize("caching", [True, False])
def test_the_set_point_follows_the_target_with_its_rate(caching):
    leaf = drive(caching=caching)
    start, there = (base_position(right_hand(), X.GetAsMatrix4()) for X in (X_START, X_THERE))
    np.testing.assert_allclose(leaf.get("base_state"), np.r_[start, np.zeros(6)])
    np.testing.assert_allclose(
        leaf.get("hand_pose").GetAsMatrix4(), X_START.GetAsMatrix4(), atol=1e-12
    )
    leaf.advance(PERIOD_S)
    rate = (there - start) / PERIOD_S
    np.testing.assert_allclose(leaf.get("base_state"), np.r_[there, rate], atol=1e-9)
    leaf.advance(PERIOD_S)
    np.testing.assert_allclose(leaf.get("base_state"), np.r_[there, np.zeros(6)], atol=1e-9)


def test_two_contexts_of_one_drive_do_not_touch_each_other():
    leaf = drive()
    other = leaf.system.CreateDefaultContext()
    leaf.system.place(other, X_THERE.GetAsMatrix4())
    np.testing.assert_allclose(
        leaf.get("hand_pose").GetAsMatrix4(), X_START.GetAsMatrix4(), atol=1e-12
    )
