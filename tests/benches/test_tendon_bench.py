import numpy as np
import pytest

from vh_drake.benches.tendon import energy, free_targets, minimise, peer_row
from vh_drake.hand.tendon_finger import thesis_finger

FINGER = thesis_finger()
NOTHING = np.empty(0)


def test_the_objective_vanishes_at_the_equilibrium_alone():
    target = 0.02
    angles = FINGER.equilibrium(target).angles
    value = energy(FINGER, target)
    assert value(angles, NOTHING) < 1e-25
    for step in 1e-3 * np.vstack([np.eye(3), -np.eye(3)]):
        assert value(angles + step, NOTHING) > 1e-6


def test_the_gradient_matches_finite_differences():
    value, h = energy(FINGER, 0.02), 1e-6
    angles, gradient = np.array([0.7, 0.3, 1.2]), np.empty(3)
    value(angles, gradient)
    steps = h * np.eye(3)
    numeric = [(value(angles + s, NOTHING) - value(angles - s, NOTHING)) / (2 * h) for s in steps]
    np.testing.assert_allclose(gradient, numeric, rtol=1e-7)


def test_no_joint_is_at_a_stop_at_the_targets():
    angles = FINGER.equilibrium(free_targets(FINGER, 5)).angles
    assert ((angles > 0) & (angles < FINGER.upper)).all()


@pytest.mark.parametrize("name", ["LN_PRAXIS", "LN_NELDERMEAD", "LD_SLSQP"])
def test_nlopt_finds_the_same_angles(name):
    pytest.importorskip("nlopt")
    targets = free_targets(FINGER, 4)
    found = minimise(FINGER, targets, name)
    np.testing.assert_allclose(found, FINGER.equilibrium(targets).angles, atol=1e-6)


def test_a_row_counts_evaluations_and_compares_times():
    pytest.importorskip("nlopt")
    row = peer_row(FINGER, free_targets(FINGER, 2), "LD_LBFGS", ours_us=0.1)
    assert row["derivatives"]
    assert row["evaluations"] > 1
    assert row["speedup"] == pytest.approx(row["solve_us"] / 0.1, rel=0.1)
