import numpy as np
import pytest
from scenery import CAN, RADIUS, can_scene
from scipy.stats import multivariate_t

from vh_drake.exploration.felt_shift import felt_shift
from vh_drake.geometry.signed_distance import interpolate

TIP_M = 0.008
LEVEL = np.diag([0.012**2, 0.007**2, 0.0])
X = np.array([1.0, 0.0, 0.0])


def approach(shift_m, way_m=0.05, beside_m=0.0):
    """A ball (8, 1, 3) that comes from +x until it touches a can that is shifted along x."""
    start = CAN + np.array([RADIUS + TIP_M + shift_m, beside_m, 0.0])
    return np.array([[start + way * X] for way in np.linspace(way_m, 0.0, 8)])


def felt(centers, covariance=LEVEL):
    return felt_shift(can_scene().distance, centers, np.array([TIP_M]), covariance)


@pytest.mark.parametrize("shift_m", [-0.02, -0.005, 0.004, 0.015])
def test_a_touch_tells_the_shift_along_its_way(shift_m):
    mean, after = felt(approach(shift_m))
    assert mean[0] == pytest.approx(shift_m, abs=3e-3)
    assert np.sqrt(after[0, 0]) < 0.006
    # Across the way it tells nothing of which side, but a large shift tells that others may be.
    assert abs(mean[1]) < 2e-3
    assert 0.5 < after[1, 1] / LEVEL[1, 1] < 5.0
    assert mean[2] == after[2, 2] == 0.0


def test_where_it_touches_as_expected_nothing_moves():
    mean, after = felt(approach(0.0))
    np.testing.assert_allclose(mean, 0.0, atol=1.5e-3)
    assert after[0, 0] < LEVEL[0, 0]


def test_it_is_the_mean_of_the_posterior():
    centers = approach(0.012, beside_m=0.015)
    prior = multivariate_t(np.zeros(2), LEVEL[:2, :2], df=3)
    rng = np.random.default_rng(2)
    shifts = rng.uniform(-0.06, 0.06, (40_000, 2))
    weight = prior.pdf(shifts)
    for k, center in enumerate(centers[:, 0]):
        points = center - np.column_stack([shifts, np.zeros(len(shifts))])
        gaps = interpolate(can_scene().distance, points)[0] - TIP_M
        gaps = gaps if k + 1 == len(centers) else np.minimum(gaps, 0.0)
        weight = weight * np.exp(-0.5 * (gaps / 0.003) ** 2)
    expected = weight @ shifts / weight.sum()
    mean, after = felt(centers)
    np.testing.assert_allclose(mean[:2], expected, atol=1.5e-3)
    left = shifts - expected
    spread = (weight[:, None] * left).T @ left / weight.sum()
    np.testing.assert_allclose(after[:2, :2], spread, atol=0.15 * np.trace(spread))


def test_a_hand_did_not_pass_through_the_object_on_its_way():
    """A ball that stops beyond the can, where only a can that lies aside lets it pass."""
    start = CAN + np.array([0.10, 0.030, 0.0])
    centers = np.array([[start - way * X] for way in np.linspace(0.0, 0.13, 8)])
    blocked, _ = felt(centers, np.diag([0.012**2, 0.012**2, 0.0]))
    only_end, _ = felt(centers[-1:], np.diag([0.012**2, 0.012**2, 0.0]))
    assert blocked[1] < only_end[1] - 0.003


def test_it_turns_with_the_covariance():
    c, s = np.cos(0.7), np.sin(0.7)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    mean, after = felt(approach(0.01))
    turned = (approach(0.01) - CAN) @ R.T + CAN  # The can is round.
    mean_turned, after_turned = felt(turned, R @ LEVEL @ R.T)
    np.testing.assert_allclose(mean_turned, R @ mean, atol=1e-3)
    np.testing.assert_allclose(after_turned, R @ after @ R.T, atol=5e-6)
