"""How the whole hand brings a fingertip to a touch, and back.

The palmar side of an open finger touches: there the contact presses the joints against
their open stops, so the finger does not yield as it would in its closing direction.
"""

import dataclasses as dc
from collections.abc import Iterator, Sequence

import numpy as np

from vh_drake.control.kinematics import ArmKinematics
from vh_drake.control.reach import rollout
from vh_drake.exploration.trajectory import approach_curves
from vh_drake.hand.clearance import Obstacles, link_clearance
from vh_drake.hand.model import HandModel
from vh_drake.hand.program import Leg, path
from vh_drake.types import Array, Immutable, TouchPlan


@dc.dataclass(frozen=True)
class TouchMotionSettings:
    """Distances and postures of a touch."""

    standoff_m: float = 0.05  # from where the guarded approach starts
    beyond_m: float = 0.04  # behind the estimate, until which the finger searches
    table_clearance_m: float = 0.004
    least_pad_height_m: float = 0.021  # of the pad over the table; the tip reaches below it
    palm_clearance_m: float = 0.006  # of links that shall not touch, at the contact
    tip_clearance_m: float = -0.004  # of the other fingertips, at the contact
    travel_clearance_m: float = 0.012  # before the approach
    safe_height_m: float = 0.05  # of the lowest finger over the object in transit
    # Of the fingers about the touched normal, from pointing down; tried in this order.
    rolls_deg: tuple[float, ...] = (0, 20, -20, 40, -40, 60, -60, 80, -80, 100, -100)
    settle_s: float = 0.4
    least_transit_m: float = 0.24  # lowest transit height of the hand frame over the table


@dc.dataclass(frozen=True, eq=False)
class TouchMotion(Immutable):
    """A touch that the arm can do."""

    plan: TouchPlan  # its curve starts at the fingertip's standoff
    legs: tuple[Leg, ...]  # to the touch
    retreat: tuple[Leg, ...]  # and away from it


def pad_in_hand(hand: HandModel) -> tuple[Array, Array]:
    """Place and outward normal (3,) of the touching pad in H: of the finger that reaches farthest.

    Thumbs are left out; the hand is open.
    """
    pads, normals = pads_in_hand(hand)
    best = int(np.argmax(pads @ np.asarray(hand.description.along)))
    return pads[best], normals[best]


def pads_in_hand(hand: HandModel) -> tuple[Array, Array]:
    """Places and outward unit normals (f, 3) of the pads of the open hand's fingers in H."""
    poses = hand.link_poses(hand.lower)
    ends = hand.arrays.first_joint[1:]
    rows = [
        (poses[end], finger)
        for i, (end, finger) in enumerate(zip(ends, hand.description.fingers, strict=True))
        if not hand.opposing[i]
    ]
    p = np.array([X[:3, :3] @ np.array(f.p_pad) + X[:3, 3] for X, f in rows])
    n = np.array([X[:3, :3] @ np.array(f.n_pad) for X, f in rows])
    return p, n / np.linalg.norm(n, axis=1, keepdims=True)


def fingertip_frame(hand: HandModel) -> Array:
    """X_HT (4, 4): origin on the touching pad, z out of it, the way it approaches."""
    p, n = pad_in_hand(hand)
    along = np.asarray(hand.description.along, float)
    y = np.cross(n, along) / np.linalg.norm(np.cross(n, along))
    X = np.eye(4)
    X[:3, :3] = np.column_stack([np.cross(y, n), y, n])
    X[:3, 3] = p
    return X


def touching_poses(
    plan: TouchPlan, X_HT: Array, up: Array, settings: TouchMotionSettings
) -> Iterator[Array]:
    """Hand poses X_WH (4, 4) that put the pad flat on the target, one a roll."""
    down = _tangent(-up, plan.n_WT)
    if np.linalg.norm(down) < 1e-6:  # From straight above: rolls count from forwards instead.
        down = _tangent(np.array([1.0, 0.0, 0.0]), plan.n_WT)
    down /= np.linalg.norm(down)
    side = np.cross(plan.n_WT, down)
    for roll in np.deg2rad(settings.rolls_deg):
        x = np.cos(roll) * down + np.sin(roll) * side
        X_WT = np.eye(4)
        X_WT[:3, :3] = np.column_stack([x, np.cross(-plan.n_WT, x), -plan.n_WT])
        X_WT[:3, 3] = plan.p_WT
        yield X_WT @ np.linalg.inv(X_HT)


def _tangent(v: Array, n: Array) -> Array:
    """The part of v (3,) that is perpendicular to a unit vector n (3,)."""
    return v - (v @ n) * n


