"""Grasp candidates from random places of an estimated surface (thesis, section 4.2.4).

A place on the surface, drawn by area, says where the hand goes and, by its normal, from where;
the hand turns about the approach at random, as far as the approach leaves that open.
"""

import numpy as np

from vh_drake.grasping.planner_poses import Site, collect_poses, free_poses, side_poses
from vh_drake.types import Array


def propose_on_surface(site: Site, approach: str, rng: np.random.Generator) -> Array:
    """Free poses X_WH (k, 4, 4) of one approach, from one round of draws."""
    drawn = rng.integers(0, len(site.p_TS), site.settings.draws)
    at, normals = site.p_TS[drawn], site.n_TS[drawn]
    if approach == "collect":
        heading = _headings(normals, rng)
        left = np.column_stack([-np.sin(heading), np.cos(heading), np.zeros(len(heading))])
        # Grasps far beside the centre of mass let an object tilt.
        beside = ((at - site.center) * left).sum(axis=1) * rng.uniform(0, 0.7, len(at))
        return collect_poses(site, heading, at, left @ site.center + beside, rng)
    if approach == "side":
        upright = np.abs(normals[:, 2]) < 0.5
        facing = -normals[upright] * [1, 1, 0]
        facing /= np.linalg.norm(facing, axis=1, keepdims=True)
        return side_poses(site, facing, at[upright], rng)
    return free_poses(site, -normals, _rolls(normals, rng), at)


def _headings(normals: Array, rng: np.random.Generator) -> Array:
    """Headings [rad] of the fingers: along horizontal normals, fore or aft, else random."""
    count = len(normals)
    heading = np.arctan2(normals[:, 1], normals[:, 0]) + np.pi * rng.integers(0, 2, count)
    aligned = (np.abs(normals[:, 2]) < 0.5) & (rng.random(count) < 0.7)
    result: Array = np.where(aligned, heading, rng.uniform(-np.pi, np.pi, count))
    return result


def _rolls(normals: Array, rng: np.random.Generator) -> Array:
    """Random unit vectors (n, 3) across normals."""
    across = np.cross(normals, rng.standard_normal(normals.shape))
    rolls: Array = across / np.linalg.norm(across, axis=1, keepdims=True)
    return rolls
