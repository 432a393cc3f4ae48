"""How the whole hand brings a fingertip to a touch, and back.

The palmar side of an open finger touches: there the contact presses the joints against
their open stops, so the finger does not yield as it would in its closing direction.
"""

import dataclasses as dc
from collections.abc import Iterator, Sequence
from itertools import chain

import numpy as np

from vh_drake.control.arm_collisions import ArmCollisions
from vh_drake.control.kinematics import ArmKinematics
from vh_drake.control.reach import rollout
from vh_drake.exploration.trajectory import approach_curves
from vh_drake.geometry.signed_distance import interpolate
from vh_drake.hand.clearance import Obstacles, link_clearance
from vh_drake.hand.model import HandModel
from vh_drake.hand.program import Leg, path
from vh_drake.types import Array, Immutable, ObjectView, TouchPlan

_STEP_M = 0.001
_WAY = 8  # poses that stand for an approach


@dc.dataclass(frozen=True)
class TouchMotionSettings:
    """Distances and postures of a touch."""

    standoff_m: float = 0.05  # from where the guarded approach starts
    beyond_m: float = 0.04  # behind the estimate, until which the finger searches
    table_clearance_m: float = 0.004
    # Below this height the round end of the finger touches, not the pad, which it outreaches.
    low_m: float = 0.03
    # From the pad's normal towards the fingertip, in the order of trying: the first touches
    # lowest, the second is within reach of the arm from every side.
    low_tilts_deg: tuple[float, ...] = (22.0, 0.0)
    least_height_m: float = 0.0132  # of a touch over the table
    low_share: float = 0.45  # highest low touch, of the object's height
    palm_clearance_m: float = 0.006  # of links that shall not touch, at the contact
    tip_clearance_m: float = -0.004  # of the other fingertips, at the contact
    travel_clearance_m: float = 0.012  # before the approach
    safe_height_m: float = 0.05  # of the lowest finger over the object in transit
    # Of the fingers about the touched normal, from pointing down; tried in this order.
    rolls_deg: tuple[float, ...] = (0, 20, -20, 40, -40, 60, -60, 80, -80, 100, -100)
    # Cosine between the normal where the hand will first meet the estimate and the direction
    # to the camera, below which a touch is surely hidden; the least is taken where none is.
    most_facing_camera: float = -0.42
    # A push that passes the object's middle turns it, and another finger may meet it elsewhere:
    # what that costs, in the same cosine, beyond a lever that friction bears.
    borne_lever_m: float = 0.01
    lever_cost_per_m: float = 6.0
    estimate_error_m: float = 0.003  # by which another finger may come first
    # What it is worth, in the same cosine, that a touch tells of the camera's pose.
    worth_per_m: float = 100.0
    most_compared: int = 200  # feasible touches among which the least is sought
    settle_s: float = 0.4
    least_transit_m: float = 0.24  # lowest transit height of the hand frame over the table


@dc.dataclass(frozen=True, eq=False)
class TouchMotion(Immutable):
    """A touch that the arm can do."""

    plan: TouchPlan  # where the hand will meet the estimate; the curve is the pad's
    legs: tuple[Leg, ...]  # to the touch
    retreat: tuple[Leg, ...]  # and away from it

    def way(self, X_WH: Array) -> list[Array]:
        """Hand poses (4, 4), from where the guarded approach starts to where it ended."""
        start = self.legs[-2].X_WH[:3, 3]
        shares = np.linspace(1.0, 0.0, _WAY)
        return [shifted(X_WH, share * (start - X_WH[:3, 3])) for share in shares]


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


def finger_end_frame(hand: HandModel, tilt_rad: float) -> Array:
    """X_HE (4, 4): like `fingertip_frame`, on the finger's round end, z tilted towards the tip."""
    pads = pads_in_hand(hand)[0]
    fingers = np.flatnonzero(hand.opposing == 0)
    finger = fingers[np.argmax(pads @ np.asarray(hand.description.along))]
    centers, radii = hand.spheres(hand.lower)
    end = hand.tip_spheres[finger]
    X_HT = fingertip_frame(hand)
    z = np.cos(tilt_rad) * X_HT[:3, 2] + np.sin(tilt_rad) * X_HT[:3, 0]
    y = X_HT[:3, 1]
    X = np.eye(4)
    X[:3, :3] = np.column_stack([np.cross(y, z), y, z])
    X[:3, 3] = centers[end] + radii[end] * z
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
    view: ObjectView,
    settings: TouchMotionSettings | None = None,
    *,
    collisions: ArmCollisions | None = None,
) -> TouchMotion | None:
    """The first plan, with the first roll, that the arm can do and that meets a hidden place.

    Args:
        plans: best first.
        scene: estimate and table.
        hand: open.
        kinematics: of the arm.
        q: its joint positions now (8,) [rad].
        view: from whose camera the touched place shall be hidden, or, where its pose is known
            badly, that the touched place shall tell of.
        settings: distances and postures.
        collisions: of arm and hand with robot and table, which the way must be free of.

    Returns:
        None where no plan is feasible.
    """
    settings = settings or TouchMotionSettings()
    X_WH_now, best, least = kinematics.pose(q), None, np.inf
    most_told = float(np.sqrt(np.linalg.eigvalsh(view.shift_covariance)[-1]))
    enough = settings.most_facing_camera - settings.worth_per_m * most_told
    for count, (plan, X_WH, contact) in enumerate(_clear_touches(plans, scene, hand, settings)):
        cost = _cost(contact, plan, scene, view, settings)
        if cost >= least:
            continue
        pad = fingertip_frame(hand)
        motion = _motion(plan, X_WH, pad, scene, hand, X_WH_now, settings)
        search = shifted(X_WH, -settings.beyond_m * plan.n_WT)
        way = rollout(kinematics, q, [*(leg.X_WH for leg in motion.legs[:-2]), search])
        if way.reached and not (collisions and collisions.first(way.q, scene.table_height_m)):
            predicted = dc.replace(motion.plan, p_WT=contact[0][0], n_WT=contact[1][0])
            best, least = dc.replace(motion, plan=predicted), cost
        if least <= enough or (best and count > settings.most_compared):
            break
    return best


