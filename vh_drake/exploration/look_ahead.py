r"""A strategy that plans several touches and makes the first of them (section 5.2).

Candidates are rated by tours: sequences of touches k = 0, 1, ... on the estimate that begin with a
candidate. What a tour is expected to explore, per metre of the expected way, is

.. math:: \rho = \max_\text{tours}
    \frac{\sum_k \gamma^k h_k \sum_{v \in B_k} w(v)}
    {\sum_k \gamma^k (L_k + (1 - h_k)(L_k + l_m))}

============  ==================================================================================
:math:`B_k`   unexplored places of the estimate within r_E of touch k and of none before it
:math:`w`     falls with a place's distance from the contacts: what is far may not exist, and
              what is left behind nearby is dear to come back for
:math:`h_k`   how likely the surface is there; it falls with the distance from the contacts too
:math:`L_k`   length of the curve to touch k, which a miss makes in vain and goes back, with
              :math:`l_m` on top
:math:`\gamma` discounts what the next touches may change
============  ==================================================================================

Tours grow touch by touch, and the best are kept (beam search, Lowerre 1976); after the first touch
the plan is made anew.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from vh_drake.exploration.strategies import Situation
from vh_drake.types import Array, IntArray

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(5)
_TAU, _SHARES = 0.5 * (_NODES + 1.0), 0.5 * _WEIGHTS


@dataclass(frozen=True)
class LookAhead:
    """Rates candidates by the best tour that begins with them.

    The first candidate of each cell of a lattice may be touched on a tour, those with the shortest
    curves if there are too many.
    """

    touches: int = 4  # of a tour
    beam: int = 32  # tours that are kept
    spacing_m: float = 0.008  # of the lattice
    most: int = 150  # candidates
    longest_m: float = 0.06  # curve from touch to touch
    discount: float = 0.7  # γ
    trust_m: float = 0.04  # distance beyond r_E over which w falls to 1/e
    hit_m: float = 0.02  # distance beyond r_E over which h falls to 1/e
    miss_m: float = 0.04  # l_m

    def rate(self, situation: Situation) -> Array:
        """Best rate ρ (m,) [places/m]; negative where no kept tour begins, -inf if left out."""
        s = situation
        some = self._thinned(s)
        near = cKDTree(s.p).query_ball_point(s.p[some], s.explored_radius_m, return_sorted=True)
        beyond = s.nearest_contact_m - s.explored_radius_m
        places = Places(
            np.concatenate([[0], np.cumsum([len(own) for own in near])]),
            np.concatenate([np.asarray(own, np.int64) for own in near]),
            np.where(beyond < 0.0, 0.0, np.exp(-np.maximum(beyond, 0.0) / self.trust_m)),
        )
        hit = np.exp(-np.maximum(beyond[some], 0.0) / self.hit_m)
        p_WTip = s.p[some] + s.tip_radius_m * s.n[some]
        between = lengths_between(np.ascontiguousarray(p_WTip), np.ascontiguousarray(s.n[some]))
        between[between > self.longest_m] = np.inf
        missed = (1.0 - hit) * self.miss_m
        legs = Legs(
            np.maximum(s.lengths[some], 1e-6) * (2.0 - hit) + missed,
            between * (2.0 - hit) + missed,
            hit,
        )
        rating = np.full(len(s.p), -np.inf)
        rating[some] = tour_rates(legs, places, self.touches, self.discount, self.beam)
        return rating

    def _thinned(self, s: Situation) -> IntArray:
        """Indices of the candidates that may be touched."""
        cells = np.floor(s.p / self.spacing_m).astype(np.int64)
        first = np.unique(cells, axis=0, return_index=True)[1]
        nearest = first[np.argsort(s.lengths[first], kind="stable")[: self.most]]
        chosen: IntArray = np.sort(nearest)
        return chosen


class Places(NamedTuple):
    """What k touches explore of v places."""

    start: IntArray  # (k + 1,) touch i explores near[start[i]:start[i + 1]]
    near: IntArray  # indices of places
    weight: Array  # (v,)


class Legs(NamedTuple):
    """What k touches cost, and how likely they meet the surface."""

    first_m: Array  # (k,) expected way from the fingertip to each touch [m]
    between_m: Array  # (k, k) from touch to touch [m]; inf where none may go
    hit: Array  # (k,) h


class _Tours(NamedTuple):
    """Tours of equally many touches, the best first."""

    first: IntArray  # (t,)
    last: IntArray  # (t,)
    gain: Array  # (t,) expected weight of what they explore, discounted
    way: Array  # (t,) expected, discounted [m]
    explored: NDArray[np.bool_]  # (t, v)


@njit(cache=True)
def tour_rates(legs: Legs, places: Places, touches: int, discount: float, beam: int) -> Array:
    """The best rate ρ of tours that begin with each touch (k,).

    Where no tour of a touch was kept, -1 over the rate of this touch alone stands instead.

    Args:
        legs: ways to and between the touches.
        places: what the touches explore.
        touches: of a tour.
        discount: γ.
        beam: tours that are kept from step to step.
    """
    tours, rates = _begun(legs, places, beam)
    best = -1.0 / np.maximum(rates, 1e-12)
    share = 1.0
    for _ in range(touches - 1):
        share *= discount
        tours = _longer(tours, legs, places, share, beam)
    for t in range(len(tours.first)):
        best[tours.first[t]] = max(best[tours.first[t]], tours.gain[t] / tours.way[t])
    return best


@njit(cache=True)
def _begun(legs: Legs, places: Places, beam: int) -> tuple[_Tours, Array]:
    """Tours of one touch, and the rates of all touches (k,)."""
    k, v = len(legs.hit), len(places.weight)
    nothing = np.zeros(v, np.bool_)
    gain = legs.hit * np.array([_gain(i, nothing, places) for i in range(k)])
    rates = gain / legs.first_m
    kept = np.argsort(-rates, kind="mergesort")[:beam]
    explored = np.zeros((len(kept), v), np.bool_)
    for t in range(len(kept)):
        _explore(kept[t], explored[t], places)
    return _Tours(kept, kept, gain[kept], legs.first_m[kept], explored), rates


@njit(cache=True)
def _longer(tours: _Tours, legs: Legs, places: Places, share: float, beam: int) -> _Tours:
    """The best tours with a touch more; one that gains nothing from any more stays as it is."""
    count, k = len(tours.first), len(legs.hit)
    gain, rates = np.zeros((count, k)), np.full((count, k), -1.0)
    for t in range(count):
        for i in range(k):
            way = tours.way[t] + share * legs.between_m[tours.last[t], i]
            if way < np.inf:
                gain[t, i] = share * legs.hit[i] * _gain(i, tours.explored[t], places)
                if gain[t, i] > 0.0:
                    rates[t, i] = (tours.gain[t] + gain[t, i]) / way
        if rates[t].max() < 0.0:
            rates[t, tours.last[t]] = tours.gain[t] / tours.way[t]
    order = np.argsort(-rates.ravel(), kind="mergesort")[:beam]
    kept = order[rates.ravel()[order] >= 0.0]
    parent, last = kept // k, kept % k
    explored = tours.explored[parent]
    more, way = gain.ravel()[kept], tours.way[parent]
    for t in range(len(kept)):
        if more[t] > 0.0:
            _explore(last[t], explored[t], places)
            way[t] += share * legs.between_m[tours.last[parent[t]], last[t]]
    return _Tours(tours.first[parent], last, tours.gain[parent] + more, way, explored)


@njit(cache=True)
def _gain(touch: int, explored: NDArray[np.bool_], places: Places) -> float:
    """Weight of what a touch explores beyond what is explored (v,)."""
    gain = 0.0
    for e in range(places.start[touch], places.start[touch + 1]):
        if not explored[places.near[e]]:
            gain += places.weight[places.near[e]]
    return gain


@njit(cache=True)
def _explore(touch: int, explored: NDArray[np.bool_], places: Places) -> None:
    for e in range(places.start[touch], places.start[touch + 1]):
        explored[places.near[e]] = True


@njit(cache=True)
def lengths_between(p_WTip: Array, n: Array, rows: int = 1_000_000) -> Array:
    """Lengths (k, k) of the curves from each place to each other, which leave along the normal.

    The curves are those of `vh_drake.exploration.trajectory.approach_curves`; five nodes of
    Gauss-Legendre give their lengths to 1 %. The diagonal is inf.

    Args:
        p_WTip: (k, 3) centres of the fingertip at the places [m].
        n: (k, 3) outward unit normals there.
        rows: only from so many of the places, then (rows, k).
    """
    k = len(p_WTip)
    lengths = np.full((min(rows, k), k), np.inf)
    for i in range(len(lengths)):
        for j in range(k):
            if i == j:
                continue
            reach = np.sqrt(((p_WTip[j] - p_WTip[i]) ** 2).sum()) / 3.0
            length = 0.0
            for q in range(len(_TAU)):
                u, t = 1.0 - _TAU[q], _TAU[q]
                speed2 = 0.0
                for a in range(3):
                    out, back = reach * n[i, a], -reach * n[j, a]
                    middle = p_WTip[j, a] - p_WTip[i, a] - out - back
                    slope = 3.0 * (u * u * out + 2.0 * u * t * middle + t * t * back)
                    speed2 += slope * slope
                length += _SHARES[q] * np.sqrt(speed2)
            lengths[i, j] = length
    return lengths
