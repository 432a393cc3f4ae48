import numpy as np
from scipy.spatial.transform import Rotation

from vh_drake.grasping.diversity import pose_features, spread


def some_poses(count, seed):
    rng = np.random.default_rng(seed)
    X = np.tile(np.eye(4), (count, 1, 1))
    X[:, :3, :3] = Rotation.random(count, random_state=seed).as_matrix()
    X[:, :3, 3] = rng.normal(0, 0.05, (count, 3))
    return X


def least_distance(X, hand):
    features = pose_features(X, hand)
    distances = np.linalg.norm(features[:, None] - features[None], axis=2)
    return distances[~np.eye(len(X), dtype=bool)].min()


def test_kept_poses_are_farther_apart_than_random_ones(hand):
    X = some_poses(300, 0)
    kept = spread(X, np.zeros(300), hand, 30)
    assert len(set(kept)) == 30
    assert least_distance(X[kept], hand) > 2 * least_distance(X[:30], hand)


def test_duplicates_come_last(hand):
    X = np.concatenate([some_poses(5, 1)] * 3)
    kept = spread(X, np.zeros(15), hand, 5)
    assert len(set(kept % 5)) == 5


def test_both_kinds_are_kept(hand):
    X = some_poses(40, 2)
    kept = spread(X, np.arange(40) == 7, hand, 5)
    assert 7 in kept


def test_nothing_to_choose_from_gives_nothing(hand):
    assert len(spread(np.zeros((0, 4, 4)), np.zeros(0), hand, 5)) == 0


def test_a_small_turn_counts_as_its_angle(hand):
    X = some_poses(2, 3)
    X[1] = X[0]
    tcp = np.asarray(hand.description.tcps["power"])
    X[1, :3, :3] = X[0, :3, :3] @ Rotation.from_rotvec([0, 0.01, 0]).as_matrix()
    X[1, :3, 3] += (X[0, :3, :3] - X[1, :3, :3]) @ tcp
    a, b = pose_features(X, hand)
    np.testing.assert_allclose(np.linalg.norm(a - b), 0.06 * 0.01, rtol=1e-3)
