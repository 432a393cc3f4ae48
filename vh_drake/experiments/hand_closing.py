"""A hand that closes kinematically around estimates and true meshes, for whole-hand exploration."""

import dataclasses as dc

import numpy as np
from scipy.spatial import cKDTree

from vh_drake.exploration.whole_hand import Closer, Hand, HandAim, HandContacts
from vh_drake.geometry.meshes import TriMesh
from vh_drake.geometry.signed_distance import signed_distance_grid
from vh_drake.gpis.following import Sheet
from vh_drake.grasping.closing import close_hand
from vh_drake.grasping.field import ObjectField
from vh_drake.grasping.motions import MotionArrays, side_motion
from vh_drake.hand.model import HandModel
from vh_drake.types import Array, Plane, ScalarGrid

_NO_TABLE = Plane(np.array([0.0, 0.0, 1.0]), -100.0)
_TRUE_SPACING_M = 0.003
_SPACING_M = 0.006  # of an estimate's field
_PADDING_M = 0.02
_CLOSED = 0.5  # share of the motors' travel at which the fingertips' middle is aimed with
_FARTHEST_M = 0.3  # along an approach


def true_closer(hand: HandModel, mesh: TriMesh) -> Closer:
    """Closes a hand on a true mesh, by its signed distance."""
    grid = signed_distance_grid(mesh, spacing=_TRUE_SPACING_M, padding=_PADDING_M)
    return _closer(hand, side_motion(hand), grid)


def planned_hand(hand: HandModel) -> Hand:
    """What plans closings on estimates."""
    motion = side_motion(hand)
    return Hand(lambda sheet: _closer(hand, motion, sheet_distance(sheet)), hand_aim(hand))


def hand_aim(hand: HandModel) -> HandAim:
    """The hand comes out of its palm or along its approach; palm or fingertips over the target."""
    d = hand.description
    half_closed = hand.joint_angles(np.full(len(d.motors), _CLOSED))
    tips = hand.tips(half_closed)[hand.opposing == 0]
    unit = [np.asarray(v, float) / np.linalg.norm(v) for v in (d.palm, d.approach, d.along)]
    return HandAim(
        approaches=np.array(unit[:2]),
        along=unit[2],
        places=np.array([d.tcps["power"], tips.mean(axis=0)]),
    )


def sheet_distance(sheet: Sheet) -> ScalarGrid:
    """Signed distance [m] around an open estimate, from its vertices and normals.

    Beside the nearest vertex it is the distance of the tangent plane; what lies beyond the edge
    of the estimate counts as free.
    """
    p = sheet.vertices
    low = p.min(axis=0) - _PADDING_M
    count = np.ceil((np.ptp(p, axis=0) + 2.0 * _PADDING_M) / _SPACING_M).astype(int) + 1
    axes = [a + _SPACING_M * np.arange(k) for a, k in zip(low, count, strict=True)]
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    distance, nearest = cKDTree(p).query(nodes)
    along = np.einsum("ij,ij->i", nodes - p[nearest], sheet.normals[nearest])
    aside = np.sqrt(np.maximum(distance**2 - along**2, 0.0))
    beyond = aside > np.maximum(2.0 * _SPACING_M, np.abs(along))
    gap = np.where(aside > _SPACING_M, distance, np.abs(along))
    values = np.where(beyond | (along > 0.0), gap, -gap)
    return ScalarGrid(low, _SPACING_M, values.reshape(tuple(count)))


def _closer(hand: HandModel, motion: MotionArrays, grid: ScalarGrid) -> Closer:
    field = ObjectField(grid, _NO_TABLE, np.zeros(3), 1.0)
    tips = hand.arrays.first_joint[1:]  # the last link of each finger

    def close(X_WH: Array, approach_H: Array) -> HandContacts:
        description = dc.replace(hand.description, palm=[float(x) for x in approach_H])
        coming = dc.replace(hand, description=description)
        closure = close_hand(coming, field, motion, X_WH, palm_advance_m=_FARTHEST_M)
        own = np.isin(closure.links, tips)
        return HandContacts(closure.p_WC[own], closure.n_WC[own])

    return close
