import dataclasses as dc

import numpy as np
import pytest
import trimesh

from vh_drake.exploration.knowing_strategy import explore_rating_truth
from vh_drake.exploration.loop import EndSettings, explore, make_body
from vh_drake.exploration.shortest_way import make_sites
from vh_drake.exploration.tuned import IGEF_KNOWING, tuned
from vh_drake.geometry.meshes import from_trimesh

MESH = from_trimesh(trimesh.creation.box((0.1, 0.06, 0.04)))
BODY = make_body(MESH, np.zeros(3))


@pytest.fixture(scope="module")
def sites():
    return make_sites(BODY, MESH, count=250)


def test_a_strategy_that_rates_the_truth_touches_what_it_meant_to(sites):
    for seed in range(2):
        knowing = explore_rating_truth(BODY, sites, IGEF_KNOWING, seed=seed)
        assert knowing.end == "goal"
        assert knowing.shares[-1] >= 0.8
        errors = [np.linalg.norm(s.touch.p_WT - s.touch.p_WC) for s in knowing.steps]
        assert np.mean(errors) < 0.002
        other = explore(BODY, tuned("igef"), seed=seed)
        assert knowing.lengths_m[-1] < other.lengths_m[-1]
        np.testing.assert_array_equal(knowing.start.p_WTip, other.start.p_WTip)


def test_it_chooses_the_best_rated_site_in_reach(sites):
    class Highest:
        def rate(self, situation):
            return situation.p[:, 2]

    settings = dc.replace(IGEF_KNOWING, strategy=Highest(), candidate_radius_m=1.0)
    steps = explore_rating_truth(BODY, sites, settings, EndSettings(most_touches=6)).steps
    heights = [step.touch.p_WC[2] for step in steps]
    assert max(heights) == pytest.approx(0.02, abs=1e-3)
    # As long as the top has fresh places, nothing lower is touched.
    first = int(np.argmax(np.array(heights) > 0.019))
    assert min(heights[first:]) > 0.019


def test_far_places_are_reached_by_touches_on_the_way(sites):
    settings = dc.replace(IGEF_KNOWING, candidate_radius_m=0.001)  # so that none is in reach
    steps = explore_rating_truth(BODY, sites, settings, EndSettings(most_touches=20)).steps
    assert len(steps) == 20
    assert max(step.touch.length_m for step in steps) < 0.08


def test_a_part_that_no_way_leads_to_ends_the_exploration(apart):
    result = explore_rating_truth(*apart, IGEF_KNOWING, seed=0)
    assert result.end == "lost"
    assert result.shares[-1] < 0.6
