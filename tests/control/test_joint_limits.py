"""No limit of a joint is exceeded, whatever is asked for."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scenery import right_arm

from vh_drake.control import kernels
from vh_drake.control.joint_limits import PERIOD_S, limited_joint_velocity, next_joint_state
from vh_drake.errors import BadInput

ARM = right_arm()
LOWER, UPPER, FASTEST, ACCELERATION = ARM.limits
ANY = st.floats(allow_nan=False, allow_infinity=False, width=64)
ROUNDING = 1e-9


def anything(size):
    """Numbers of every magnitude, and such that tell limits apart."""
    near = st.floats(-3.0, 3.0)
    return arrays(float, size, elements=st.one_of(near, near, ANY))


def step(wanted, q, velocity, period_s=PERIOD_S):
    return limited_joint_velocity(wanted, q, velocity, ARM.limits, period_s=period_s)


@settings(max_examples=60, deadline=None)
@given(
    wanted=st.lists(anything(8), min_size=1, max_size=6),
    shares=arrays(float, 8, elements=st.floats(0.0, 1.0)),
    period_s=st.floats(0.001, 0.1),
)
def test_no_limit_is_exceeded_by_any_commands(wanted, shares, period_s):
    q, velocity = LOWER + shares * (UPPER - LOWER), np.zeros(8)
    for command in [w for w in wanted for _ in range(int(0.1 / period_s) + 1)]:
        after = step(command, q, velocity, period_s)
        assert np.all(np.abs(after) <= FASTEST + ROUNDING)
        assert np.all(np.abs(after - velocity) <= ACCELERATION * period_s + ROUNDING)
        q = q + period_s * after
        assert np.all((q >= LOWER - ROUNDING) & (q <= UPPER + ROUNDING))
        velocity = after


@settings(max_examples=60, deadline=None)
@given(
    wanted=anything(8),
    shares=arrays(float, 8, elements=st.floats(0.0, 1.0)),
    velocity=arrays(float, 8, elements=st.floats(-3.0, 3.0)),
)
def test_the_next_state_goes_on_with_the_limited_velocity(wanted, shares, velocity):
    q = LOWER + shares * (UPPER - LOWER)
    limited = step(wanted, q, velocity)
    after = next_joint_state(wanted, np.concatenate([q, velocity]), ARM.limits)
    np.testing.assert_array_equal(after[8:], limited)
    np.testing.assert_allclose(after[:8], q + PERIOD_S * limited, atol=1e-6)
    assert np.all((after[:8] >= LOWER) & (after[:8] <= UPPER))


@settings(max_examples=100, deadline=None)
@given(wanted=anything(8), q=anything(8), velocity=anything(8))
def test_a_state_beyond_its_limits_is_never_driven_farther(wanted, q, velocity):
    after = step(wanted, q, velocity)
    assert np.all(np.abs(after) <= FASTEST)
    assert np.all(after[q >= UPPER] <= 0.0)
    assert np.all(after[q <= LOWER] >= 0.0)


def test_a_joint_arrives_at_its_limit_at_rest():
    q, velocity = (LOWER + UPPER) / 2, np.zeros(8)
    for _ in range(2000):
        velocity = step(np.full(8, 9.0), q, velocity)
        q = q + PERIOD_S * velocity
    np.testing.assert_allclose(q, UPPER, atol=1e-9)
    np.testing.assert_allclose(velocity, 0.0, atol=1e-9)


def test_wanted_velocities_are_reached_on_a_straight_way():
    start, wanted = np.linspace(-1.0, 1.0, 8), np.linspace(1.0, -0.5, 8)
    velocity, q = start, (LOWER + UPPER) / 2
    for _ in range(30):
        after = step(wanted, q, velocity)
        change, missing = after - velocity, wanted - velocity
        np.testing.assert_allclose(change * missing.max(), missing * change.max(), atol=1e-12)
        velocity = after
    np.testing.assert_allclose(velocity, wanted, atol=1e-12)


def test_velocities_within_all_limits_pass_unchanged():
    wanted = np.full(8, 0.05)
    np.testing.assert_array_equal(step(wanted, (LOWER + UPPER) / 2, wanted), wanted)


@pytest.mark.parametrize("bad", [np.full(8, np.nan), np.full(8, np.inf), np.zeros(7)])
def test_what_is_no_velocity_is_refused(bad):
    with pytest.raises(BadInput, match="finite"):
        step(bad, ARM.home, np.zeros(8))


@pytest.mark.parametrize("odd", [np.nan, np.inf, -np.inf])
def test_numbers_that_are_not_finite_are_found_anywhere(odd):
    x = np.array([[1e308, -1e308, 0.0], [1e-320, 5.0, -0.0]])
    assert kernels.finite(x)
    for place in np.ndindex(x.shape):
        broken = x.copy()
        broken[place] = odd
        assert not kernels.finite(broken)
