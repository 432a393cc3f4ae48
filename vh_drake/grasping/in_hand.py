"""How well an object lies between thumb and fingers before they close.

Kinematic closing does not move the object; a real hand does. In simulated lifts of boxes,
cylinders and balls the collecting grasp held what lay 35 mm before the power TCP along the
fingers and 28 mm towards the thumb, midway between the thumb and the fingers that oppose it,
and lost what lay 15 mm beside that: the thumb slips off the object's end, or past it. The
grasp from the side wants the object 50 mm before the TCP. Objects held across their narrow
side turn less than those held across a diagonal.
"""

import dataclasses as dc

import numpy as np

from vh_drake.geometry.meshes import Mask
from vh_drake.grasping.field import ObjectField
from vh_drake.grasping.motions import hand_axes
from vh_drake.hand.model import HandModel
from vh_drake.types import Array

_HEADINGS = 36


@dc.dataclass
class PlaceSettings:
    """Where the object should lie, relative to the power TCP, and how exactly [m]."""

    collect_along_m: float = 0.035  # middle of the object's slice before the TCP
    collect_beside_m: float = 0.028  # centre of mass beside it, towards the thumb's side
    side_along_m: float = 0.05
    along_std_m: float = 0.012
    beside_std_m: float = 0.016
    width_std_m: float = 0.02  # beyond the object's narrowest side
    collect_band_m: list[float] = dc.field(default_factory=lambda: [-0.03, 0.07])
    side_band_m: list[float] = dc.field(default_factory=lambda: [-0.045, 0.06])


@dc.dataclass(frozen=True, eq=False)
class Lie:
    """How an object lies in the open hands of n candidates of one motion, in metres."""

    met: Mask  # (n,) whether any of it lies in the fingers' band
    middle: Array  # (n,) of its slice in that band before the power TCP, along the fingers
    excess: Array  # (n,) of the slice's length over the object's narrowest side
    beside: Array  # (n,) its centre of mass beside the power TCP, towards the thumb's side


def lie_in_hand(
    X_WH: Array,
    motion: str,
    vertices: Array,
    field: ObjectField,
    hand: HandModel,
    settings: PlaceSettings,
) -> Lie:
    """Where the object is between thumb and fingers before they close.

    Args:
        X_WH: hand poses (n, 4, 4) in which the closing starts.
        motion: "collect" or "side".
        vertices: of the surface (v, 3).
        field: the same with its centre of mass.
        hand: the hand.
        settings: the fingers' band.
    """
    along, beside = _directions(X_WH, motion, field, hand)
    tcp = np.asarray(hand.description.tcps["power"])
    p_WTcp = X_WH[:, :3, :3] @ tcp + X_WH[:, :3, 3]
    low, high = settings.collect_band_m if motion == "collect" else settings.side_band_m
    origin = p_WTcp if motion == "collect" else X_WH[:, :3, 3]
    offset = beside @ vertices.T - (beside * origin).sum(axis=1)[:, None]
    position = along @ vertices.T - (along * p_WTcp).sum(axis=1)[:, None]
    outside = (offset < low) | (offset > high)
    first = np.where(outside, np.inf, position).min(axis=1)
    last = np.where(outside, -np.inf, position).max(axis=1)
    met = first <= last
    first, last = np.where(met, first, 0.0), np.where(met, last, 0.0)
    excess = np.maximum(last - first - narrowest(vertices, field.table.normal), 0.0)
    center = (beside * (field.center - p_WTcp)).sum(axis=1)
    return Lie(met, (first + last) / 2, excess, center)


def well_placed(
    X_WH: Array,
    motion: str,
    vertices: Array,
    field: ObjectField,
    hand: HandModel,
    settings: PlaceSettings,
) -> Array:
    """Factor (n,) in 0..1 of candidates of one motion; arguments as `lie_in_hand`."""
    lie = lie_in_hand(X_WH, motion, vertices, field, hand, settings)
    wanted = settings.collect_along_m if motion == "collect" else settings.side_along_m
    fit = _bell(lie.middle - wanted, settings.along_std_m)
    fit *= _bell(lie.excess, settings.width_std_m)
    if motion == "collect":
        fit *= _bell(lie.beside - settings.collect_beside_m, settings.beside_std_m)
    placed: Array = np.where(lie.met, fit, 0.0)
    return placed


def narrowest(vertices: Array, up: Array) -> float:
    """The least width of an object among level directions [m]."""
    basis = np.linalg.svd(np.asarray(up, dtype=float)[None])[2][1:]
    angles = np.linspace(0.0, np.pi, _HEADINGS, endpoint=False)
    positions = vertices @ basis.T @ np.stack([np.cos(angles), np.sin(angles)])
    return float(np.ptp(positions, axis=0).min())


def _directions(
    X_WH: Array, motion: str, field: ObjectField, hand: HandModel
) -> tuple[Array, Array]:
    """Unit vectors (n, 3) along the fingers, level, and towards the thumb's side."""
    up = np.asarray(field.table.normal, dtype=float)
    fingers, palm = hand_axes(hand)
    along = X_WH[:, :3, :3] @ fingers
    along -= (along @ up)[:, None] * up
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-9)
    if motion == "side":
        return along, np.tile(up, (len(X_WH), 1))
    thumbs = hand.tips(hand.lower)[hand.opposing == 1]
    across = np.cross(fingers, palm)
    side = np.sign(thumbs.mean(axis=0) @ across) if len(thumbs) else 1.0
    return along, side * (X_WH[:, :3, :3] @ across)


def _bell(x: Array, std: float) -> Array:
    bell: Array = np.exp(-((x / std) ** 2) / 2)
    return bell
