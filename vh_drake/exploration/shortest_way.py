"""The way of an explorer that knows the object: a yardstick for all that do not.

It plans on the true surface, which no strategy sees, and travels as they do, with the same
fingertip on the same curves from contact to contact, before the same judge. So its way tells about
how much a strategy could save at most. The search does not prove that no shorter way exists.
"""

import dataclasses as dc
from itertools import pairwise

import numpy as np
from numba import njit
from scipy.spatial import cKDTree

from vh_drake.exploration.choosing import Choice
from vh_drake.exploration.coverage import Coverage
from vh_drake.exploration.explorer import ExplorerSettings, Known
from vh_drake.exploration.look_ahead import lengths_between
from vh_drake.exploration.loop import Body, EndSettings, Exploration, Step, begin, step_to
from vh_drake.exploration.tours import (
    Cooling,
    Problem,
    greedy_tour,
    short_tour,
    shortest_paths,
    tour_length,
)
from vh_drake.exploration.trajectory import approach_curves
from vh_drake.geometry.closest_points import TriangleTree, closest_point, closest_points
from vh_drake.geometry.meshes import TriMesh
from vh_drake.geometry.sampling import sample_surface
from vh_drake.gpis.evidence import farthest_points
from vh_drake.types import Array, Immutable, IntArray

_DRAWN = 8000  # places of the tip, of which some are kept
_SLACK_M = 1e-5  # of distances that ought to be the tip's radius
_SHORTEST_M = 0.001  # leg; what is nearer is the same place
_LONGEST_M = 0.06  # leg; longer ones are made of several
_CHECKED = 12  # places of a curve that have to be free


@dc.dataclass(frozen=True)
class SearchSettings:
    """How hard a short way is searched."""

    sites: int = 500
    near: int = 24  # sites of which one is tried instead of another
    attempts: int = 3  # of annealing
    plans: int = 4  # a plan that ends short of the goal is followed by another
    cooling: Cooling = dc.field(default_factory=Cooling)


@dc.dataclass(frozen=True, eq=False)
class Sites(Immutable):
    """Where the fingertip can touch an object, and the ways in between."""

    p_WC: Array  # (k, 3) contacts [m]
    n_WC: Array  # (k, 3) unit vectors from there to the tip's centre
    legs_m: Array  # (k, k) lengths of the curves; inf where one meets the object or is long


def make_sites(
    body: Body, mesh: TriMesh, *, tip_radius_m: float = 0.005, count: int = 500
) -> Sites:
    """Sites spread evenly over a mesh, on its edges with all normals that a ball has there.

    Args:
        body: of the mesh.
        mesh: watertight [m].
        tip_radius_m: of the fingertip.
        count: of sites, at most.
    """
    p, n = sample_surface(mesh, _DRAWN, seed=1)
    aside = np.random.default_rng(1).normal(size=p.shape)
    outside = n + 0.9 * aside / np.linalg.norm(aside, axis=1, keepdims=True)
    x = p + tip_radius_m * outside / np.linalg.norm(outside, axis=1, keepdims=True)
    q = closest_points(body.tree, x)
    off = x - q
    distance = np.linalg.norm(off, axis=1, keepdims=True)
    n = off / np.maximum(distance, 1e-12)
    centre = q + tip_radius_m * n
    gap = np.linalg.norm(centre - closest_points(body.tree, centre), axis=1)
    fits = np.flatnonzero((gap >= tip_radius_m - _SLACK_M) & (distance[:, 0] > 1e-6))
    kept = fits[farthest_points(centre[fits], count)]
    return Sites(q[kept], n[kept], _free_legs(body.tree, centre[kept], n[kept], tip_radius_m))


def explore_knowing(
    body: Body,
    sites: Sites,
    settings: ExplorerSettings | None = None,
    search: SearchSettings | None = None,
    end: EndSettings | None = None,
    *,
    seed: int = 0,
) -> Exploration:
    """Explore a body on a short way that is planned on the body itself.

    Args:
        body: the object.
        sites: of it, for the same fingertip.
        settings: of the fingertip and the estimate; no strategy is asked.
        search: how hard is searched.
        end: when it ends.
        seed: of the first approach and of the search.

    Raises:
        BadInput: no straight way to the centre meets the object.
    """
    settings, search = settings or ExplorerSettings(), search or SearchSettings()
    end = end or EndSettings()
    start, coverage = begin(body, settings, seed=seed)
    steps: list[Step] = []
    known, covered = start, coverage
    for _ in range(search.plans):
        for site in _planned(body, sites, known, covered, settings, search, end, seed):
            step = step_to(body, choice_of(sites, site, known, settings), known, covered, settings)
            if step is None:
                break
            steps.append(step)
            known, covered = step.known, step.coverage
            if covered.share >= end.goal:
                return Exploration(start, coverage, tuple(steps), "goal")
    return Exploration(start, coverage, tuple(steps), "stuck")