def find_touch(
    plans: Sequence[TouchPlan],
    scene: Obstacles,
    hand: HandModel,
    kinematics: ArmKinematics,
    q: Array,
    settings: TouchMotionSettings | None = None,
) -> TouchMotion | None:
    """The first plan, with the first roll, that the arm can do without hitting anything.

    Args:
        plans: best first.
        scene: estimate and table.
        hand: open.
        kinematics: of the arm.
        q: its joint positions now (8,) [rad].
        settings: distances and postures.

    Returns:
        None where no plan is feasible.
    """
    settings = settings or TouchMotionSettings()
    X_HT = fingertip_frame(hand)
    for wanted in plans:
        plan = _levelled(wanted, scene, settings)
        for X_WH in touching_poses(plan, X_HT, scene.table.normal, settings):
            if not _is_clear(hand, X_WH, plan.n_WT, scene, settings):
                continue
            motion = _motion(plan, X_WH, X_HT, scene, hand, kinematics.pose(q), settings)
            if _reaches(kinematics, q, motion, X_WH, plan.n_WT, settings):
                return motion
    return None


def _levelled(plan: TouchPlan, scene: Obstacles, s: TouchMotionSettings) -> TouchPlan:
    """Low and undercut places are approached level, at the least height of the pad."""
    up = scene.table.normal
    missing = s.least_pad_height_m - float(scene.table.height(plan.p_WT))
    level = plan.n_WT - (plan.n_WT @ up) * up
    if (missing <= 0 and plan.n_WT @ up >= 0) or np.linalg.norm(level) < 0.3:
        return plan
    n_WT = level / np.linalg.norm(level)
    return dc.replace(plan, p_WT=plan.p_WT + max(missing, 0.0) * up, n_WT=n_WT)


def _is_clear(
    hand: HandModel, X_WH: Array, n_WT: Array, scene: Obstacles, s: TouchMotionSettings
) -> bool:
    """Whether only the fingertips come near the object, and nothing near the table."""
    links, table = link_clearance(hand, X_WH, scene)
    tips = hand.arrays.first_joint[1:][hand.opposing == 0]
    others = np.delete(links, tips)
    if table < s.table_clearance_m or others.min() < s.palm_clearance_m:
        return False
    if links[tips].min() < s.tip_clearance_m:
        return False
    for share in (0.5, 1.0):
        links, table = link_clearance(hand, shifted(X_WH, share * s.standoff_m * n_WT), scene)
        if table < s.table_clearance_m or links.min() < share * s.travel_clearance_m:
            return False
    return True


def shifted(X_WH: Array, shift_W: Array) -> Array:
    """The pose moved by a vector of the world."""
    X = X_WH.copy()
    X[:3, 3] += shift_W
    return X


def _motion(
    plan: TouchPlan,
    X_WH: Array,
    X_HT: Array,
    scene: Obstacles,
    hand: HandModel,
    X_WH_now: Array,
    s: TouchMotionSettings,
) -> TouchMotion:
    """Up, over, down behind the object, settle, then the guarded curve."""
    before = shifted(X_WH, s.standoff_m * plan.n_WT)
    above = shifted(before, _rise(hand, before, scene, s) * scene.table.normal)
    height = max(scene.table.height(above[:3, 3]), scene.table.height(X_WH_now[:3, 3]))
    raised = shifted(X_WH_now, (height - scene.table.height(X_WH_now[:3, 3])) * scene.table.normal)
    over = shifted(above, (height - scene.table.height(above[:3, 3])) * scene.table.normal)
    open_hand = np.zeros(len(hand.description.motors))
    start = (before @ X_HT)[:3, 3]
    curve = approach_curves(start, None, plan.p_WT[None], plan.n_WT[None])[0]
    touch = dc.replace(plan, control_points=curve)
    names = ["raise the hand", "over to the touch", "down to the touch"]
    legs = path(X_WH_now, [raised, over, before], names, open_hand)
    settle = Leg("settle", before, open_hand, s.settle_s)
    feel = Leg("feel", X_WH, open_hand, 10.0, guarded=True, touch=touch)
    away = path(X_WH, [before, over], ["away from the touch", "up"], open_hand)
    return TouchMotion(touch, (*legs, settle, feel), away)


def _rise(hand: HandModel, before: Array, scene: Obstacles, s: TouchMotionSettings) -> float:
    """How far the hand must go up so that it clears the object's top [m]."""
    lowest = link_clearance(hand, before, scene)[1]
    frame = float(scene.table.height(before[:3, 3]))
    return max(scene.top_m + s.safe_height_m - lowest, s.least_transit_m - frame, 0.0)


def _reaches(
    kinematics: ArmKinematics,
    q: Array,
    motion: TouchMotion,
    X_WH: Array,
    n_WT: Array,
    s: TouchMotionSettings,
) -> bool:
    search = shifted(X_WH, -s.beyond_m * n_WT)
    waypoints = [*(leg.X_WH for leg in motion.legs[:-2]), search]
    return rollout(kinematics, q, waypoints).reached