def _cost(
    contacts: tuple[Array, Array],
    plan: TouchPlan,
    scene: Obstacles,
    view: ObjectView,
    s: TouchMotionSettings,
) -> float:
    """Less for a hidden place, for one that tells of the camera's pose, and for a short lever."""
    p_WC, n_WC = (rows[0] for rows in contacts)
    told = float(np.sqrt(max(n_WC @ view.shift_covariance @ n_WC, 0.0)))
    lever = abs(float(np.cross(p_WC - scene.center, plan.n_WT) @ scene.table.normal))
    turning = s.lever_cost_per_m * max(lever - s.borne_lever_m, 0.0)
    return _most_facing(contacts, view.p_WCamera) + turning - s.worth_per_m * told


def _clear_touches(
    plans: Sequence[TouchPlan], scene: Obstacles, hand: HandModel, s: TouchMotionSettings
) -> Iterator[tuple[TouchPlan, Array, tuple[Array, Array]]]:
    """Plans as they are approached, hand poses X_WH, and where these may meet the estimate."""
    up, pad = scene.table.normal, fingertip_frame(hand)
    ends = [finger_end_frame(hand, tilt) for tilt in np.deg2rad(s.low_tilts_deg)]
    for wanted in plans:
        low = float(scene.table.height(wanted.p_WT)) < s.low_m
        plan = _levelled(wanted, scene, s, low=low)
        for X_WH in chain(*(touching_poses(plan, X, up, s) for X in (ends if low else [pad]))):
            if not _is_clear(hand, X_WH, plan.n_WT, scene, s):
                continue
            contacts = first_contacts(hand, X_WH, plan.n_WT, scene, s)
            if len(contacts[0]):
                yield plan, X_WH, contacts


def first_contacts(
    hand: HandModel, X_WH: Array, n_WT: Array, scene: Obstacles, s: TouchMotionSettings
) -> tuple[Array, Array]:
    """Where the open hand may first meet the object on its way against n_WT.

    Returns:
        Positions and outward normals (k, 3) on the estimate, the first contact first, then
        those that come as near by then as the estimate may be wrong; none where it passes by.
    """
    centers, radii = hand.spheres(hand.lower)
    start = centers @ X_WH[:3, :3].T + X_WH[:3, 3]
    for way in np.arange(-s.standoff_m, s.beyond_m, _STEP_M):
        p_WS = start - way * n_WT
        gaps, gradients = interpolate(scene.distance, p_WS)
        nearest = int(np.argmin(gaps - radii))
        if gaps[nearest] < radii[nearest]:
            order = np.argsort(gaps - radii, kind="stable")
            near = order[(gaps - radii)[order] < s.estimate_error_m]
            lengths = np.linalg.norm(gradients[near], axis=1, keepdims=True)
            normals = gradients[near] / np.maximum(lengths, 1e-9)
            return p_WS[near] - gaps[near, None] * normals, normals
    return np.zeros((0, 3)), np.zeros((0, 3))


def _most_facing(contacts: tuple[Array, Array], p_WCamera: Array) -> float:
    """The largest cosine between normals and the directions to the camera."""
    return max(_cosine(n, p_WCamera - p) for p, n in zip(*contacts, strict=True))


def _cosine(a: Array, b: Array) -> float:
    return float(a @ b / max(float(np.linalg.norm(a) * np.linalg.norm(b)), 1e-12))


def _levelled(plan: TouchPlan, scene: Obstacles, s: TouchMotionSettings, *, low: bool) -> TouchPlan:
    """Low and undercut places are approached level; low ones as low as a finger reaches."""
    up = scene.table.normal
    level = plan.n_WT - (plan.n_WT @ up) * up
    if (not low and plan.n_WT @ up >= 0) or np.linalg.norm(level) < 0.3:
        return plan
    height = float(scene.table.height(plan.p_WT))
    wanted = max(min(height, s.low_share * scene.top_m), s.least_height_m) if low else height
    n_WT = level / np.linalg.norm(level)
    return dc.replace(plan, p_WT=plan.p_WT + (wanted - height) * up, n_WT=n_WT)


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
    start, pad = before @ X_HT, X_WH @ X_HT
    curve = approach_curves(start[:3, 3], None, pad[None, :3, 3], plan.n_WT[None])[0]
    touch = dc.replace(plan, control_points=curve)
    followed = TouchPlan(pad[:3, 3], -pad[:3, 2], curve, plan.rating)
    names = ["raise the hand", "over to the touch", "down to the touch"]
    legs = path(X_WH_now, [raised, over, before], names, open_hand)
    settle = Leg("settle", before, open_hand, s.settle_s)
    feel = Leg("feel", X_WH, open_hand, 10.0, guarded=True, touch=followed)
    away = path(X_WH, [before, over], ["away from the touch", "up"], open_hand)
    return TouchMotion(touch, (*legs, settle, feel), away)


def _rise(hand: HandModel, before: Array, scene: Obstacles, s: TouchMotionSettings) -> float:
    """How far the hand must go up so that it clears the object's top [m]."""
    lowest = link_clearance(hand, before, scene)[1]
    frame = float(scene.table.height(before[:3, 3]))
    return max(scene.top_m + s.safe_height_m - lowest, s.least_transit_m - frame, 0.0)
