import numpy as np
from scenery import right_arm

from vh_drake.control.reach import rollout
from vh_drake.grasping.reachable import reachable


def ways(count, seed):
    """Downward moves of hands over the table, some out of reach."""
    rng = np.random.default_rng(seed)
    arm = right_arm()
    X_WH = np.tile(arm.pose(arm.home), (count, 2, 1, 1))
    X_WH[:, :, :3, 3] = rng.uniform([0.4, -0.7, 1.15], [1.1, 0.3, 1.25], (count, 1, 3))
    X_WH[:, 1, 2, 3] -= 0.15
    turns = rng.uniform(-1.5, 1.5, count)
    for X, turn in zip(X_WH, turns, strict=True):
        c, s = np.cos(turn), np.sin(turn)
        X[:, :3, :3] = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ X[:, :3, :3]
    return X_WH


def test_what_is_reachable_is_what_the_controllers_reach_from_home():
    arm, X_WH = right_arm(), ways(150, 0)
    found = reachable(arm, X_WH)
    rolled = np.array([rollout(arm, arm.home, X).reached for X in X_WH])
    assert 0.2 < rolled.mean() < 0.9
    assert rolled[found].mean() > 0.9
    assert found[rolled].mean() > 0.9


def test_no_ways_are_no_trouble():
    assert reachable(right_arm(), np.zeros((0, 2, 4, 4))).shape == (0,)


def test_the_same_ways_give_the_same_answer():
    X_WH = ways(40, 1)
    np.testing.assert_array_equal(reachable(right_arm(), X_WH), reachable(right_arm(), X_WH))
