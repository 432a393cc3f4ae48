"""Grasp candidates along an object's skeleton (thesis, section 4.2.4).

The hand is aligned with a straight section of the skeleton: its fingers close across the
section, preferably where that is narrow. Further candidates take the skeleton's end points,
where the hand may also come along the section.
"""

import dataclasses as dc

import numpy as np

from vh_drake.geometry.meshes import Mask
from vh_drake.geometry.skeleton import Line, Skeleton
from vh_drake.geometry.straight_sections import straight_sections
from vh_drake.grasping.planner_poses import Site, collect_poses, free_poses, side_poses
from vh_drake.grasping.planner_settings import PlannerSettings
from vh_drake.types import Array, IntArray

_LEVEL = 0.7  # Largest |z| of the direction of a section that lies rather than stands
_END_SHARE = 0.25  # of the draws that take end points, where there are any
_WIDTH_M = 0.01  # A section that is wider by this is taken e times less often
_NEAR_M = 0.04  # Places farther from the centre of mass than this are drawn less often
_ANYWHERE = 0.3  # relative odds of places far from it
_JITTER_RAD = 0.15  # standard deviation of headings
_UP = np.array([0.0, 0.0, 1.0])


@dc.dataclass(frozen=True, eq=False)
class Placements:
    """Nodes of a skeleton that a hand can be aligned with, in table axes."""

    p: Array  # (n, 3) [m]
    direction: Array  # (n, 3) unit vector of the straight section; 0 where there is none
    rays: Array  # (n, RAYS, 3) unit vectors across it
    widths: Array  # (n, RAYS / 2) of the object along the first half of the rays [m]
    outward: Array  # (n, 3) unit vector out of an end point; 0 at other nodes

    def __getitem__(self, chosen: IntArray | Mask) -> "Placements":
        return Placements(*(getattr(self, field.name)[chosen] for field in dc.fields(self)))

    def __len__(self) -> int:
        return len(self.p)


def placements(skeleton: Skeleton, X_WT: Array, settings: PlannerSettings) -> Placements:
    """The nodes on straight sections, and the end points, of a skeleton in the world."""
    nodes = [_of_line(line, settings) for line in skeleton.lines]
    fields = [[getattr(part, field.name) for part in nodes] for field in dc.fields(Placements)]
    p, direction, rays, widths, outward = map(np.concatenate, fields)
    R = X_WT[:3, :3]
    return Placements((p - X_WT[:3, 3]) @ R, direction @ R, rays @ R, widths, outward @ R)


def propose_along_skeleton(
    site: Site, nodes: Placements, approach: str, rng: np.random.Generator
) -> Array:
    """Free poses X_WH (k, 4, 4) of one approach, from one round of draws."""
    drawn = nodes[_draw(nodes, site.center, site.settings.draws, rng)]
    if approach == "collect":
        return _collected(site, drawn, rng)
    if approach == "side":
        return _from_the_side(site, drawn, rng)
    return _from_anywhere(site, drawn, rng)


def _of_line(line: Line, settings: PlannerSettings) -> Placements:
    direction, outward = np.zeros_like(line.p), np.zeros_like(line.p)
    used = np.full(len(line.p), len(line.p) == 1)
    for section in straight_sections(
        line.p, tolerance_m=settings.straight_m, least_length_m=settings.section_m
    ):
        own = slice(section.first, section.last + 1)
        direction[own], used[own] = section.direction, True
    if len(line.p) > 1:
        outward[0] = -line.tangent[0] * line.free[0]
        outward[-1] = line.tangent[-1] * line.free[1]
    used |= outward.any(axis=1)
    return Placements(line.p, direction, line.rays, line.widths, outward)[used]


def _draw(nodes: Placements, center: Array, count: int, rng: np.random.Generator) -> IntArray:
    """Indices (count,): some end points, else nodes, those near the centre of mass more often."""
    beside = np.linalg.norm((nodes.p - center)[:, :2], axis=1)
    weight = _ANYWHERE + np.exp(-((beside / _NEAR_M) ** 2) / 2)
    weight /= weight.sum()
    ends = nodes.outward.any(axis=1)
    if ends.any():
        weight = (1 - _END_SHARE) * weight + _END_SHARE * ends / ends.sum()
    return rng.choice(len(nodes), size=count, p=weight)


