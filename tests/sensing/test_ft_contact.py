import numpy as np
import pytest
from pydrake.math import RotationMatrix

from vh_drake.sensing.contact_point import capsule_skin
from vh_drake.sensing.ft_contact import FtContactModel, FtContactSettings, FtSample, FtState
from vh_drake.sensing.hand_load import HandInertia, HandMotion, own_load
from vh_drake.sensing.wrist_noise import wrist_noise

SKIN = capsule_skin(np.array([0.03, -0.01, 0.105]), np.array([0.03, -0.01, 0.134]), 0.0086)
R_WH = RotationMatrix.MakeYRotation(2.0).matrix()
APPROACH = np.array([0.0, 0.0, -1.0])
DT = 0.002
PERIODS_S = [0.001, DT, 0.0025, 0.004, 0.005]


def sample(t, *, seed=0, external=None, velocity=None, acceleration=None, R=R_WH, tare=1.0):
    velocity = 0.03 * np.concatenate([np.zeros(3), APPROACH]) if velocity is None else velocity
    acceleration = np.zeros(6) if acceleration is None else acceleration
    motion = HandMotion(R, velocity[:3], acceleration[:3], acceleration[3:])
    wrench = own_load(HandInertia(), motion) + wrist_noise(t, seed)
    if external is not None:
        wrench = wrench + external
    p_WH = np.array([0.7, -0.3, 1.1]) + velocity[3:] * t
    return FtSample(wrench, R, p_WH, velocity, acceleration, APPROACH, tare)


def tared(model, seed):
    """After 0.2 s without a tare and one tare."""
    state, dt = FtState(), model.settings.period_s
    for i in range(round(0.2 / dt)):
        state = model.step(state, sample(dt * i, seed=seed, tare=0.0))
    return model.step(state, sample(0.2, seed=seed))


def push(point, force_W):
    force = R_WH.T @ force_W
    return np.concatenate([np.cross(point, force), force])


def touch(model, seed, force_n, point):
    """Seconds from contact to detection, and the state, for an object that slides at force_n."""
    state, dt = tared(model, seed), model.settings.period_s
    for i in range(round(1.0 / dt)):
        ramp = force_n * min(1.0, i * dt / 0.03)
        external = push(point, -ramp * APPROACH)
        state = model.step(state, sample(0.2 + dt * (i + 1), seed=seed, external=external))
        if len(state.contact):
            return dt * i, state
    return np.inf, state


@pytest.mark.parametrize("dt", PERIODS_S)
def test_no_false_alarm_within_ten_seconds_of_steady_approach(dt):
    model = FtContactModel(SKIN, settings=FtContactSettings(period_s=dt))
    for seed in range(3):
        state, largest = tared(model, seed), 0.0
        for i in range(round(10.0 / dt)):
            state = model.step(state, sample(0.2 + dt * (i + 1), seed=seed))
            largest = max(largest, float(np.linalg.norm(state.force_W)))
        assert len(state.contact) == 0
        assert largest < 0.06


@pytest.mark.parametrize(
    ("dt", "force_n", "delay_s"),
    [
        *(
            (dt, *light)
            for dt in (0.001, DT)
            for light in ((0.12, 0.09), (0.15, 0.06), (0.4, 0.04))
        ),
        *(
            (dt, *light)
            for dt in (0.0025, 0.004)
            for light in ((0.12, 0.09), (0.15, 0.065), (0.4, 0.0425))
        ),
        *((0.005, *light) for light in ((0.12, 0.1), (0.15, 0.075), (0.4, 0.05))),
    ],
)
def test_light_objects_are_felt_before_they_slide_far(dt, force_n, delay_s):
    model = FtContactModel(SKIN, settings=FtContactSettings(period_s=dt))
    delays = [touch(model, seed, force_n, SKIN.p_H[40])[0] for seed in range(12)]
    assert np.max(delays) < delay_s


@pytest.mark.parametrize(
    ("period_s", "hold"),
    [(0.0005, 17), (0.001, 9), (0.002, 5), (0.0025, 5), (0.004, 3), (0.005, 3)],
)
def test_samples_in_a_row_span_what_has_to_last(period_s, hold):
    settings = FtContactSettings(period_s=period_s)
    assert settings.samples(settings.hold_s) == hold
    assert settings.samples(0.0) == 1


@pytest.mark.parametrize("dt", PERIODS_S)
def test_place_and_normal_of_a_touch_are_found(dt):
    model = FtContactModel(SKIN, settings=FtContactSettings(period_s=dt))
    down = int(np.argmin(SKIN.n_H @ R_WH.T @ -APPROACH))
    p_errors, n_errors = [], []
    for seed in range(20):
        _, state = touch(model, seed, 0.3, SKIN.p_H[down])
        true = sample(0.0).p_WH + R_WH @ SKIN.p_H[down]
        found = state.contact.p_WC[0]
        p_errors.append(np.linalg.norm((found - true)[:2]))  # z moves with the hand
        n_errors.append(np.arccos(np.clip(state.contact.n_WC[0] @ -APPROACH, -1.0, 1.0)))
    assert np.median(p_errors) < 0.006
    assert np.rad2deg(np.max(n_errors)) < 12.0


