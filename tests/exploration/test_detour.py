import numpy as np
import pytest

from vh_drake.exploration.detour import way_around
from vh_drake.exploration.trajectory import position

CENTER, RADIUS = np.array([0.1, -0.2, 0.3]), 0.15


def way(u, v):
    p, q = CENTER + 0.05 * np.asarray(u, float), CENTER + 0.05 * np.asarray(v, float)
    return way_around(
        p, np.asarray(u, float), q, np.asarray(v, float), center=CENTER, radius_m=RADIUS
    )


@pytest.mark.parametrize("v", [[0, 0, 1], [0, 0.6, 0.8], [0, 0, -1], [1, 0, 0]])
def test_it_joins_its_ends_without_a_gap(v):
    curves = way([0, 0, 1], v)
    np.testing.assert_allclose(curves[0, 0], CENTER + np.array([0, 0, 0.05]))
    np.testing.assert_allclose(curves[-1, 3], CENTER + 0.05 * np.asarray(v))
    np.testing.assert_allclose(curves[:-1, 3], curves[1:, 0], atol=1e-9)


@pytest.mark.parametrize("v", [[0, 0.6, 0.8], [0, 0, -1], [1, 0, 0]])
def test_between_its_ends_it_stays_on_the_sphere(v):
    for curve in way([0, 0, 1], v)[1:-1]:
        for tau in np.linspace(0, 1, 9):
            distance = np.linalg.norm(position(curve, tau) - CENTER)
            assert distance == pytest.approx(RADIUS, rel=1e-4)


def test_it_comes_to_its_end_against_the_normal():
    end = way([0, 0, 1], [0, 0, -1])[-1]
    direction = end[3] - end[0]
    np.testing.assert_allclose(direction / np.linalg.norm(direction), [0, 0, 1], atol=1e-12)
