"""From a rated candidate to the motion that executes it (section 4.5.4)."""

import dataclasses as dc
from collections.abc import Iterator, Sequence

import numpy as np

from vh_drake.control.arm_collisions import ArmCollisions
from vh_drake.control.kinematics import ArmKinematics
from vh_drake.control.reach import rollout
from vh_drake.hand.clearance import Obstacles, link_clearance
from vh_drake.hand.model import HandModel
from vh_drake.hand.program import SLOW_M_S, Leg, interpolate, path, travel_time
from vh_drake.types import Array, Candidates, Plane

CLOSINGS = ("closed_loop", "open_loop")
_LOOKS, _OFF_M = 25, 0.02  # poses of a way between which nothing is missed, their clearance
_RISES_M = (0.05, 0.1, 0.15, 0.2)  # of a hand that lets go, before it travels back


@dc.dataclass(frozen=True)
class GraspMotionSettings:
    """Distances and times of a grasp.

    Closed in an open loop, hand and fingers play the coordinated motion of section 4.5.4 as a
    tape. In a closed loop the hand follows the fingers' measured travel, stands still once they
    have found the object, and yields to the force at the wrist, which brings it over the object.
    With `weigh_m` the wrist tells after a piece of the lift whether anything is held; if not,
    the hand goes down, opens, moves towards what resisted it, and closes once more. That is left
    out by default: long objects still rest on the table then, and feel like nothing.
    """

    standoff_m: float = 0.12  # of a side grasp, against the palm's direction
    safe_height_m: float = 0.04  # of the lowest finger over the object in transit
    least_transit_m: float = 0.24  # lowest transit height of the hand frame over the table
    guard_n: float = 4.0  # force that ends the approach
    gather_s: float = 1.2  # fingers to half, thumb to a fifth, or as the hand's description has it
    press_s: float = 0.8  # of a hand that presses
    close_s: float = 0.8
    squeeze_s: float = 0.6
    gather_fingers: float = 0.5
    gather_thumb: float = 0.2
    closing: str = "closed_loop"  # of CLOSINGS
    yields: bool = True  # a closed loop, to forces on the hand
    weigh_m: float = 0.0  # piece of the lift after which a closed loop weighs; 0: it does not
    least_load_n: float = 0.12
    seek_m: float = 0.015  # of a second closing, towards what resisted the first
    lift_m: float = 0.23  # 15 cm, what a heavy object may sag, and what a closing hand yields
    hang_m: float = 0.05  # more for a collecting hand: what it takes lies, and hangs once lifted
    lift_s: float = 1.6
    hold_s: float = 3.2

    def rise_m(self, motion: str) -> float:
        """How high a closing motion lifts [m]."""
        return self.lift_m + (self.hang_m if motion == "collect" else 0.0)


def find_grasp(
    candidates: Candidates,
    ranking: Sequence[int],
    scene: Obstacles,
    hand: HandModel,
    kinematics: ArmKinematics,
    q: Array,
    settings: GraspMotionSettings | None = None,
    *,
    collisions: ArmCollisions | None = None,
) -> tuple[int, tuple[Leg, ...]] | None:
    """The best candidate that the arm can execute, and its motion.

    Args:
        candidates: poses in which the closing starts.
        ranking: their indices, best first.
        scene: estimate and table.
        hand: open.
        kinematics: of the arm.
        q: its joint positions now (8,) [rad].
        settings: distances and times.
        collisions: of arm and hand with robot and table, which the way must be free of.

    Returns:
        Index of the candidate and legs; None where the arm can reach none.
    """
    settings = settings or GraspMotionSettings()
    X_WH_now, home = kinematics.pose(q), kinematics.pose(kinematics.home)
    for index in ranking:
        motion = candidates.motion[index]
        over = approach_poses(candidates.X_WH[index], motion, scene, hand, X_WH_now, settings)
        for approach in _ways(over, motion, scene, hand, home):
            if _can_go([*approach.values()], motion, scene, kinematics, q, settings, collisions):
                return index, _legs(approach, motion, hand, X_WH_now, settings)
    return None


