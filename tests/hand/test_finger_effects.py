import dataclasses as dc

import numpy as np
import pytest

from vh_drake.errors import BadInput
from vh_drake.hand.finger_effects import GRAVITY_M_S2, FingerEffects, closing
from vh_drake.hand.tendon_finger import LEVERS, SEGMENT_LENGTHS_M, thesis_finger

WEIGHT = FingerEffects(
    mass_kg=np.array([0.014, 0.013, 0.012]), segment_m=SEGMENT_LENGTHS_M, down_rad=np.pi / 2
)
ALL = dc.replace(
    WEIGHT,
    tendon_friction=0.15,
    wrap_rad=0.4,
    joint_friction_nm=np.array([1e-3, 2e-3, 3e-3]),
    glove_nm=np.array([4e-3, 15e-3, 10e-3]),
    glove_angle_rad=0.1,
)
SHORTENING = np.linspace(0.0, 0.045, 46)


def height_energy(angles, effects):
    """Potential energy of segments whose centres are in their middles [J]."""
    directions = np.cumsum(angles)
    steps = effects.segment_m[:, None] * np.column_stack([np.cos(directions), np.sin(directions)])
    centers = np.cumsum(steps, axis=0) - steps / 2
    down = np.array([np.cos(effects.down_rad), np.sin(effects.down_rad)])
    return -GRAVITY_M_S2 * effects.mass_kg @ (centers @ down)


@pytest.mark.parametrize("lever", LEVERS)
def test_without_effects_the_finger_closes_as_its_springs_alone(lever):
    finger = thesis_finger(lever)
    state, expected = closing(finger, FingerEffects(), SHORTENING), finger.equilibrium(SHORTENING)
    np.testing.assert_allclose(state.angles, expected.angles, atol=1e-12)
    taut = slice(1, -1)  # At the ends any smaller or larger tension does as well.
    np.testing.assert_allclose(state.tension_n[taut], expected.tension_n[taut], rtol=1e-12)


@pytest.mark.parametrize("down_deg", [0, 90, -90, 140])
def test_weight_torques_are_the_slope_of_the_energy(down_deg):
    effects = dc.replace(WEIGHT, down_rad=np.deg2rad(down_deg))
    angles, h = np.array([0.3, 0.9, 0.2]), 1e-6
    slope = [
        (height_energy(angles + s, effects) - height_energy(angles - s, effects)) / (2 * h)
        for s in h * np.eye(3)
    ]
    np.testing.assert_allclose(effects.weight_torques(angles), -np.array(slope), rtol=1e-7)


def test_a_palm_that_faces_down_is_closed_by_its_weight_and_one_that_faces_up_opened():
    closed_by = WEIGHT.weight_torques(np.zeros(3))
    assert (closed_by > 0).all()
    upward = dc.replace(WEIGHT, down_rad=-np.pi / 2)
    np.testing.assert_allclose(upward.weight_torques(np.zeros(3)), -closed_by)


def test_tension_falls_along_the_tendon_by_euler_s_formula():
    angles = np.array([0.5, 0.25, 1.0])
    expected = np.exp([0.0, -0.15 * 0.9, -0.15 * (0.9 + 0.65)])
    np.testing.assert_allclose(ALL.tension_shares(angles), expected)


@pytest.mark.parametrize("lever", LEVERS)
def test_every_joint_between_its_stops_is_balanced(lever):
    finger = thesis_finger(lever)
    state = closing(finger, ALL, SHORTENING)
    for angles, tension in zip(state.angles, state.tension_n, strict=True):
        pull = finger.levers(angles) * tension * ALL.tension_shares(angles)
        rest = pull - finger.stiffness * (angles + finger.preload) - ALL.resistance(angles)
        opened, closed = angles < 1e-12, angles > finger.upper - 1e-12
        assert np.abs(rest[~opened & ~closed]).max(initial=0.0) < 1e-12
        assert (rest[opened] <= 1e-12).all()
    np.testing.assert_allclose(
        state.angles[1:] @ finger.shortening_per_rad, SHORTENING[1:], atol=1e-12
    )


def test_friction_lets_the_proximal_joint_go_first():
    finger = thesis_finger()
    friction = FingerEffects(tendon_friction=0.3, wrap_rad=0.5)
    plain, real = (closing(finger, e, SHORTENING).angles for e in (FingerEffects(), friction))
    early = slice(5, 15)
    assert (real[early, 0] > plain[early, 0]).all()
    assert (real[early, 2] <= plain[early, 2]).all()


def test_a_glove_delays_the_joints_that_it_covers_and_costs_tension():
    finger = thesis_finger()
    glove = FingerEffects(glove_nm=np.array([0, 20e-3, 20e-3]))
    plain, real = (closing(finger, e, SHORTENING) for e in (FingerEffects(), glove))
    assert real.angles[12, 1:].max() < plain.angles[12, 1:].min()
    assert (real.tension_n[5:-1] > plain.tension_n[5:-1]).all()


def test_a_heavy_finger_hangs_and_leaves_its_tendon_slack():
    finger = thesis_finger()
    heavy = dc.replace(WEIGHT, mass_kg=np.full(3, 0.02))
    state = closing(finger, heavy, np.array([0.0, 1e-4, 0.02]))
    assert state.angles[0, 0] > np.deg2rad(5)
    np.testing.assert_allclose(state.tension_n[:2], 0.0, atol=1e-12)
    springs = finger.stiffness * (state.angles[0] + finger.preload)
    assert springs[0] == pytest.approx(heavy.weight_torques(state.angles[0])[0], abs=1e-12)
    assert state.tension_n[2] > 0


@pytest.mark.parametrize(
    ("shortening", "message"),
    [([0.02, 0.01], "ascend"), ([-0.01, 0.01], "ascend"), ([0.0, 0.05], "above")],
)
def test_shortenings_that_can_not_be_followed_are_refused(shortening, message):
    with pytest.raises(BadInput, match=message):
        closing(thesis_finger(), FingerEffects(), np.array(shortening))


@pytest.mark.parametrize(
    "change",
    [
        {"tendon_friction": -0.1},
        {"glove_nm": np.array([0, np.nan, 0])},
        {"glove_angle_rad": 0.0},
        {"down_rad": np.inf},
    ],
)
def test_effects_that_can_not_be_are_refused(change):
    with pytest.raises(BadInput):
        FingerEffects(**change)


def test_effects_of_another_number_of_joints_are_refused():
    two = FingerEffects(glove_nm=np.zeros(2), mass_kg=np.zeros(2))
    with pytest.raises(BadInput, match="same number"):
        closing(thesis_finger(), two, SHORTENING)
