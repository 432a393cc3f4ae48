"""A strategy that rates the true surface instead of an estimate: what better estimates could save.

It chooses touch by touch, as `vh_drake.exploration.choosing` does, among the places of the object
where the fingertip fits, and on curves that are truly free. So it is never wrong about where it
will touch; all that it wastes, it wastes by not looking ahead.
"""

from collections.abc import Iterator

import numpy as np
from scipy.spatial import cKDTree

from vh_drake.exploration.choosing import situation_at
from vh_drake.exploration.coverage import Coverage
from vh_drake.exploration.explorer import ExplorerSettings, Known
from vh_drake.exploration.loop import (
    Body,
    EndSettings,
    Exploration,
    Step,
    begin,
    judged,
    step_to,
)
from vh_drake.exploration.shortest_way import Sites, choice_of, legs_from, stops_between
from vh_drake.exploration.tours import shortest_paths


def explore_rating_truth(
    body: Body,
    sites: Sites,
    settings: ExplorerSettings | None = None,
    end: EndSettings | None = None,
    *,
    seed: int = 0,
) -> Exploration:
    """Explore a body by a strategy that rates sites of the body itself.

    Args:
        body: the object.
        sites: of it, for the same fingertip.
        settings: the strategy, its candidate radius, the fingertip.
        end: when it ends.
        seed: of the first approach and of choices by chance.

    Raises:
        BadInput: no straight way to the centre meets the object.
    """
    settings, end = settings or ExplorerSettings(), end or EndSettings()
    start, coverage = begin(body, settings, seed=seed)
    return judged(start, coverage, _touches(body, sites, start, coverage, settings, seed), end)


def _touches(
    body: Body, sites: Sites, known: Known, coverage: Coverage, s: ExplorerSettings, seed: int
) -> Iterator[Step]:
    """Touch after touch, for as long as a site is fresh and can be reached."""
    while (step := _next_step(body, sites, known, coverage, s, seed)) is not None:
        known, coverage = step.known, step.coverage
        yield step


def _next_step(
    body: Body, sites: Sites, known: Known, coverage: Coverage, s: ExplorerSettings, seed: int
) -> Step | None:
    """One touch of the best rated fresh site, or on the way to the nearest one; None without."""
    fresh = cKDTree(known.contacts.p_WC).query(sites.p_WC)[0] >= s.fresh_m
    if len(known.set_aside):
        fresh &= cKDTree(known.set_aside).query(sites.p_WC)[0] >= s.set_aside_m
    legs = legs_from(body, sites, known, s)
    near = np.linalg.norm(sites.p_WC - known.contacts.p_WC[-1], axis=1) <= s.candidate_radius_m
    offered = np.flatnonzero(fresh & near & np.isfinite(legs[0, 1:]))
    if len(offered):
        p, n = sites.p_WC[offered], sites.n_WC[offered]
        rating = s.strategy.rate(situation_at(p, n, known, s, seed))
        site = int(offered[np.argmax(rating)])
    else:
        away, before = shortest_paths(legs)
        reach = np.where(fresh, away[0, 1:], np.inf)
        if not np.isfinite(reach.min(initial=np.inf)):
            return None
        site = stops_between(0, int(reach.argmin()) + 1, before)[0] - 1
    return step_to(body, choice_of(sites, site, known, s), known, coverage, s)
