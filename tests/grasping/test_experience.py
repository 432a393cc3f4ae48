import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from vh_drake.grasping.experience import discounts
from vh_drake.types import Candidates


def poses(shifts_m, turns_rad):
    X = np.tile(np.eye(4), (len(shifts_m), 1, 1))
    X[:, 0, 3] = shifts_m
    X[:, :3, :3] = Rotation.from_rotvec(np.outer(turns_rad, [0, 0, 1])).as_matrix()
    return X


def candidates(shifts_m, turns_rad, motion="side"):
    n = len(shifts_m)
    return Candidates(poses(shifts_m, turns_rad), (motion,) * n, ("surface",) * n)


def test_without_failures_nothing_is_discounted():
    np.testing.assert_array_equal(discounts(candidates([0.0, 0.1], [0.0, 1.0]), []), [1.0, 1.0])


def test_the_failed_grasp_is_worth_nothing_and_others_more_the_less_they_are_like_it():
    tried = candidates([0.0, 0.02, 0.04, 0.2], [0.0, 0.0, 0.0, 0.0])
    factor = discounts(tried, [(np.eye(4), "side")])
    assert factor[0] == pytest.approx(0.0)
    assert np.all(np.diff(factor) > 0)
    assert factor[3] == pytest.approx(1.0, abs=1e-6)


def test_another_heading_or_motion_is_another_grasp():
    turned = discounts(candidates([0.0, 0.0], [0.3, 2.0]), [(np.eye(4), "side")])
    assert turned[0] < 0.3
    assert turned[1] > 0.99
    other = discounts(candidates([0.0], [0.0], "collect"), [(np.eye(4), "side")])
    np.testing.assert_array_equal(other, [1.0])


def test_discounts_do_not_change_when_everything_moves_together():
    X = np.eye(4)
    X[:3, :3] = Rotation.from_rotvec([0.3, -0.5, 0.8]).as_matrix()
    X[:3, 3] = [0.4, 0.1, -0.2]
    tried = candidates([0.0, 0.01, 0.03], [0.1, 0.5, 0.2])
    moved = Candidates(X @ tried.X_WH, tried.motion, tried.planner)
    failed = poses([0.01], [0.2])[0]
    np.testing.assert_allclose(
        discounts(moved, [(X @ failed, "side")]), discounts(tried, [(failed, "side")]), atol=1e-9
    )