def choice_of(sites: Sites, site: int, known: Known, s: ExplorerSettings) -> Choice:
    """The way from the last contact to a site."""
    p, n = sites.p_WC[site : site + 1], sites.n_WC[site : site + 1]
    curve = approach_curves(known.p_WTip, known.contacts.n_WC[-1], p + s.tip_radius_m * n, n)
    return Choice(p, n, np.zeros(1), 0, curve)


def legs_from(body: Body, sites: Sites, known: Known, s: ExplorerSettings) -> Array:
    """Lengths (k + 1, k + 1) of the ways from the last contact, the first row, and from all sites.

    Infinite where one meets the object or is long, and back to the last contact [m].
    """
    p_WC = np.vstack([known.contacts.p_WC[-1:], sites.p_WC])
    n_WC = np.vstack([known.contacts.n_WC[-1:], sites.n_WC])
    legs = np.full((len(p_WC), len(p_WC)), np.inf)
    legs[1:, 1:] = sites.legs_m
    legs[0] = _free_legs(body.tree, p_WC + s.tip_radius_m * n_WC, n_WC, s.tip_radius_m, rows=1)[0]
    return legs


def _planned(
    body: Body,
    sites: Sites,
    known: Known,
    coverage: Coverage,
    settings: ExplorerSettings,
    search: SearchSettings,
    end: EndSettings,
    seed: int,
) -> list[int]:
    """Sites to touch one after the other, from the last contact on."""
    p_WC = np.vstack([known.contacts.p_WC[-1:], sites.p_WC])
    legs = legs_from(body, sites, known, settings)
    shortest, before = shortest_paths(legs)
    reached = np.flatnonzero(np.isfinite(shortest[0]))
    legs, p_WC = shortest[np.ix_(reached, reached)], p_WC[reached]
    problem = _problem(legs, p_WC, coverage, search.near, end.goal)
    first = greedy_tour(problem)
    rng = np.random.default_rng(seed)
    tours = [short_tour(problem, first, search.cooling, rng) for _ in range(search.attempts)]
    best = min(tours, key=lambda tour: tour_length(problem.length_m, tour))
    return [int(i) - 1 for i in _with_stops(reached[best], before)]


def _problem(legs: Array, p_WC: Array, coverage: Coverage, near: int, goal: float) -> Problem:
    """What a tour of touches at p_WC shall explore, and what its legs cost."""
    open_ = np.flatnonzero(~coverage.explored)
    explored = cKDTree(coverage.p_WM[open_]).query_ball_point(p_WC, coverage.radius_m * 0.999)
    needed = goal * len(coverage.explored) - coverage.explored.sum()
    others = np.where(np.arange(len(legs)) == 0, np.inf, legs)  # nobody comes back to the start
    order = np.argsort(others, axis=1, kind="stable")[:, 1 : near + 1]
    return Problem(
        legs,
        np.ascontiguousarray(order),
        np.cumsum([0, *(len(own) for own in explored)]),
        np.concatenate([np.sort(np.asarray(own, np.int64)) for own in explored]),
        len(open_),
        int(np.ceil(needed)),
    )


def _with_stops(tour: IntArray, before: IntArray) -> list[int]:
    """A tour with the touches between, where its legs are made of several."""
    return [
        stop for a, b in pairwise(tour) if a != b for stop in stops_between(int(a), int(b), before)
    ]


def stops_between(a: int, b: int, before: IntArray) -> list[int]:
    """Where the shortest path from a to another place b touches on its way, b at last.

    Args:
        a: index of the start.
        b: index of the end.
        before: (k, k) of `vh_drake.exploration.tours.shortest_paths`.
    """
    leg = [b]
    while (stop := int(before[a, leg[-1]])) != a:
        leg.append(stop)
    return leg[::-1]


@njit(cache=True)
def _free_legs(
    tree: TriangleTree, tips: Array, n: Array, radius_m: float, rows: int = 1_000_000
) -> Array:
    """Lengths (rows, k) of the ways between tips (k, 3), inf where they are long or meet the mesh.

    They leave and come along the normals n (k, 3).
    """
    legs = lengths_between(tips, n, rows)
    for i in range(len(legs)):
        for j in range(len(tips)):
            if not _SHORTEST_M < legs[i, j] < _LONGEST_M:
                legs[i, j] = np.inf
            elif j < i:
                legs[i, j] = legs[j, i]
            elif not _is_free(tree, tips[i], n[i], tips[j], n[j], radius_m):
                legs[i, j] = np.inf
    return legs


@njit(cache=True)
def _is_free(
    tree: TriangleTree, a: Array, n_a: Array, b: Array, n_b: Array, radius_m: float
) -> bool:
    """Whether a ball on the curve from a to b (3,) keeps off the mesh."""
    reach = np.sqrt(((b - a) ** 2).sum()) / 3.0
    p, q = a + reach * n_a, b + reach * n_b
    for c in range(1, _CHECKED + 1):
        t = c / (_CHECKED + 1)
        u = 1.0 - t
        x = u**3 * a + 3.0 * u * u * t * p + 3.0 * u * t * t * q + t**3 * b
        if closest_point(tree, (x[0], x[1], x[2]), radius_m - _SLACK_M)[0] < radius_m - _SLACK_M:
            return False
    return True
