"""The spheres of a hand in bunches, each within a ball, so that far ones are passed over."""

from typing import NamedTuple

import numpy as np

from vh_drake.hand.kinematics import HandArrays
from vh_drake.types import Array, IntArray

_LARGEST_BUNCH = 10


class Bunches(NamedTuple):
    """The m spheres of a hand in b bunches, sorted by link; n joints."""

    link: IntArray  # (b,) that carries the bunch
    first_bunch: IntArray  # (n + 2,) link i owns bunches first_bunch[i] to first_bunch[i + 1]
    ball_center: Array  # (b, 3) of a ball around the bunch, in the link's frame [m]
    ball_radius: Array  # (b,) [m]
    first_sphere: IntArray  # (b + 1,) bunch i owns spheres first_sphere[i] to first_sphere[i + 1]
    sphere_center: Array  # (m, 3) in the link's frame [m]
    sphere_radius: Array  # (m,) [m]


def bunches_of(hand: HandArrays) -> Bunches:
    """Bunches of at most 10 spheres that lie near each other on one link."""
    members, link = [], []
    for i in range(len(hand.first_sphere) - 1):
        own = np.arange(hand.first_sphere[i], hand.first_sphere[i + 1])
        parts = _halved(own, hand.sphere_center)
        members += parts
        link += [i] * len(parts)
    balls = [_enclosing_ball(hand.sphere_center[m], hand.sphere_radius[m]) for m in members]
    order = np.concatenate(members)
    return Bunches(
        link=np.array(link, np.int64),
        first_bunch=np.searchsorted(link, np.arange(len(hand.first_sphere))).astype(np.int64),
        ball_center=np.array([center for center, _ in balls]),
        ball_radius=np.array([radius for _, radius in balls]),
        first_sphere=np.cumsum([0, *map(len, members)]),
        sphere_center=np.ascontiguousarray(hand.sphere_center[order]),
        sphere_radius=np.ascontiguousarray(hand.sphere_radius[order]),
    )


def _halved(own: IntArray, centers: Array) -> list[IntArray]:
    """Indices of spheres, halved along the longest side of their box until they are few."""
    if len(own) <= _LARGEST_BUNCH:
        return [own] if len(own) else []
    sides = np.ptp(centers[own], axis=0)
    own = own[np.argsort(centers[own, sides.argmax()], kind="stable")]
    half = len(own) // 2
    return _halved(own[:half], centers) + _halved(own[half:], centers)


def _enclosing_ball(p: Array, r: Array) -> tuple[Array, float]:
    """A ball around spheres, centred in the box of their centres."""
    middle = (p.min(axis=0) + p.max(axis=0)) / 2
    return middle, float((np.linalg.norm(p - middle, axis=1) + r).max())
