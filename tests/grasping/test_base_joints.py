import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw
from scenery import right_hand

from vh_drake.grasping.base_joints import base_pose, base_position
from vh_drake.grasping.motions import pitched_rotation


def test_positions_of_the_base_are_place_yaw_and_pitch_and_go_on_without_a_jump():
    X_WH = np.eye(4)
    for pitch in (0.0, 0.5):
        X_WH[:3, :3] = pitched_rotation(right_hand(), pitch)
        X_WH[:3, 3] = [0.1, 0.2, 0.3]
        position = base_position(right_hand(), X_WH)
        np.testing.assert_allclose(position, [0.1, 0.2, 0.3, 0.0, pitch, 0.0], atol=1e-12)
    turned, before = X_WH.copy(), position
    for yaw in np.linspace(0.0, 2 * np.pi, 20):
        turned[:3, :3] = RollPitchYaw(0.0, 0.0, yaw).ToRotationMatrix().matrix() @ X_WH[:3, :3]
        before = base_position(right_hand(), turned, before)
        np.testing.assert_allclose(before[3:], [yaw, 0.5, 0.0], atol=1e-12)


def test_the_pose_of_positions_is_where_they_came_from():
    rng = np.random.default_rng(3)
    for angles in rng.uniform(-1.5, 1.5, (20, 3)):
        X_WH = RigidTransform(RollPitchYaw(angles), rng.normal(size=3)).GetAsMatrix4()
        position = base_position(right_hand(), X_WH)
        np.testing.assert_allclose(base_pose(right_hand(), position), X_WH, atol=1e-12)
