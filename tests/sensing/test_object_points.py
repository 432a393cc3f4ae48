import numpy as np
import pytest

from vh_drake.errors import NothingSeen
from vh_drake.sensing.object_points import object_points
from vh_drake.types import Cloud, Plane

TABLE = Plane(np.array([0.0, 0.0, 1.0]), 0.9)
CAMERA = np.array([0.7, -0.3, 2.0])


def cap(count=4000, radius=0.05):
    """Points and normals of the upper part of a ball that touches the table."""
    n = np.random.default_rng(0).normal(size=(count, 3))
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    n = n[n[:, 2] > 0.3]
    return radius * n + [0.7, -0.3, 0.9 + radius], n


def test_normals_point_out_of_a_ball():
    view = object_points(Cloud(cap()[0], CAMERA), TABLE)
    outward = (view.p_WO - [0.7, -0.3, 0.95]) / 0.05
    assert (np.einsum("ij,ij->i", outward, view.n_WO) > 0.9).mean() > 0.98
    np.testing.assert_allclose(np.linalg.norm(view.n_WO, axis=1), 1.0)
    assert view.table is TABLE


def test_points_on_and_below_the_table_are_dropped():
    p, _ = cap()
    table = np.column_stack([p[:, :2], np.full(len(p), 0.902)])
    both = object_points(Cloud(np.vstack([p, table, table - 0.3]), CAMERA), TABLE)
    np.testing.assert_array_equal(both.p_WO, object_points(Cloud(p, CAMERA), TABLE).p_WO)


def test_a_moved_cloud_gives_a_moved_view():
    p, _ = cap()
    shift = np.array([0.3, 0.2, -0.9])
    view = object_points(Cloud(p, CAMERA), TABLE)
    moved = object_points(Cloud(p + shift, CAMERA + shift), Plane(TABLE.normal, 0.0))
    np.testing.assert_allclose(moved.p_WO, view.p_WO + shift, atol=1e-4)


@pytest.mark.parametrize("points", [np.zeros((0, 3)), cap()[0] - [0, 0, 1], np.ones((20, 3))])
def test_too_few_points_over_the_table_are_told_with_their_heights(points):
    with pytest.raises(NothingSeen, match="points lie over the table, 60 are needed"):
        object_points(Cloud(points, CAMERA), TABLE)
