r"""Short tours of touches that explore enough of an object, by simulated annealing.

A tour begins at touch 0 and makes any of the others in any order. It shall be short and explore at
least some number of samples:

.. math:: E = \sum_k D_{t_{k-1} t_k} + \lambda \max(0, N - |\bigcup_k C_{t_k}|)

with lengths D between touches, the samples C that a touch explores, the number N that is needed,
and a price λ for each sample that lacks. Touches are replaced, dropped, added and moved, and parts
of the tour are reversed (2-opt, Croes 1958); what makes E greater is kept by a chance that cools
down (Kirkpatrick et al. 1983).
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from vh_drake.types import Array, IntArray

_MOST = 1000  # touches of a tour
_PRICE = 5.0  # of all that is needed, in lengths of the first tour


class Problem(NamedTuple):
    """Touches 0 to k - 1, of which 0 is the start, and the samples that they explore."""

    length_m: Array  # (k, k) between touches, symmetric [m]
    near: IntArray  # (k, c) touches near each, without 0, of which a change takes one
    start: IntArray  # (k + 1,) touch i explores samples[start[i]:start[i + 1]]
    samples: IntArray  # indices of samples, below `total`
    total: int  # of all samples
    needed: int  # of them


class Cooling(NamedTuple):
    """How a tour is annealed."""

    changes: int = 300_000  # that are tried
    hot_m: float = 0.02  # the first temperature
    cold_m: float = 0.0003  # the last


@njit(cache=True)
def short_tour(
    problem: Problem, first: IntArray, cooling: Cooling, rng: np.random.Generator
) -> IntArray:
    """The shortest tour that was found among those that explore what is needed.

    Args:
        problem: lengths and samples.
        first: the tour to begin with, from 0 on.
        cooling: how long is searched.
        rng: for all chance.

    Returns:
        Indices of touches, 0 first; the first tour where this explores too little.
    """
    tour, trial, n = np.zeros(_MOST, np.int64), np.zeros(_MOST, np.int64), len(first)
    tour[:n] = first
    times = np.zeros(problem.total, np.int64)  # that a sample is explored
    explored = 0
    for touch in first:
        explored += _explore(problem, times, touch)
    if explored < problem.needed:
        return first
    length = tour_length(problem.length_m, first)
    best, least, price = first.copy(), length, _PRICE * length / problem.needed
    for change in range(cooling.changes):
        m, dropped, added = _changed(problem.near, tour, n, trial, rng)
        gain = (_explore(problem, times, added) if added >= 0 else 0) - (
            _forget(problem, times, dropped) if dropped >= 0 else 0
        )
        more = tour_length(problem.length_m, trial[:m]) - length
        lack = max(0, problem.needed - explored - gain) - max(0, problem.needed - explored)
        heat = cooling.hot_m * (cooling.cold_m / cooling.hot_m) ** (change / cooling.changes)
        if rng.random() >= np.exp(-max(more + price * lack, 0.0) / heat):
            if added >= 0:
                _forget(problem, times, added)
            if dropped >= 0:
                _explore(problem, times, dropped)
            continue
        tour, trial, n = trial, tour, m
        length, explored = length + more, explored + gain
        if explored >= problem.needed and length < least - 1e-9:
            best, least = tour[:n].copy(), length
    return best


@njit(cache=True)
def tour_length(length_m: Array, tour: IntArray) -> float:
    """The length of a tour [m]."""
    length = 0.0
    for k in range(1, len(tour)):
        length += length_m[tour[k - 1], tour[k]]
    return length


@njit(cache=True)
def _changed(
    near: IntArray, tour: IntArray, n: int, trial: IntArray, rng: np.random.Generator
) -> tuple[int, int, int]:
    """Put a changed tour into `trial`: its length, the touch that was dropped and that was added.

    -1 stands for none.
    """
    kind = rng.integers(0, 5) if n > 2 else 0
    if kind == 0 and n < _MOST:
        at = rng.integers(0, n)
        touch = near[tour[at], rng.integers(0, near.shape[1])]
        trial[: at + 1] = tour[: at + 1]
        trial[at + 1] = touch
        trial[at + 2 : n + 1] = tour[at + 1 : n]
        return n + 1, -1, touch
    at = rng.integers(1, n)
    touch = tour[at]
    trial[:n] = tour[:n]
    if kind == 1:
        trial[at : n - 1] = tour[at + 1 : n]
        return n - 1, touch, -1
    if kind == 2:
        trial[at] = near[touch, rng.integers(0, near.shape[1])]
        return n, touch, trial[at]
    to = rng.integers(1, n)
    low, high = min(at, to), max(at, to) + 1
    if kind == 3:
        trial[low:high] = tour[low:high][::-1]
    elif at < to:
        trial[at:to], trial[to] = tour[at + 1 : to + 1], touch
    else:
        trial[to + 1 : at + 1], trial[to] = tour[to:at], touch
    return n, -1, -1


@njit(cache=True)
def _explore(problem: Problem, times: IntArray, touch: int) -> int:
    """Count a touch's samples; how many are explored by it alone."""
    new = 0
    for e in range(problem.start[touch], problem.start[touch + 1]):
        sample = problem.samples[e]
        new += 1 if times[sample] == 0 else 0
        times[sample] += 1
    return new


@njit(cache=True)
def _forget(problem: Problem, times: IntArray, touch: int) -> int:
    """Take a touch's samples back; how many nobody else explores."""
    lost = 0
    for e in range(problem.start[touch], problem.start[touch + 1]):
        sample = problem.samples[e]
        times[sample] -= 1
        lost += 1 if times[sample] == 0 else 0
    return lost


@njit(cache=True)
def greedy_tour(problem: Problem) -> IntArray:
    """The touch next that explores most for its way, until enough is explored.

    Ends before where nothing more can be explored.
    """
    tour, n = np.zeros(_MOST, np.int64), 1
    times = np.zeros(problem.total, np.int64)
    explored = _explore(problem, times, 0)
    while explored < problem.needed and n < _MOST:
        best, highest = -1, 0.0
        for touch in range(1, len(problem.start) - 1):
            gain = 0
            for e in range(problem.start[touch], problem.start[touch + 1]):
                gain += 1 if times[problem.samples[e]] == 0 else 0
            rate = gain / max(problem.length_m[tour[n - 1], touch], 1e-6)
            if rate > highest:
                best, highest = touch, rate
        if best < 0:
            break
        tour[n] = best
        explored += _explore(problem, times, best)
        n += 1
    return tour[:n].copy()


@njit(cache=True)
def shortest_paths(length_m: Array) -> tuple[Array, IntArray]:
    """Lengths (k, k) of the shortest paths, and the touch before the last on each (Floyd 1962)."""
    k = len(length_m)
    shortest, before = length_m.copy(), np.empty((k, k), np.int64)
    for i in range(k):
        before[i] = i
        shortest[i, i] = 0.0
    for via in range(k):
        for i in range(k):
            for j in range(k):
                length = shortest[i, via] + shortest[via, j]
                if length < shortest[i, j]:
                    shortest[i, j], before[i, j] = length, before[via, j]
    return shortest, before
