import numpy as np
from pydrake.math import RotationMatrix

from vh_drake.sensing.hand_load import GRAVITY_W, HandInertia, HandMotion, own_load

RNG = np.random.default_rng(0)
MASSES = RNG.uniform(0.02, 0.3, 6)
POINTS = RNG.uniform(-0.1, 0.1, (6, 3))  # of the masses, in H


def body() -> HandInertia:
    centre = MASSES @ POINTS / MASSES.sum()
    I_H = sum(
        m * ((p @ p) * np.eye(3) - np.outer(p, p)) for m, p in zip(MASSES, POINTS, strict=True)
    )
    return HandInertia(float(MASSES.sum()), centre, I_H)


def motion(**changes) -> HandMotion:
    rest = {"R_WH": RotationMatrix.MakeXRotation(0.7).matrix(), "w_WH": np.zeros(3),
            "alpha_WH": np.zeros(3), "a_WH": np.zeros(3)}  # fmt: skip
    return HandMotion(**(rest | changes))


def test_a_body_of_point_masses_loads_the_sensor_as_newton_says():
    moving = motion(w_WH=RNG.standard_normal(3), alpha_WH=RNG.standard_normal(3),
                    a_WH=RNG.standard_normal(3))  # fmt: skip
    expected = np.zeros(6)
    for mass, p_H in zip(MASSES, POINTS, strict=True):
        r = moving.R_WH @ p_H
        a = moving.a_WH + np.cross(moving.alpha_WH, r)
        a += np.cross(moving.w_WH, np.cross(moving.w_WH, r))
        force = moving.R_WH.T @ (mass * (GRAVITY_W - a))
        expected += np.concatenate([np.cross(p_H, force), force])
    np.testing.assert_allclose(own_load(body(), moving), expected, atol=1e-12)


def test_at_rest_only_the_weight_remains():
    load = own_load(HandInertia(), motion(R_WH=np.eye(3)))
    np.testing.assert_allclose(load[3:], [0.0, 0.0, -9.81 * 0.985765])


def test_in_free_fall_the_sensor_shows_nothing():
    np.testing.assert_allclose(own_load(body(), motion(a_WH=GRAVITY_W)), 0.0, atol=1e-12)
