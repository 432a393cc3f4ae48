import dataclasses as dc

import numpy as np
import pytest
from scipy.optimize import brentq, fsolve

from vh_drake.errors import BadInput
from vh_drake.hand.tendon import SprungJoints
from vh_drake.hand.tendon_finger import LEVERS, SEGMENT_LENGTHS_M, TendonFinger, thesis_finger


def random_finger(seed, lever):
    """One to twelve joints of very different springs, levers and ranges."""
    rng = np.random.default_rng(seed)
    n = rng.integers(1, 13)
    return TendonFinger(
        stiffness=10 ** rng.uniform(-3, 0, n),
        preload=rng.uniform(0.01, 1.9, n),
        lever_open_m=rng.uniform(2e-3, 20e-3, n),
        length_m=rng.uniform(2e-3, 30e-3, n),
        upper=rng.uniform(0.1, np.pi / 2, n),
        lever=lever,
    )


@pytest.mark.parametrize("lever", LEVERS)
@pytest.mark.parametrize("seed", range(12))
def test_springs_stops_and_tendon_are_in_equilibrium_to_rounding(seed, lever):
    finger = random_finger(seed, lever)
    shortening = np.linspace(0, finger.closed_m, 401)[1:]
    state = finger.equilibrium(shortening)
    np.testing.assert_allclose(
        state.angles @ finger.shortening_per_rad, shortening, rtol=0, atol=1e-14 * finger.closed_m
    )
    force, tension = finger.holding_force(state.angles), state.tension_n[:, None]
    opened, closed = state.angles == 0.0, state.angles == finger.upper
    between = ~(opened | closed)
    slack = 1e-12 * tension
    assert np.all(np.where(between, np.abs(force - tension), 0) <= slack)
    assert np.all(np.where(opened, force - tension, 0) >= -slack)  # the stop pushes, never pulls
    assert np.all(np.where(closed, tension - force, 0) >= -slack)
    assert ((state.angles >= 0) & (state.angles <= finger.upper)).all()


@pytest.mark.parametrize("lever", LEVERS)
@pytest.mark.parametrize("seed", range(4))
def test_angles_and_tension_grow_with_the_shortening(seed, lever):
    finger = random_finger(seed, lever)
    state = finger.equilibrium(np.linspace(0, finger.closed_m, 2001))
    assert (np.diff(state.angles, axis=0) >= -1e-14).all()
    assert (np.diff(state.tension_n) >= -1e-12 * state.tension_n.max()).all()


@pytest.mark.parametrize("shortening", [0.012, 0.02, 0.03])
def test_the_printed_equations_hold_where_no_joint_is_at_a_stop(shortening):
    finger = thesis_finger()
    k, theta_0 = np.rad2deg([0.67e-3, 0.82e-3, 0.82e-3]), np.deg2rad([30, 30, 35])

    def equations(theta):  # 4.16 to 4.18, 4.12 with a quarter of pi
        lever = np.sqrt(2) * 7.5e-3 * np.sin(np.pi / 4 + theta / 2)
        f1, f2, f3 = k * (theta + theta_0) / lever
        return [(theta * 2 / np.pi * 0.015).sum() / shortening - 1, f1 - f2, f2 - f3]

    root = fsolve(equations, [0.5, 0.4, 0.3], xtol=1e-13)
    np.testing.assert_allclose(finger.equilibrium(shortening).angles, root, atol=1e-12)


def test_beyond_a_stop_the_other_joints_share_the_tendon():
    finger = thesis_finger()
    shortening = 0.040
    state = finger.equilibrium(shortening)
    assert state.angles[0] == np.pi / 2

    def medial(theta):  # the distal joint takes what the medial one leaves
        rest = shortening / finger.shortening_per_rad[0] - np.pi / 2 - theta
        force = finger.holding_force(np.array([np.pi / 2, theta, rest]))
        return force[1] - force[2]

    assert state.angles[1] == pytest.approx(brentq(medial, 0.5, 1.5, xtol=1e-15), abs=1e-13)


def test_table_4_4_s_levers_grow_from_7_5_to_10_6_mm():
    levers = thesis_finger().levers(np.array([0.0, np.pi / 2, np.pi / 2]))
    np.testing.assert_allclose(levers, [7.5e-3, 10.6e-3, 10.6e-3], rtol=1e-3)
    assert SEGMENT_LENGTHS_M.sum() == pytest.approx(0.129)