def _collected(site: Site, nodes: Placements, rng: np.random.Generator) -> Array:
    """Fingers across sections that lie, along them at their ends, else where it is narrow."""
    count = len(nodes)
    closing = _narrow_rays(nodes, rng)
    lies = (np.abs(nodes.direction[:, 2]) < _LEVEL) & nodes.direction.any(axis=1)
    closing[lies] = np.cross(_UP, nodes.direction[lies])
    over_end = _is_level(nodes.outward) & (rng.random(count) < 0.5)
    closing[over_end] = nodes.outward[over_end]
    heading = np.arctan2(closing[:, 1], closing[:, 0]) + np.pi * rng.integers(0, 2, count)
    heading += _JITTER_RAD * rng.standard_normal(count)
    left = np.column_stack([-np.sin(heading), np.cos(heading), np.zeros(count)])
    return collect_poses(site, heading, nodes.p, (nodes.p * left).sum(axis=1), rng)


def _from_the_side(site: Site, nodes: Placements, rng: np.random.Generator) -> Array:
    """Fingers around sections that stand, or the palm against an end point."""
    stands = (np.abs(nodes.direction[:, 2]) > _LEVEL) | ~nodes.direction.any(axis=1)
    end = _is_level(nodes.outward)
    nodes, end = nodes[stands | end], end[stands | end]
    facing = np.cross(_narrow_rays(nodes, rng), _UP)
    facing *= rng.choice([-1.0, 1.0], len(nodes))[:, None]
    facing[end] = -nodes.outward[end]
    turn = _JITTER_RAD * rng.standard_normal(len(nodes))
    heading = np.arctan2(facing[:, 1], facing[:, 0]) + turn
    level = np.column_stack([np.cos(heading), np.sin(heading), np.zeros(len(nodes))])
    return side_poses(site, level, nodes.p, rng)


def _from_anywhere(site: Site, nodes: Placements, rng: np.random.Generator) -> Array:
    """Fingers around sections from all sides, or along the section at its end points."""
    count = len(nodes)
    closing = _narrow_rays(nodes, rng)
    closing *= rng.choice([-1.0, 1.0], count)[:, None]
    round_ = np.asarray(~nodes.direction.any(axis=1))  # A ball has no direction, so any will do.
    closing[round_] = rng.standard_normal((int(round_.sum()), 3))
    axis = np.where(round_[:, None], rng.standard_normal((count, 3)), nodes.direction)
    approach = np.cross(axis, closing) * rng.choice([-1.0, 1.0], count)[:, None]
    at_end = nodes.outward.any(axis=1) & (rng.random(count) < 0.5)
    approach[at_end] = -nodes.outward[at_end]
    approach = _unit(approach)
    closing = _unit(closing - (closing * approach).sum(axis=1, keepdims=True) * approach)
    return free_poses(site, approach, closing, nodes.p)


def _narrow_rays(nodes: Placements, rng: np.random.Generator) -> Array:
    """One ray (n, 3) of each cross section, drawn with odds that fall with the width there."""
    # The largest of numbers with Gumbel noise is a draw with their exponentials as odds.
    odds = rng.gumbel(size=nodes.widths.shape) - nodes.widths / _WIDTH_M
    rays: Array = nodes.rays[np.arange(len(nodes)), odds.argmax(axis=1)].copy()
    return rays


def _is_level(v: Array) -> Mask:
    """Which vectors (n, 3) are unit vectors near the horizontal."""
    return v.any(axis=1) & (np.abs(v[:, 2]) < _LEVEL)


def _unit(v: Array) -> Array:
    unit: Array = v / np.maximum(np.linalg.norm(v, axis=1, keepdims=True), 1e-12)
    return unit
