import dataclasses as dc
import itertools

import numpy as np
import pytest
import trimesh

from vh_drake.exploration.choosing import candidates
from vh_drake.exploration.look_ahead import (
    Legs,
    LookAhead,
    Places,
    lengths_between,
    tour_rates,
)
from vh_drake.exploration.loop import begin, explore, make_body
from vh_drake.exploration.trajectory import approach_curves, arc_length
from vh_drake.exploration.tuned import tuned
from vh_drake.geometry.meshes import from_trimesh

BALL = make_body(from_trimesh(trimesh.creation.icosphere(4, 0.05)), np.zeros(3))
SETTINGS = tuned("lookahead")


def random_problem(seed, touches=5, places=12):
    rng = np.random.default_rng(seed)
    near = [np.flatnonzero(rng.random(places) < 0.4) for _ in range(touches)]
    start = np.concatenate([[0], np.cumsum([len(own) for own in near])])
    between = rng.uniform(0.01, 0.05, (touches, touches))
    np.fill_diagonal(between, np.inf)
    legs = Legs(rng.uniform(0.01, 0.05, touches), between, rng.uniform(0.2, 1.0, touches))
    return legs, Places(start, np.concatenate(near).astype(np.int64), rng.uniform(0, 1, places))


def rate_of(tour, legs, places, discount):
    """The rate of a tour, straight from its definition."""
    explored, gain, way = set(), 0.0, 0.0
    for k, i in enumerate(tour):
        own = set(places.near[places.start[i] : places.start[i + 1]].tolist())
        gain += discount**k * legs.hit[i] * sum(places.weight[v] for v in own - explored)
        explored |= own
        leg = legs.first_m[i] if k == 0 else legs.between_m[tour[k - 1], i]
        way += discount**k * leg
    return gain / way


@pytest.mark.parametrize("seed", range(5))
def test_a_wide_beam_finds_the_best_of_all_tours(seed):
    legs, places = random_problem(seed)
    rates = tour_rates(legs, places, 3, 0.7, 10_000)
    for first in range(5):
        tours = [
            tour
            for tour in itertools.product(range(5), repeat=3)
            if tour[0] == first and tour[0] != tour[1] and tour[1] != tour[2]
        ]
        gaining = [tour for tour in tours if _gains(tour, places)]
        if gaining:
            best = max(rate_of(tour, legs, places, 0.7) for tour in gaining)
            assert rates[first] == pytest.approx(best, rel=1e-9)


def _gains(tour, places):
    """Whether every touch of a tour explores something."""
    explored = set()
    for i in tour:
        own = set(places.near[places.start[i] : places.start[i + 1]].tolist())
        if not own - explored:
            return False
        explored |= own
    return True


def test_tours_of_one_touch_are_gain_over_way():
    legs, places = random_problem(7)
    rates = tour_rates(legs, places, 1, 0.7, 5)
    expected = [rate_of((i,), legs, places, 0.7) for i in range(5)]
    np.testing.assert_allclose(rates, expected)


def test_what_no_kept_tour_begins_with_is_rated_below_all_that_are():
    legs, places = random_problem(3)
    alone = tour_rates(legs, places, 1, 0.7, 5)
    rates = tour_rates(legs, places, 1, 0.7, 2)
    kept = rates > 0
    assert kept.sum() == 2
    np.testing.assert_array_equal(np.argsort(rates), np.argsort(alone))


def test_lengths_between_are_those_of_the_curves():
    rng = np.random.default_rng(0)
    p, n = rng.normal(0, 0.05, (12, 3)), rng.normal(size=(12, 3))
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    lengths = lengths_between(p, n)
    assert np.isinf(np.diag(lengths)).all()
    for i in range(12):
        others = np.arange(12) != i
        exact = arc_length(approach_curves(p[i], n[i], p[others], n[others]))
        np.testing.assert_allclose(lengths[i, others], exact, rtol=0.03)


def test_a_detour_that_explores_more_is_worth_it_only_when_looking_ahead():
    """Touch 0 gains most at once; touch 1 leads to touch 2, which together gain more."""
    near = [[0, 1, 2], [3, 4], [5, 6, 7, 8, 9, 10]]
    start = np.array([0, 3, 5, 11])
    places = Places(start, np.concatenate(near).astype(np.int64), np.ones(11))
    between = np.array([[np.inf, 0.09, 0.09], [0.09, np.inf, 0.01], [0.09, 0.01, np.inf]])
    legs = Legs(np.array([0.02, 0.02, 0.2]), between, np.ones(3))
    assert np.argmax(tour_rates(legs, places, 1, 1.0, 10)) == 0
    assert np.argmax(tour_rates(legs, places, 2, 1.0, 10)) == 1


def test_every_candidate_of_the_lattice_is_rated_and_the_others_are_left_out():
    known, _ = begin(BALL, SETTINGS, seed=0)
    situation = candidates(known, SETTINGS)
    rating = LookAhead(most=20).rate(situation)
    assert np.isfinite(rating).sum() == 20
    assert rating.max() > 0
    assert not np.isnan(rating).any()


def test_ratings_do_not_change_when_everything_is_turned_and_moved():
    known, _ = begin(BALL, SETTINGS, seed=0)
    s = candidates(known, SETTINGS)
    s = dc.replace(s, p=s.p[::9], n=s.n[::9])
    fine = LookAhead(spacing_m=1e-6, most=10_000)
    rating = fine.rate(s)
    R = trimesh.transformations.random_rotation_matrix(np.array([0.3, 0.6, 0.1]))[:3, :3]
    turned = dc.replace(
        s,
        p=s.p @ R.T + 0.2,
        n=s.n @ R.T,
        contacts=type(s.contacts)(s.contacts.p_WC @ R.T + 0.2, s.contacts.n_WC @ R.T),
        p_WTip=R @ s.p_WTip + 0.2,
        departure_W=R @ s.departure_W,
        approach_W=R @ s.approach_W,
    )
    np.testing.assert_allclose(fine.rate(turned), rating, rtol=1e-6)


def test_looking_ahead_explores_a_ball_on_a_shorter_way_than_igef():
    runs = range(3)
    ahead = [explore(BALL, SETTINGS, seed=seed) for seed in runs]
    igef = [explore(BALL, tuned("igef"), seed=seed) for seed in runs]
    assert all(result.end == "goal" for result in (*ahead, *igef))
    ways = [sum(result.lengths_m[-1] for result in results) for results in (ahead, igef)]
    assert ways[0] < 0.9 * ways[1]


def test_the_same_seed_gives_the_same_exploration():
    runs = [explore(BALL, SETTINGS, seed=4).known.contacts.p_WC for _ in "ab"]
    np.testing.assert_array_equal(*runs)


@pytest.mark.parametrize("seed", [0, 1, 4])
def test_a_rod_is_explored_to_its_ends_though_the_estimate_closes_before_them(seed):
    rod = make_body(from_trimesh(trimesh.creation.box((0.2, 0.01, 0.01))), np.zeros(3))
    assert explore(rod, SETTINGS, seed=seed).end == "goal"


def test_what_is_explored_is_offered_only_near_what_is_not():
    settings = dc.replace(SETTINGS, candidate_radius_m=0.03)
    known = begin(BALL, settings, seed=0)[0]
    away = candidates(known, settings).nearest_contact_m
    assert SETTINGS.fresh_m < away.min() < SETTINGS.explored_radius_m < away.max()
    settings = dc.replace(settings, candidate_radius_m=0.018)  # all of it is explored
    away = candidates(known, settings).nearest_contact_m
    assert away.min() >= SETTINGS.explored_radius_m