def test_a_constant_lever_does_the_work_that_the_shortening_takes():
    finger = thesis_finger("constant")
    shortening = np.linspace(0.008, 0.034, 20001)  # no joint at a stop
    state = finger.equilibrium(shortening)
    energy = (finger.stiffness * (state.angles + finger.preload) ** 2 / 2).sum(axis=1)
    work = np.gradient(energy, shortening)  # dE = F dL
    np.testing.assert_allclose(work[1:-1], state.tension_n[1:-1], rtol=1e-6)


def test_the_constant_lever_is_the_law_of_the_simulated_hand():
    finger = thesis_finger("constant")
    springs = SprungJoints(finger.stiffness, finger.preload, finger.upper)
    shares = np.linspace(0, 1, 57)
    angles = finger.equilibrium(shares * finger.closed_m).angles
    np.testing.assert_allclose(angles, springs.angles_at_fraction(shares), atol=1e-13)


@pytest.mark.parametrize(("lever", "fingers_pulled"), [("growing", 1), ("constant", 4)])
def test_fingers_on_one_pulley_close_alike(lever, fingers_pulled):
    one = thesis_finger(lever)
    names = ("stiffness", "preload", "lever_open_m", "length_m", "upper")
    four = TendonFinger(*(np.tile(getattr(one, name), 4) for name in names), lever=lever)
    # The motor's travel is the mean over its fingers; a constant lever shrinks with it, so that
    # the tension is then the motor's, shared by four.
    four = dc.replace(four, length_m=four.length_m / 4)
    state, alone = four.equilibrium(0.03), one.equilibrium(0.03)
    np.testing.assert_allclose(state.angles.reshape(4, 3), np.tile(alone.angles, (4, 1)))
    assert state.tension_n == pytest.approx(fingers_pulled * alone.tension_n, rel=1e-12)


def test_a_blocked_joint_leaves_the_tendon_to_the_others():
    finger = thesis_finger()
    blocked = dc.replace(finger, upper=np.array([np.deg2rad(20), *finger.upper[1:]]))
    free, held = finger.equilibrium(0.02), blocked.equilibrium(0.02)
    assert held.angles[0] == pytest.approx(np.deg2rad(20))
    assert (held.angles[1:] > free.angles[1:]).all()
    assert held.tension_n > free.tension_n


def test_torques_are_those_of_the_springs_where_joints_are_free():
    finger = thesis_finger()
    state = finger.equilibrium(0.025)
    springs = finger.stiffness * (state.angles + finger.preload)
    np.testing.assert_allclose(finger.torques(state), springs, rtol=1e-13)


def test_a_slack_tendon_pulls_nothing():
    for finger in (thesis_finger(lever) for lever in LEVERS):
        state = finger.equilibrium(np.array([-0.01, 0.0]))
        np.testing.assert_array_equal(state.angles, 0.0)
        np.testing.assert_array_equal(state.tension_n, 0.0)


def test_shapes_follow_the_shortenings():
    state = thesis_finger().equilibrium(np.full((2, 5), 0.01))
    assert state.angles.shape == (2, 5, 3)
    assert state.tension_n.shape == (2, 5)
    assert thesis_finger().equilibrium(0.01).angles.shape == (3,)


@pytest.mark.parametrize("shortening", [0.0451, np.nan, np.inf])
def test_more_than_the_joints_take_is_refused(shortening):
    with pytest.raises(BadInput, match="shortening"):
        thesis_finger().equilibrium([0.01, shortening])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"stiffness": np.array([0.0, 1, 1])}, "stiffness"),
        ({"length_m": np.array([np.nan, 1, 1])}, "length_m"),
        ({"preload": np.array([2.5, 1, 1])}, "preload"),
        ({"upper": np.array([2.0, 1, 1])}, "upper"),
        ({"lever": "square"}, "choose one of: growing, constant"),
    ],
)
def test_a_finger_that_can_not_be_is_refused(change, message):
    with pytest.raises(BadInput, match=message):
        dc.replace(thesis_finger(), **change)