def _ways(
    over: list[Array], motion: str, scene: Obstacles, hand: HandModel, home: Array
) -> Iterator[dict[str, Array]]:
    """Poses by the name of the leg that leads there.

    First the way over the object, and for a side grasp one that goes from home straight beside
    it: where the hand faces away from the robot, the arm often can't hold it that high.
    """
    names = ["raise the hand", "over to the grasp", "down beside the object"]
    yield dict(zip([*names[: len(over) - 1], "approach"], over, strict=True))
    if motion == "side":
        raised, _, beside, last = over
        shares = np.linspace(0.0, 1.0, _LOOKS)
        between = (
            interpolate(X_WA, X_WB, share)
            for X_WA, X_WB in ((raised, home), (home, beside))
            for share in shares
        )
        if all(_is_off(X_WH, scene, hand) for X_WH in between):
            yield {
                "raise the hand": raised,
                "back": home,
                "beside the object": beside,
                "approach": last,
            }


def _is_off(X_WH: Array, scene: Obstacles, hand: HandModel) -> bool:
    """Whether the open hand is well off the object."""
    return bool(link_clearance(hand, X_WH, scene)[0].min() > _OFF_M)


def _can_go(
    approach: list[Array],
    motion: str,
    scene: Obstacles,
    kinematics: ArmKinematics,
    q: Array,
    settings: GraspMotionSettings,
    collisions: ArmCollisions | None,
) -> bool:
    """Whether the arm can go through the poses and lift, and meets nothing known."""
    lifted = approach[-1].copy()
    lifted[:3, 3] += settings.rise_m(motion) * scene.table.normal
    way = rollout(kinematics, q, [*approach, lifted])
    return way.reached and not (collisions and collisions.first(way.q, scene.table_height_m))


def release_legs(
    hand: HandModel,
    kinematics: ArmKinematics,
    q: Array,
    table: Plane,
    *,
    collisions: ArmCollisions | None = None,
) -> tuple[Leg, ...]:
    """Legs that let go of what failed, and clear the camera's view.

    The hand rises as little as keeps the way back free. Where no way is, it takes the last of
    the heights that were tried: it can't stay.

    Args:
        hand: that opens.
        kinematics: of the arm.
        q: its joint positions now (8,) [rad].
        table: below the hand.
        collisions: of arm and hand with robot and table, which the way back must be free of.
    """
    X_WH, home = kinematics.pose(q), kinematics.pose(kinematics.home)
    for rise_m in _RISES_M:
        raised = X_WH.copy()
        raised[:3, 3] += rise_m * np.asarray(table.normal)
        if _free_from(raised, home, kinematics, q, table, collisions):
            break
    open_hand = hand.motor_fractions(0.0, 0.0)
    opened = Leg("open the hand", X_WH, open_hand, 0.8)
    return (opened, *path(X_WH, [raised, home], ["raise the hand", "back"], open_hand))


def _free_from(
    raised: Array,
    home: Array,
    kinematics: ArmKinematics,
    q: Array,
    table: Plane,
    collisions: ArmCollisions | None,
) -> bool:
    """Whether the arm comes up and back; what it touches before it is up does not count."""
    up = rollout(kinematics, q, [raised])
    if not up.reached:
        return False
    back = rollout(kinematics, up.q[-1], [home])
    height = table.z_below(raised[:3, 3])
    return back.reached and not (collisions and collisions.first(back.q, height))


def approach_poses(
    X_WH: Array,
    motion: str,
    scene: Obstacles,
    hand: HandModel,
    X_WH_now: Array,
    settings: GraspMotionSettings,
) -> list[Array]:
    """Hand poses (4, 4) on the way: raised, over the object, (beside it,) in place."""
    up = scene.table.normal
    palm = X_WH[:3, :3] @ np.asarray(hand.description.palm)
    beside = X_WH.copy()
    if motion == "side":
        beside[:3, 3] -= settings.standoff_m * palm
    lowest = link_clearance(hand, beside, scene)[1]
    frame = float(scene.table.height(beside[:3, 3]))
    rise = max(scene.top_m + settings.safe_height_m - lowest, settings.least_transit_m - frame, 0.0)
    height = max(frame + rise, float(scene.table.height(X_WH_now[:3, 3])))
    over, raised = beside.copy(), X_WH_now.copy()
    over[:3, 3] += (height - frame) * up
    raised[:3, 3] += (height - scene.table.height(X_WH_now[:3, 3])) * up
    return [raised, over, beside, X_WH] if motion == "side" else [raised, over, X_WH]


