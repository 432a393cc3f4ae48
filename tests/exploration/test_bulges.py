import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from vh_drake.exploration.bulges import bulge
from vh_drake.exploration.choosing import candidates
from vh_drake.exploration.explorer import Arrival, ExplorerSettings, after_first, after_touch
from vh_drake.types import ContactSet

UP = np.array([0.0, 0.0, 1.0])


def even_sphere(count, seed):
    n = np.random.default_rng(seed).normal(size=(count, 3))
    return n / np.linalg.norm(n, axis=1, keepdims=True)


def test_over_one_contact_it_is_the_height_over_its_tangent_plane():
    contact = ContactSet(np.zeros((1, 3)), UP[None])
    p = np.array([[0.01, 0.0, 0.002], [0.0, 0.02, -0.003], [0.05, 0.0, 0.0]])
    heights = bulge(p, contact, within_m=0.04)
    np.testing.assert_allclose(heights, [0.002, -0.003, -np.inf])


def test_of_several_contacts_the_one_that_is_exceeded_most_counts():
    contacts = ContactSet(np.array([[0.0, 0, 0], [0.01, 0, 0]]), np.array([UP, [1.0, 0, 0]]))
    assert bulge(np.array([[0.02, 0.0, 0.003]]), contacts, within_m=0.04) == pytest.approx(0.01)


def test_no_place_of_a_convex_body_bulges():
    n, m = even_sphere(40, 0), even_sphere(300, 1)
    heights = bulge(0.05 * m, ContactSet(0.05 * n, n), within_m=0.04)
    assert heights.max() <= 1e-12


def test_a_rigid_motion_changes_nothing():
    n, p = even_sphere(12, 2), np.random.default_rng(3).uniform(-0.06, 0.06, (50, 3))
    X = RigidTransform(RollPitchYaw(0.3, -1.1, 2.0), [0.2, -0.4, 0.1])
    R = X.rotation().matrix()
    moved = ContactSet(0.04 * n @ R.T + X.translation(), n @ R.T)
    before = bulge(p, ContactSet(0.04 * n, n), within_m=0.05)
    after = bulge(p @ R.T + X.translation(), moved, within_m=0.05)
    np.testing.assert_allclose(after, before, atol=1e-12)


def contact(p, n):
    p, n = np.array(p, float), np.array(n, float)
    return Arrival(p + 0.005 * n, -n, -n, p, n)


def shell():
    """Both faces of a thin plate, touched 10 mm apart; the estimate hangs over its rim."""
    settings = ExplorerSettings(margin_m=0.03)
    known = after_first(contact([0, 0, 0], [0, 0, 1]), settings)
    places = [([0.025, 0, 0], UP), ([0.05, 0, -0.002], -UP), ([0.025, 0, -0.002], -UP)]
    for p, n in places:
        known = after_touch(known, np.array(p, float), contact(p, n), settings)
    return known, settings


def test_candidates_that_bulge_are_put_off_while_there_are_others():
    known, settings = shell()
    offered = candidates(known, settings)
    heights = bulge(offered.p, known.contacts, within_m=settings.bulge_within_m)
    assert heights.max() <= settings.bulge_m
    every = candidates(known, ExplorerSettings(margin_m=0.03, bulge_m=np.inf))
    heights = bulge(every.p, known.contacts, within_m=settings.bulge_within_m)
    assert heights.max() > settings.bulge_m


def test_candidates_that_bulge_are_offered_where_there_are_no_others():
    known, _ = shell()
    assert len(candidates(known, ExplorerSettings(margin_m=0.03, bulge_m=-1.0)).p) > 0