@pytest.mark.parametrize("dt", PERIODS_S)
def test_turning_and_speeding_up_the_hand_is_no_contact(dt):
    model = FtContactModel(SKIN, settings=FtContactSettings(period_s=dt))
    state = tared(model, 0)
    for i in range(round(1.0 / dt)):
        t = dt * i
        R = RotationMatrix.MakeZRotation(0.2 * t**2).matrix() @ R_WH
        velocity = np.array([0, 0, 0.4 * t, 0.1 * (1.0 - np.cos(t)), 0, -0.03])
        acceleration = np.array([0, 0, 0.4, 0.1 * np.sin(t), 0, 0])
        state = model.step(
            state, sample(0.2 + dt + t, velocity=velocity, acceleration=acceleration, R=R)
        )
    assert len(state.contact) == 0


def test_nothing_touches_before_the_first_tare_and_a_new_tare_forgets():
    model = FtContactModel(SKIN)
    state = FtState()
    hard = push(SKIN.p_H[0], np.array([0.0, 0.0, 5.0]))
    for i in range(200):
        state = model.step(state, sample(DT * i, external=hard * (i > 50), tare=0.0))
    assert len(state.contact) == 0
    for i in range(200, 400):
        state = model.step(state, sample(DT * i, external=hard * (i < 300)))
    assert len(state.contact) == 1
    state = model.step(state, sample(0.8, tare=2.0))
    assert len(state.contact) == 0
    np.testing.assert_array_equal(state.force_W, 0.0)


def test_the_contact_stays_latched_when_the_force_goes():
    model = FtContactModel(SKIN)
    down = int(np.argmin(SKIN.n_H @ R_WH.T @ -APPROACH))
    after, state = touch(model, 0, 0.4, SKIN.p_H[down])
    first = state.contact
    for i in range(100):
        state = model.step(state, sample(0.202 + after + DT * i))
    np.testing.assert_allclose(state.contact.p_WC, first.p_WC, atol=0.005)
    latched = state.contact
    for i in range(100, 300):
        state = model.step(state, sample(0.202 + after + DT * i))
    np.testing.assert_array_equal(state.contact.p_WC, latched.p_WC)
    np.testing.assert_array_equal(state.contact.n_WC, latched.n_WC)
    assert np.linalg.norm(state.force_W) < 0.06


def test_a_jump_of_the_force_is_felt_before_the_low_pass_tells_it():
    model = FtContactModel(SKIN)
    slow = FtContactModel(SKIN, settings=FtContactSettings(jump_n=100.0))
    at_once, filtered = (touch(m, 0, 5.0, SKIN.p_H[40])[0] for m in (model, slow))
    assert at_once < filtered - 0.003
    assert at_once < 0.014


@pytest.mark.parametrize("dt", PERIODS_S)
def test_a_jolt_of_the_arm_is_no_contact(dt):
    model = FtContactModel(SKIN, settings=FtContactSettings(period_s=dt))
    state = tared(model, 0)
    for i in range(round(0.4 / dt)):
        t = dt * (i + 1)
        jolt = push(SKIN.p_H[0], np.array([0.0, 0.0, 0.9])) if 0.1 < t < 0.104 else None
        state = model.step(state, sample(0.2 + t, external=jolt))
    assert len(state.contact) == 0


def test_a_touch_that_lasts_an_instant_is_placed_as_well_as_one_that_lasts():
    model = FtContactModel(SKIN)
    down = int(np.argmin(SKIN.n_H @ R_WH.T @ -APPROACH))
    errors = []
    for seed in range(10):
        state = tared(model, seed)
        for i in range(100):
            external = push(SKIN.p_H[down], -2.0 * APPROACH) if i < 12 else None
            state = model.step(state, sample(0.202 + DT * i, seed=seed, external=external))
            if len(state.contact) and i < 60:
                p_WH = sample(0.202 + DT * i).p_WH
                last = R_WH.T @ (state.contact.p_WC[0] - p_WH) - SKIN.p_H[down]
        errors.append(np.linalg.norm(last))
    assert np.median(errors) < 0.004


def test_all_of_the_state_comes_back_from_its_numbers():
    model = FtContactModel(SKIN)
    _, state = touch(model, 3, 0.5, SKIN.p_H[40])
    again = FtState.from_vector(state.to_vector())
    np.testing.assert_array_equal(again.to_vector(), state.to_vector())
    push_on = sample(0.5, seed=3, external=push(SKIN.p_H[40], -0.5 * APPROACH))
    np.testing.assert_array_equal(
        model.step(again, push_on).to_vector(), model.step(state, push_on).to_vector()
    )


def test_a_fast_hand_needs_a_higher_force():
    model = FtContactModel(SKIN, settings=FtContactSettings(fast_speed_m_s=0.02))
    assert touch(model, 0, 0.3, SKIN.p_H[40])[0] == np.inf
    assert touch(model, 0, 0.8, SKIN.p_H[40])[0] < 0.1


def test_a_sample_that_is_not_finite_changes_nothing():
    model = FtContactModel(SKIN)
    state = tared(model, 0)
    assert model.step(state, sample(0.3, external=np.full(6, np.nan))) is state
