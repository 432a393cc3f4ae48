import numpy as np
import pytest

from vh_drake.control.cartesian_position import cartesian_position_velocity
from vh_drake.control.cartesian_velocity import cartesian_velocity_to_joints
from vh_drake.control.joint_limits import limited_joint_velocity
from vh_drake.control.kinematics import ArmKinematics
from vh_drake.control.null_space import add_null_space_velocity
from vh_drake.control.reach import rollout, solve_ik
from vh_drake.errors import BadInput


@pytest.fixture(scope="module")
def arm() -> ArmKinematics:
    return ArmKinematics()


def moved(X: np.ndarray, offset: tuple[float, float, float], turn_rad: float = 0.0) -> np.ndarray:
    """The pose shifted in W and turned about the vertical through the hand."""
    c, s = np.cos(turn_rad), np.sin(turn_rad)
    Y = X.copy()
    Y[:3, :3] = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ X[:3, :3]
    Y[:3, 3] += offset
    return Y


def test_rollout_follows_the_three_controllers_step_by_step(arm):
    target = moved(arm.pose(arm.home), (0.15, 0.1, -0.1), 0.3)
    result, now = rollout(arm, arm.home, [target], dt=0.02), np.zeros(8)
    for q, q_next in zip(result.q[:-1], result.q[1:], strict=True):
        J = arm.jacobian(q)
        velocity = cartesian_velocity_to_joints(
            cartesian_position_velocity(target, arm.pose(q)),
            J,
            q,
            lower=arm.lower,
            upper=arm.upper,
            velocity_limits=arm.velocity_limits,
        )
        limits = {"lower": arm.lower, "upper": arm.upper, "velocity_limits": arm.velocity_limits}
        wanted = add_null_space_velocity(velocity, J, q, **limits)
        now = limited_joint_velocity(wanted, q, now, arm.limits, period_s=0.02)
        np.testing.assert_allclose(q_next, arm.clamped(q + 0.02 * now), atol=1e-9)


def test_rollout_reaches_its_waypoints_within_the_tolerances(arm):
    start = arm.pose(arm.home)
    waypoints = [moved(start, (0.1, 0.1, 0.1)), moved(start, (0.2, 0.1, -0.2), 0.5)]
    result = rollout(arm, arm.home, waypoints)
    assert result.reached
    assert result.waypoints_reached == 2
    assert result.position_error_m <= 0.002
    assert result.angle_error_rad <= 0.02
    np.testing.assert_allclose(
        arm.pose(result.q[-1])[:3, 3], waypoints[-1][:3, 3], atol=0.002 + 1e-9
    )


def test_rollout_keeps_position_velocity_and_acceleration_limits(arm):
    result = rollout(arm, arm.home, [moved(arm.pose(arm.home), (0.3, 0.5, -0.2), 1.6)])
    assert np.all((arm.lower <= result.q) & (result.q <= arm.upper))
    velocity = np.diff(result.q, axis=0, prepend=result.q[:1]) / 0.02
    assert np.all(np.abs(velocity) <= arm.velocity_limits + 1e-9)
    assert np.all(np.abs(np.diff(velocity, axis=0)) <= 0.02 * arm.acceleration_limits + 1e-9)


def test_rollout_gives_up_on_a_pose_beyond_the_arms_length(arm):
    result = rollout(arm, arm.home, [moved(arm.pose(arm.home), (3.0, 0.0, 0.0))])
    assert not result.reached
    assert result.waypoints_reached == 0
    assert result.position_error_m > 1.5
    assert result.duration_s < 20.0


def test_rollout_is_the_same_twice(arm):
    target = moved(arm.pose(arm.home), (0.2, 0.2, -0.1))
    first, second = (rollout(arm, arm.home, [target]) for _ in range(2))
    np.testing.assert_array_equal(first.q, second.q)


@pytest.mark.parametrize("seed", range(10))
def test_inverse_kinematics_finds_poses_that_the_arm_takes(arm, seed):
    rng = np.random.default_rng(seed)
    middle, span = (arm.lower + arm.upper) / 2, arm.upper - arm.lower
    X_WH = arm.pose(middle + 0.35 * span * rng.uniform(-1.0, 1.0, 8))
    q = solve_ik(arm, X_WH)
    assert q is not None
    assert np.all((arm.lower <= q) & (q <= arm.upper))
    np.testing.assert_allclose(arm.pose(q), X_WH, atol=2e-3)


def test_inverse_kinematics_finds_nothing_beyond_the_arms_length(arm):
    assert solve_ik(arm, moved(arm.pose(arm.home), (3.0, 0.0, 0.0)), restarts=3) is None


def test_inverse_kinematics_stays_near_a_seed_that_already_solves(arm):
    np.testing.assert_array_equal(solve_ik(arm, arm.pose(arm.home), [arm.home]), arm.home)


@pytest.mark.parametrize("bad", [np.eye(4), np.full((1, 4, 4), np.nan), np.zeros((0, 4, 4))])
def test_hand_poses_of_wrong_shape_or_with_nan_are_refused(arm, bad):
    with pytest.raises(BadInput, match="hand pose"):
        rollout(arm, arm.home, bad)
