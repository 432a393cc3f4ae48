import numpy as np
import pytest

from vh_drake.geometry.sampling import sample_surface
from vh_drake.gpis.edges import EdgeSettings, edge_contacts
from vh_drake.gpis.evidence import farthest_points
from vh_drake.objects import lathe

SIDES = np.array([0.12, 0.06, 0.08])
BOX = lathe.box(tuple(SIDES))


def contacts(mesh, count=60, seed=0):
    p, n = sample_surface(mesh, 3000, seed=seed)
    chosen = farthest_points(p, count)
    return p[chosen], n[chosen]


def test_places_lie_on_the_faces_of_a_box_beside_its_edges():
    p, n = edge_contacts(*contacts(BOX))
    assert len(p) > 40
    gaps = np.stack([p - BOX.bounds[0], BOX.bounds[1] - p])  # to the planes of the six faces
    assert gaps.min() > -EdgeSettings().height_m
    face = np.argmax(abs(n), axis=1)
    side = (n[np.arange(len(n)), face] > 0).astype(int)
    np.testing.assert_allclose(gaps[side, np.arange(len(p)), face], 0.0, atol=1e-9)
    nearest = np.sort(gaps.min(axis=0), axis=1)[:, 1]
    assert nearest.max() < EdgeSettings().beside_m + 1e-9


def test_both_faces_of_an_edge_get_places():
    _, n = edge_contacts(*contacts(BOX))
    for axis in range(3):
        for sign in (-1.0, 1.0):
            assert (sign * n[:, axis] > 0.99).any()


@pytest.mark.parametrize("mesh", [lathe.sphere(0.05, halvings=5), lathe.sphere(0.02, halvings=5)])
def test_a_ball_has_no_edges(mesh):
    p, n = edge_contacts(*contacts(mesh, 50))
    assert p.shape == n.shape == (0, 3)


def test_one_contact_implies_no_edge():
    p, n = edge_contacts(np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]))
    assert p.shape == n.shape == (0, 3)


def test_places_at_the_rim_of_a_cylinder_lie_on_it():
    radius, length = 0.04, 0.08
    angle = np.linspace(0.0, 2 * np.pi, 12, endpoint=False)
    around = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(12)])
    side = np.vstack([radius * around + [0, 0, z] for z in (0.03, 0.05, 0.065)])
    top = np.vstack([r * around + [0, 0, length] for r in (0.02, 0.03)])
    n = np.vstack([np.tile(around, (3, 1)), np.tile([0.0, 0.0, 1.0], (24, 1))])
    p, normals = edge_contacts(np.vstack([side, top]), n)
    assert len(p) >= 24
    upward = normals[:, 2] > 0.5
    np.testing.assert_allclose(p[upward, 2], length, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(p[~upward, :2], axis=1), radius, atol=1e-9)
    assert p[:, 2].max() <= length + 1e-9


def test_a_contact_on_a_bevel_forbids_the_edge_that_it_cuts_off():
    x, y = (a.ravel() for a in np.meshgrid([0.01, 0.02, 0.03], [0.0, 0.02, 0.04]))
    top = np.column_stack([-x, y, np.zeros(9)])
    wall = np.column_stack([np.zeros(9), y, -x])
    p = np.vstack([top, wall])
    n = np.repeat([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]], 9, axis=0)
    places, _ = edge_contacts(p, n)
    np.testing.assert_allclose(places[:, [0, 2]].max(axis=1), 0.0, atol=1e-12)
    assert len(places) > 0
    bevel = np.array([[-0.004, y, -0.004] for y in (0.0, 0.02, 0.04)])
    slant = np.tile([np.sqrt(0.5), 0.0, np.sqrt(0.5)], (3, 1))
    cut, _ = edge_contacts(np.vstack([p, bevel]), np.vstack([n, slant]))
    assert len(cut) == 0


def test_a_hollow_edge_is_left_alone():
    x, y = (a.ravel() for a in np.meshgrid([0.01, 0.02, 0.03], [0.0, 0.02, 0.04]))
    floor = np.column_stack([x, y, np.zeros(9)])
    wall = np.column_stack([np.zeros(9), y, x])
    n = np.repeat([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]], 9, axis=0)
    assert len(edge_contacts(np.vstack([floor, wall]), n)[0]) == 0


def test_a_rigid_motion_moves_the_places_along():
    p, n = contacts(BOX)
    rng = np.random.default_rng(0)
    R = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    R *= np.sign(np.linalg.det(R))
    t = np.array([0.1, -0.3, 0.2])
    there, normals = edge_contacts(p @ R.T + t, n @ R.T)
    here, still = edge_contacts(p, n)
    assert len(here) == len(there)
    order, moved = np.lexsort(np.round(here, 6).T), np.lexsort(np.round((there - t) @ R, 6).T)
    np.testing.assert_allclose(((there - t) @ R)[moved], here[order], atol=1e-9)
    np.testing.assert_allclose((normals @ R)[moved], still[order], atol=1e-9)
