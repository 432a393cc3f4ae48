import numpy as np
import pytest
from scipy.spatial.distance import cdist

from vh_drake.errors import BadInput
from vh_drake.gpis.evidence import farthest_points, kept_apart, require_finite
from vh_drake.types import ContactSet, ObjectView


def test_farthest_points_cover_a_grid_better_than_random_ones():
    grid = np.stack(np.meshgrid(*[np.arange(12.0)] * 2, [0.0]), axis=-1).reshape(-1, 3)
    chosen = farthest_points(grid, 16)
    assert len(set(chosen)) == 16
    gaps = np.linalg.norm(grid[:, None] - grid[chosen][None], axis=2).min(axis=1)
    random = np.random.default_rng(0).choice(len(grid), 16, replace=False)
    random_gaps = np.linalg.norm(grid[:, None] - grid[random][None], axis=2).min(axis=1)
    assert gaps.max() < 0.8 * random_gaps.max()


def test_few_points_are_all_kept():
    np.testing.assert_array_equal(farthest_points(np.zeros((3, 3)), 100), [0, 1, 2])


def test_what_is_kept_is_apart_and_what_is_not_is_near():
    p = np.random.default_rng(0).random((200, 3))
    order = np.random.default_rng(1).permutation(200)
    kept = kept_apart(p, order, 0.3)
    assert kept[0] == order[0]
    apart = cdist(p[kept], p[kept]) + np.eye(len(kept))
    assert apart.min() >= 0.3
    assert cdist(p, p[kept]).min(axis=1).max() < 0.3


UP = np.array([[0.0, 0.0, 1.0]])


@pytest.mark.parametrize(
    ("points", "normals", "message"),
    [
        (np.array([[np.nan, 0, 0]]), UP, "NaN"),
        (np.zeros((1, 3)), 3.0 * UP, "unit length"),
        (np.zeros((2, 3)), UP, "shape"),
        (np.zeros((0, 3)), np.zeros((0, 3)), "neither"),
    ],
)
def test_unusable_points_are_named(points, normals, message):
    with pytest.raises(BadInput, match=message):
        require_finite(ObjectView(points, normals), ContactSet())
    if len(points):
        with pytest.raises(BadInput, match=message):
            require_finite(ObjectView(), ContactSet(points, normals))
