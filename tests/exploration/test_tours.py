from itertools import combinations, pairwise, permutations

import numpy as np
from scipy.sparse.csgraph import floyd_warshall
from scipy.spatial.distance import cdist

from vh_drake.exploration.tours import (
    Cooling,
    Problem,
    greedy_tour,
    short_tour,
    shortest_paths,
    tour_length,
)

BRIEF = Cooling(changes=20_000, hot_m=1.0, cold_m=0.01)


def plane_problem(needed, *, touches=8, seed=0):
    """Touches at random places; each explores four samples of twelve, the start none."""
    rng = np.random.default_rng(seed)
    length = cdist(p := rng.random((touches, 2)), p)
    explored = [np.sort(rng.choice(12, 4, replace=False)) for _ in range(touches - 1)]
    near = np.array(
        [[i for i in range(1, touches) if i != k][: touches - 2] for k in range(touches)]
    )
    start = np.concatenate([[0, 0], 4 * np.arange(1, touches)])
    return Problem(length, np.array(near), start, np.concatenate(explored), 12, needed), explored


def shortest_by_trial(problem, explored):
    """The least length over all subsets and orders of touches."""
    best = np.inf
    for count in range(1, len(explored) + 1):
        for chosen in combinations(range(1, len(explored) + 1), count):
            if len(np.unique(np.concatenate([explored[i - 1] for i in chosen]))) < problem.needed:
                continue
            for order in permutations(chosen):
                best = min(best, tour_length(problem.length_m, np.array([0, *order])))
    return best


def number_explored(explored, tour):
    return len(np.unique(np.concatenate([explored[i - 1] for i in tour[1:]])))


def test_annealing_finds_the_tour_that_trying_all_finds():
    for seed, needed in ((0, 7), (1, 9), (2, 10)):
        problem, explored = plane_problem(needed, touches=7, seed=seed)
        tour = short_tour(problem, greedy_tour(problem), BRIEF, np.random.default_rng(0))
        assert tour[0] == 0
        assert number_explored(explored, tour) >= needed
        least = shortest_by_trial(problem, explored)
        np.testing.assert_allclose(tour_length(problem.length_m, tour), least, rtol=1e-9)


def test_the_greedy_tour_explores_what_is_needed_or_all_there_is():
    problem, explored = plane_problem(9)
    assert number_explored(explored, greedy_tour(problem)) >= 9
    every = len(np.unique(np.concatenate(explored)))
    assert number_explored(explored, greedy_tour(problem._replace(needed=13))) == every


def test_annealing_repeats_itself_for_the_same_chance():
    problem, _ = plane_problem(9)
    first = greedy_tour(problem)
    one, two = (short_tour(problem, first, BRIEF, np.random.default_rng(5)) for _ in range(2))
    np.testing.assert_array_equal(one, two)


def test_shortest_paths_agree_with_scipy_and_can_be_walked():
    rng = np.random.default_rng(3)
    length = rng.random((12, 12)) ** 2
    length = np.where(length + length.T > 1.0, np.inf, length + length.T)
    shortest, before = shortest_paths(length)
    expected = floyd_warshall(np.where(np.isinf(length), 0.0, length))  # 0 is no edge
    np.testing.assert_allclose(shortest, expected)
    for i in range(12):
        for j in range(12):
            path = [j]
            while path[-1] != i and np.isfinite(shortest[i, j]):
                path.append(before[i, path[-1]])
            if np.isfinite(shortest[i, j]):
                np.testing.assert_allclose(
                    sum(length[b, a] for a, b in pairwise(path)), shortest[i, j]
                )