def _legs(
    approach: dict[str, Array],
    motion: str,
    hand: HandModel,
    X_WH_now: Array,
    s: GraspMotionSettings,
) -> tuple[Leg, ...]:
    """Through the air, guarded to the object, then close, squeeze, lift and hold."""
    open_hand = hand.motor_fractions(0.0, 0.0)
    *free, last = approach.values()
    legs = path(X_WH_now, free, [*approach][:-1], open_hand)
    slow = travel_time(free[-1], last, linear_m_s=2 * SLOW_M_S)
    legs += (
        Leg("settle", free[-1], open_hand, 0.3),
        Leg("approach", last, open_hand, slow, guarded=True, guard_n=s.guard_n),
    )
    return (*legs, *closing_legs(last, motion, hand, s))


def closing_legs(
    X_WH: Array, motion: str, hand: HandModel, settings: GraspMotionSettings
) -> tuple[Leg, ...]:
    """Close, squeeze, lift and hold, from an open hand in its place X_WH (4, 4)."""
    s, closed = settings, hand.motor_fractions(1.0, 1.0)
    fingers, rise_m = _finger_legs(X_WH, motion, hand, s), s.rise_m(motion)
    lift_s = s.lift_s * rise_m / s.lift_m
    up = (
        Leg("lift", X_WH, closed, lift_s, rise_m=rise_m),
        Leg("hold", X_WH, closed, s.hold_s, rise_m=0.0),
    )
    if s.closing == "open_loop" or s.weigh_m == 0:
        return (*fingers, *up)
    share = s.weigh_m / rise_m
    first = Leg("lift", X_WH, closed, max(share * lift_s, 0.4), rise_m=s.weigh_m)
    rest = dc.replace(up[0], rise_m=rise_m - s.weigh_m, duration_s=(1 - share) * lift_s)
    again = (*_opening_legs(X_WH, motion, hand, s), *fingers, *up)
    weighed = dc.replace(first, least_load_n=s.least_load_n, otherwise=again)
    return (*fingers, weighed, rest, up[1])


def _finger_legs(
    X_WH: Array, motion: str, hand: HandModel, s: GraspMotionSettings
) -> tuple[Leg, ...]:
    """The fingers close on the object."""
    tape, closed = s.closing == "open_loop", hand.motor_fractions(1.0, 1.0)
    named = [("close", closed, s.close_s), ("squeeze", closed, s.squeeze_s)]
    pressing = hand.description.pressing if motion == "collect" else None
    if pressing is not None:
        named = [
            ("gather", hand.motor_fractions(*pressing.gathered), s.gather_s),
            ("press", hand.motor_fractions(*pressing.pressed), s.press_s),
            ("close", hand.motor_fractions(1.0, pressing.held_thumb), s.close_s),
            ("squeeze", closed, s.squeeze_s),
        ]
    elif motion == "collect":
        half = hand.motor_fractions(s.gather_fingers, s.gather_thumb)
        named.insert(0, ("gather", half, s.gather_s))
    leg = Leg(X_WH=X_WH, closing=motion, tape=tape, yields=s.yields and not tape)
    return tuple(
        dc.replace(
            leg,
            name=name,
            motors=motors,
            duration_s=duration,
            stands=pressing is not None and name in ("close", "squeeze"),
        )
        for name, motors, duration in named
    )


def _opening_legs(
    X_WH: Array, motion: str, hand: HandModel, s: GraspMotionSettings
) -> tuple[Leg, ...]:
    """Down again, open, and a little towards the object."""
    opened, closed = hand.motor_fractions(0.0, 0.0), hand.motor_fractions(1.0, 1.0)
    return (
        Leg("lower again", X_WH, closed, 0.4, rise_m=-s.weigh_m),
        Leg("open again", X_WH, opened, 0.8, closing=motion),
        Leg("seek", X_WH, opened, 0.4, seek_m=s.seek_m),
    )
