"""Candidates of all grasp planners on one estimated surface."""

import math
from collections.abc import Callable

import numpy as np

from vh_drake.control.kinematics import ArmKinematics
from vh_drake.geometry.skeleton import curve_skeleton
from vh_drake.grasping.approach import GraspMotionSettings
from vh_drake.grasping.diversity import spread
from vh_drake.grasping.motions import hand_axes
from vh_drake.grasping.planner_poses import Site, make_site
from vh_drake.grasping.planner_settings import PlannerSettings, check_planner_settings
from vh_drake.grasping.reachable import reachable
from vh_drake.grasping.skeleton_planner import placements, propose_along_skeleton
from vh_drake.grasping.surface_planner import propose_on_surface
from vh_drake.hand.model import HandModel
from vh_drake.types import Array, Candidates, Plane, Surface

_SURPLUS = 1.5  # of free poses over the wanted ones, for diversity

Propose = Callable[[str], Array]  # Free poses (n, 4, 4) of an approach, anew in each call


def plan_candidates(
    surface: Surface,
    table: Plane,
    hand: HandModel,
    settings: PlannerSettings | None = None,
    seed: int = 0,
    *,
    arm: ArmKinematics | None = None,
) -> Candidates:
    """Candidates whose open hand is free of estimate and table; diverse, maybe none.

    Args:
        surface: closed estimate.
        table: that it stands on.
        hand: that shall grasp.
        settings: planners, approaches and numbers. The planners share the number of candidates
            evenly; what one can't find the others may.
        seed: of all draws; the same inputs give the same candidates.
        arm: that carries the hand; poses out of its reach are left out. None: any pose will do.

    Returns:
        Candidates in the order of the planners.

    Raises:
        BadInput: the surface is empty or open, or the settings ask for nothing.
        UnknownName: a planner or approach of the settings.
    """
    settings = settings or PlannerSettings()
    check_planner_settings(settings)
    site = make_site(surface, table, hand, settings, seed)
    found = {name: _propose(site, name, arm, seed) for name in dict.fromkeys(settings.planners)}
    shares = _shares({name: len(X_WH) for name, (X_WH, _) in found.items()}, settings.candidates)
    parts = [_chosen(name, *found[name], hand, shares[name]) for name in found]
    return joined(parts)


def joined(parts: list[Candidates]) -> Candidates:
    """Several sets of candidates as one."""
    return Candidates(
        np.concatenate([part.X_WH for part in parts]),
        tuple(name for part in parts for name in part.motion),
        tuple(name for part in parts for name in part.planner),
    )


def _proposer(site: Site, planner: str, rng: np.random.Generator) -> Propose:
    if planner == "skeleton":
        nodes = placements(curve_skeleton(site.field.distance), site.X_WT, site.settings)
        return lambda approach: propose_along_skeleton(site, nodes, approach, rng)
    return lambda approach: propose_on_surface(site, approach, rng)


def _propose(
    site: Site, planner: str, arm: ArmKinematics | None, seed: int
) -> tuple[Array, list[str]]:
    """Free poses (n, 4, 4) and their approaches, more than needed where there are so many."""
    settings = site.settings
    propose = _proposer(site, planner, np.random.default_rng([seed, len(planner)]))
    poses, approaches = [np.zeros((0, 4, 4))], []
    for _ in range(settings.rounds):
        for approach in settings.approaches:
            X_WH = propose(approach)
            if arm is not None:
                X_WH = X_WH[reachable(arm, _way(X_WH, approach, site))]
            poses.append(X_WH)
            approaches += [approach] * len(X_WH)
        if len(approaches) >= _SURPLUS * settings.candidates / len(settings.planners):
            break
    return np.concatenate(poses), approaches


def _way(X_WH: Array, approach: str, site: Site) -> Array:
    """What the arm must be able to do (n, k, 4, 4): hold the hand over its place, in it, off it."""
    motion = GraspMotionSettings()
    lifted = X_WH.copy()
    lifted[:, :3, 3] += motion.rise_m(approach) * site.X_WT[:3, 2]
    if approach == "collect":
        return np.stack([lifted, X_WH], axis=1)
    beside = X_WH.copy()
    beside[:, :3, 3] -= motion.standoff_m * X_WH[:, :3, :3] @ hand_axes(site.hand)[1]
    return np.stack([lifted, X_WH, beside], axis=1)


def _shares(found: dict[str, int], wanted: int) -> dict[str, int]:
    """How many candidates each planner gives: alike, but none more than it found."""
    shares: dict[str, int] = {}
    for name in sorted(found, key=found.__getitem__):
        even = math.ceil((wanted - sum(shares.values())) / (len(found) - len(shares)))
        shares[name] = min(found[name], even)
    return shares


def _chosen(
    planner: str, X_WH: Array, approaches: list[str], hand: HandModel, count: int
) -> Candidates:
    """The most diverse ones."""
    names = np.array(approaches)
    group = np.unique(names, return_inverse=True)[1].astype(np.float64)
    kept = spread(X_WH, group, hand, count)
    return Candidates(X_WH[kept], tuple(map(str, names[kept])), (planner,) * len(kept))
