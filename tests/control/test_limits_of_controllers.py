"""The three controllers for any input: within all limits, and calm where a goal is out of reach."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from leaf import Leaf
from pydrake.math import RigidTransform
from scenery import right_arm
from scipy.spatial.transform import Rotation

from vh_drake.control.cartesian_position import (
    MAX_ANGULAR_RAD_S,
    MAX_LINEAR_M_S,
    cartesian_position_velocity,
)
from vh_drake.control.cartesian_velocity import cartesian_velocity_to_joints
from vh_drake.control.joint_limits import PERIOD_S, limited_joint_velocity
from vh_drake.control.null_space import add_null_space_velocity
from vh_drake.control.reach import rollout
from vh_drake.errors import BadInput
from vh_drake.systems.cartesian_velocity_controller import CartesianVelocityController
from vh_drake.systems.nullspace_controller import NullspaceController

ARM = right_arm()
LOWER, UPPER, FASTEST, ACCELERATION = ARM.limits
BOUNDS = {"lower": LOWER, "upper": UPPER, "velocity_limits": FASTEST}
ROUNDING = 1e-9
ANY = st.one_of(st.floats(-3.0, 3.0), st.floats(allow_nan=False, allow_infinity=False, width=64))


def anything(size):
    return arrays(float, size, elements=ANY)


def shares():
    """Where the joints are in their ranges; often at the ends."""
    ends = st.sampled_from([0.0, 1e-6, 0.5, 1.0 - 1e-6, 1.0])
    return arrays(float, 8, elements=st.one_of(ends, st.floats(0.0, 1.0)))


def within_range(share):
    return np.clip(LOWER + share * (UPPER - LOWER), LOWER, UPPER)


def assert_within_limits(velocity, q):
    assert np.all(np.abs(velocity) <= FASTEST + ROUNDING)
    after = q + PERIOD_S * velocity
    assert np.all((after >= LOWER - ROUNDING) & (after <= UPPER + ROUNDING))


@settings(max_examples=100, deadline=None)
@given(
    turns=arrays(float, (2, 3), elements=st.floats(-4.0, 4.0)),
    places=arrays(float, (2, 3), elements=st.floats(-1e6, 1e6)),
)
def test_the_hand_is_never_told_to_move_faster_than_its_bounds(turns, places):
    poses = np.tile(np.eye(4), (2, 1, 1))
    poses[:, :3, :3] = Rotation.from_rotvec(turns).as_matrix()
    poses[:, :3, 3] = places
    velocity = cartesian_position_velocity(*poses)
    assert np.linalg.norm(velocity[:3]) <= MAX_ANGULAR_RAD_S + ROUNDING
    assert np.linalg.norm(velocity[3:]) <= MAX_LINEAR_M_S + ROUNDING


@settings(max_examples=100, deadline=None)
@given(velocity=anything(6), share=shares())
def test_joints_keep_velocity_and_position_limits_for_any_velocity_of_the_hand(velocity, share):
    q = within_range(share)
    assert_within_limits(cartesian_velocity_to_joints(velocity, ARM.jacobian(q), q, **BOUNDS), q)


@settings(max_examples=100, deadline=None)
@given(velocity=anything(8), share=shares(), gain=st.floats(0.0, 100.0))
def test_joints_keep_them_with_the_null_space_too_whatever_comes_in(velocity, share, gain):
    q = within_range(share)
    total = add_null_space_velocity(velocity, ARM.jacobian(q), q, **BOUNDS, gain=gain)
    assert_within_limits(total, q)


@settings(max_examples=30, deadline=None)
@given(commands=st.lists(anything(6), min_size=1, max_size=4), share=shares())
def test_the_chain_keeps_accelerations_too_for_any_velocities_in_a_row(commands, share):
    q, now = within_range(share), np.zeros(8)
    for command in [c for c in commands for _ in range(15)]:
        J = ARM.jacobian(q)
        wanted = cartesian_velocity_to_joints(command, J, q, **BOUNDS)
        wanted = add_null_space_velocity(wanted, J, q, **BOUNDS)
        after = limited_joint_velocity(wanted, q, now, ARM.limits)
        assert_within_limits(after, q)
        assert np.all(np.abs(after - now) <= ACCELERATION * PERIOD_S + ROUNDING)
        q, now = ARM.clamped(q + PERIOD_S * after), after


@settings(max_examples=25, deadline=None)
@given(velocity=anything(6), share=shares(), before=shares())
def test_a_single_system_limits_accelerations_where_it_is_told_to(velocity, share, before):
    q, now = within_range(share), (2.0 * before - 1.0) * FASTEST
    state = np.r_[q, now]
    cartesian = Leaf(
        CartesianVelocityController(ARM, period_s=PERIOD_S),
        spatial_velocity=velocity,
        joint_state=state,
    ).get("joint_velocity")
    wanted = np.resize(velocity, 8)
    nullspace = Leaf(
        NullspaceController(ARM, period_s=PERIOD_S), joint_velocity=wanted, joint_state=state
    ).get("joint_velocity")
    for after in (cartesian, nullspace):
        assert_within_limits(after, q)
        # Only to stay within the range may a joint slow down faster.
        faster = np.abs(after) > np.abs(now) + ACCELERATION * PERIOD_S + ROUNDING
        assert not np.any(faster)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_what_is_not_finite_is_refused(bad):
    J = ARM.jacobian(ARM.home)
    with pytest.raises(BadInput, match="finite"):
        cartesian_velocity_to_joints(np.full(6, bad), J, ARM.home, **BOUNDS)
    with pytest.raises(BadInput, match="finite"):
        add_null_space_velocity(np.full(8, bad), J, ARM.home, **BOUNDS)


def followed(X_target, duration_s):
    """Joint velocities (n, 8) and hand positions (n, 3) while the controllers head for a pose."""
    q, now, seen, places = ARM.home.copy(), np.zeros(8), [], []
    for _ in range(int(duration_s / PERIOD_S)):
        X_WH, J = ARM.pose_and_jacobian(q)
        wanted = cartesian_velocity_to_joints(
            cartesian_position_velocity(X_target, X_WH), J, q, **BOUNDS
        )
        wanted = add_null_space_velocity(wanted, J, q, **BOUNDS)
        now = limited_joint_velocity(wanted, q, now, ARM.limits)
        q = ARM.clamped(q + PERIOD_S * now)
        seen.append(now)
        places.append(X_WH[:3, 3])
    return np.array(seen), np.array(places)


@pytest.mark.parametrize("place", [[3.0, 0.0, 1.0], [-1.5, 0.5, 0.8], [0.0, 0.0, 1.2]])
def test_beyond_reach_the_hand_comes_to_rest_and_the_arm_to_a_crawl(place):
    X_target = ARM.pose(ARM.home)
    X_target[:3, 3] = place
    assert not rollout(ARM, ARM.home, [X_target]).reached  # It is refused before it begins.
    velocities, places = followed(X_target, 12.0)
    last = -int(2.0 / PERIOD_S)
    assert np.abs(velocities[last:]).max() < 0.15 * FASTEST.min()
    assert np.ptp(places[last:], axis=0).max() < 0.01


def test_a_goal_within_reach_ends_at_rest():
    X_target = ARM.pose(ARM.home)
    X_target[:3, 3] += [0.15, 0.1, -0.1]
    assert np.abs(followed(X_target, 6.0)[0][-1]).max() < 0.02


def test_poses_that_are_none_are_refused():
    with pytest.raises(BadInput, match="pose"):
        cartesian_position_velocity(np.full((4, 4), np.nan), RigidTransform().GetAsMatrix4())
