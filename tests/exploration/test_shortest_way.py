import numpy as np
import pytest
import trimesh

from vh_drake.exploration.loop import explore, make_body
from vh_drake.exploration.shortest_way import SearchSettings, explore_knowing, make_sites
from vh_drake.exploration.tours import Cooling
from vh_drake.exploration.tuned import tuned
from vh_drake.geometry.closest_points import closest_points
from vh_drake.geometry.meshes import from_trimesh

MESH = from_trimesh(trimesh.creation.box((0.1, 0.06, 0.04)))
BODY = make_body(MESH, np.zeros(3))
BRIEF = SearchSettings(attempts=1, cooling=Cooling(changes=100_000))


@pytest.fixture(scope="module")
def sites():
    return make_sites(BODY, MESH, count=250)


def test_sites_lie_on_the_object_where_the_fingertip_fits(sites):
    np.testing.assert_allclose(closest_points(BODY.tree, sites.p_WC), sites.p_WC, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(sites.n_WC, axis=1), 1.0)
    tips = sites.p_WC + 0.005 * sites.n_WC
    gap = np.linalg.norm(closest_points(BODY.tree, tips) - tips, axis=1)
    np.testing.assert_allclose(gap, 0.005, atol=1e-4)


def test_edges_are_touched_from_between_both_faces(sites):
    slanted = np.abs(sites.n_WC).max(axis=1) < 0.9
    assert 0.05 < slanted.mean() < 0.5


def test_no_leg_cuts_through_the_object(sites):
    top = np.flatnonzero(sites.n_WC[:, 2] > 0.99)
    below = np.flatnonzero(sites.n_WC[:, 2] < -0.99)
    inner = [k for k in below if np.abs(sites.p_WC[k, :2]).max() < 0.015]
    assert len(inner) > 0
    assert np.isinf(sites.legs_m[np.ix_(top, inner)]).all()
    np.testing.assert_allclose(sites.legs_m, sites.legs_m.T)


def test_who_knows_the_object_goes_a_shorter_way_and_touches_what_it_meant_to(sites):
    for seed in range(2):
        knowing = explore_knowing(BODY, sites, search=BRIEF, seed=seed)
        assert knowing.end == "goal"
        assert knowing.shares[-1] >= 0.8
        other = explore(BODY, tuned("igef"), seed=seed)
        assert knowing.lengths_m[-1] < 0.8 * other.lengths_m[-1]
        errors = [np.linalg.norm(s.touch.p_WT - s.touch.p_WC) for s in knowing.steps]
        assert np.mean(errors) < 0.002
        np.testing.assert_array_equal(knowing.start.p_WTip, other.start.p_WTip)


def test_a_part_that_no_way_leads_to_ends_the_exploration(apart):
    result = explore_knowing(*apart, search=BRIEF, seed=0)
    assert result.end == "stuck"
    assert result.shares[-1] == pytest.approx(0.5, abs=0.03)
