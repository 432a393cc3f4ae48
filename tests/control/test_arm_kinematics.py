import numpy as np
import pytest
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable

from vh_drake.control.kinematics import (
    HAND_MASS_KG,
    ArmKinematics,
    arm_joint_names,
    home_configuration,
    mirrored,
)
from vh_drake.errors import UnknownName
from vh_drake.geometry.robot_model import add_armar6

GRAVITY = 9.81


@pytest.fixture(scope="module")
def arm() -> ArmKinematics:
    return ArmKinematics()


def random_q(arm: ArmKinematics, seed: int) -> np.ndarray:
    return np.random.default_rng(seed).uniform(arm.lower, arm.upper)


def whole_robot(side: str, torso: float, q: np.ndarray) -> tuple[MultibodyPlant, object]:
    plant = MultibodyPlant(0.0)
    add_armar6(plant, visuals=False)
    plant.Finalize()
    context = plant.CreateDefaultContext()
    plant.GetJointByName("torso_joint").set_translation(context, torso)
    for name, angle in zip(arm_joint_names(side), q, strict=True):
        plant.GetJointByName(name).set_angle(context, angle)
    return plant, context


@pytest.mark.parametrize(("side", "suffix"), [("right", "r1"), ("left", "r0")])
@pytest.mark.parametrize("torso", [0.0, -0.2])
def test_pose_and_jacobian_match_drake_on_the_whole_robot(side, suffix, torso):
    arm = ArmKinematics(side, torso_position_m=torso)
    q = random_q(arm, 1)
    plant, context = whole_robot(side, torso, q)
    hand, world = plant.GetFrameByName(f"hand_fixed_{suffix}"), plant.world_frame()
    J = plant.CalcJacobianSpatialVelocity(
        context, JacobianWrtVariable.kV, hand, np.zeros(3), world, world
    )
    columns = [plant.GetJointByName(name).velocity_start() for name in arm.joint_names]
    np.testing.assert_allclose(arm.pose(q), hand.CalcPoseInWorld(context).GetAsMatrix4(), atol=1e-9)
    np.testing.assert_allclose(arm.jacobian(q), J[:, columns], atol=1e-9)


def test_linear_jacobian_matches_finite_differences(arm):
    q, step = random_q(arm, 2), 1e-6
    for joint, unit in enumerate(np.eye(8)):
        ahead, behind = arm.pose(q + step * unit), arm.pose(q - step * unit)
        slope = (ahead[:3, 3] - behind[:3, 3]) / (2 * step)
        np.testing.assert_allclose(arm.jacobian(q)[3:, joint], slope, atol=1e-8)


def test_gravity_torques_are_the_gradient_of_the_potential_energy(arm):
    q, step = random_q(arm, 3), 1e-5

    def energy(q: np.ndarray) -> float:
        plant, context = whole_robot("right", arm.torso_position_m, q)
        hand = arm.pose(q) @ np.array([0.015, 0.0, -0.025, 1.0])
        return plant.CalcPotentialEnergy(context) + HAND_MASS_KG * GRAVITY * hand[2]

    slope = [(energy(q + step * u) - energy(q - step * u)) / (2 * step) for u in np.eye(8)]
    np.testing.assert_allclose(arm.gravity_torques(q), slope, atol=1e-4)


def test_payload_adds_its_weight_through_the_jacobian(arm):
    q = random_q(arm, 4)
    loaded = ArmKinematics(payload_kg=0.7, p_HPayload=(0.0, 0.0, 0.0))
    weight = np.array([0.0, 0.0, 0.0, 0.0, 0.0, -0.7 * GRAVITY])
    difference = loaded.gravity_torques(q) - arm.gravity_torques(q)
    np.testing.assert_allclose(difference, -arm.jacobian(q).T @ weight, atol=1e-9)


def test_mirrored_left_arm_puts_its_hand_at_the_mirrored_place(arm):
    left = ArmKinematics("left")
    q = random_q(arm, 5)
    mirror = np.diag([1.0, -1.0, 1.0, 1.0])
    expected = mirror @ arm.pose(q) @ mirror  # the hand is mirrored in its own y
    np.testing.assert_allclose(left.pose(mirrored(q)), expected, atol=2e-6)


def test_limits_of_the_left_arm_mirror_those_of_the_right(arm):
    left = ArmKinematics("left")
    corners = np.sort([mirrored(arm.lower), mirrored(arm.upper)], axis=0)
    np.testing.assert_allclose(corners, [left.lower, left.upper], atol=1e-6)


@pytest.mark.parametrize("side", ["right", "left"])
def test_home_lies_well_within_the_limits_and_over_the_table(side):
    arm = ArmKinematics(side)
    home = home_configuration(side)
    room = np.minimum(home - arm.lower, arm.upper - home)
    assert room.min() > 0.1
    x, y, z = arm.pose(home)[:3, 3]
    assert 0.4 < x < 0.6
    assert 0.35 < abs(y) < 0.5
    assert z > 1.1


def test_clamped_positions_lie_within_the_limits(arm):
    np.testing.assert_array_equal(arm.clamped(np.full(8, 100.0)), arm.upper)
    np.testing.assert_array_equal(arm.clamped(np.full(8, -100.0)), arm.lower)


def test_an_unknown_side_lists_the_choices():
    with pytest.raises(UnknownName, match="unknown arm 'middle'; choose one of: left, right"):
        ArmKinematics("middle")
