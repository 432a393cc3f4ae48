"""Runs motion programs: hand pose targets and motor commands over time."""

import dataclasses as dc
import math

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import BasicVector, Context, EventStatus, State

from vh_drake.control.cartesian_position import pose_error
from vh_drake.grasping.closing_pose import closing_offset
from vh_drake.hand.model import HandModel
from vh_drake.hand.program import Leg, MotionProgram, Progress, interpolate, smooth
from vh_drake.systems.collectable import CollectableSystem
from vh_drake.types import Array, Immutable, TouchPlan

PERIOD_S = 0.01
STALL = 0.03  # share of its travel by which a stalled motor lags behind its command
# A closing hand yields to forces on it, level and up, at a speed for each newton over thresholds
# that its own motion does not reach; fingers that are pressed on a table push it up with 10 N,
# and with 25 N as they pull.
YIELD_M_S_N, YIELD_OVER_N, YIELD_MOST_M_S, YIELD_MOST_M = 0.01, 1.0, 0.02, 0.02
PRESS_OVER_N = 30.0
SETTLE_M, SETTLE_RAD, PATIENCE_S = 0.001, 0.01, 2.0


@dc.dataclass(frozen=True, eq=False)
class _Run(Immutable):
    """Where the executor stands; replaced, never mutated."""

    program: MotionProgram = dc.field(default_factory=MotionProgram)
    leg: int = 0
    since_s: float = 0.0
    X_WH0: Array = dc.field(default_factory=lambda: np.eye(4))  # at the leg's start
    motors0: Array = dc.field(default_factory=lambda: np.zeros(0))
    X_WH0Open: Array = dc.field(default_factory=lambda: np.eye(4))  # of the hand if it were open
    held: Array | None = None  # hand pose since the motors stalled in a closing leg
    shift: Array = dc.field(default_factory=lambda: np.zeros(3))  # by which it has yielded [m]
    resisted: Array = dc.field(default_factory=lambda: np.zeros(3))  # sum of forces since opened
    tare: int = 0
    done: int = 0
    felt: bool = False

    @property
    def current(self) -> Leg | None:
        """The running leg."""
        running = self.program.id > self.done and self.leg < len(self.program.legs)
        return self.program.legs[self.leg] if running else None

    @property
    def stands(self) -> bool:
        """Whether the hand's target does not move within a period."""
        leg = self.current
        return leg is None or bool(leg.closing and self.held is not None)


def _raised(X_WH: Array, rise_m: float) -> Array:
    X = X_WH.copy()
    X[2, 3] += rise_m
    return X


def _towards(X_WH: Array, resisted: Array, way_m: float) -> Array:
    """Moved against the forces that a closing hand felt, which come from the object."""
    X = X_WH.copy()
    size = _size(resisted)
    if size > 0:
        X[:3, 3] -= way_m * resisted / size
    return X


def _size(vector: Array) -> float:
    return math.sqrt(vector @ vector)


def _shifted(X_WH: Array, shift: Array) -> Array:
    X = X_WH.copy()
    X[:3, 3] += shift
    return X


def _given_way(force: Array, over_n: float) -> Array:
    """Velocity (3,) with which a hand yields to a force (3,) over a threshold [m/s]."""
    size = _size(force)
    if size <= over_n:
        return np.zeros(3)
    way: Array = min(YIELD_M_S_N * (size - over_n), YIELD_MOST_M_S) / size * force
    return way


def _with_leg(run: _Run, leg: Leg) -> _Run:
    """The run with its current leg replaced."""
    legs = (*run.program.legs[: run.leg], leg, *run.program.legs[run.leg + 1 :])
    return dc.replace(run, program=dc.replace(run.program, legs=legs))


class GraspExecutor(CollectableSystem):
    """Moves hand and fingers through the legs of a program, and heeds contacts.

    .. pydrake_system::

        name: GraspExecutor
        input_ports:
        - program
        - hand_pose
        - motor_fraction
        - contact
        - force
        - missed
        output_ports:
        - target_pose
        - target_velocity
        - motor_command
        - tare
        - approach_direction
        - follow
        - touch_plan
        - progress

    | port               | direction | type           | unit | meaning                             |
    |--------------------|-----------|----------------|------|-------------------------------------|
    | program            | in        | MotionProgram  | m    | a new id starts it                  |
    | hand_pose          | in        | RigidTransform | m    | X_WH as commanded to the arm        |
    | motor_fraction     | in        | vector (k)     | -    | measured travel, 0 open to 1 closed |
    | contact            | in        | vector (1)     | -    | 1: touched since the last tare      |
    | force              | in        | vector (3)     | N    | on the hand since the last tare     |
    | missed             | in        | vector (1)     | -    | 1: the curve ended, nothing touched |
    | target_pose        | out       | RigidTransform | m    | X_WH where the hand shall be now    |
    | target_velocity    | out       | vector (6)     | *    | of it in W, rad/s, then m/s         |
    | motor_command      | out       | vector (k)     | -    | where the motors shall be now       |
    | tare               | out       | vector (1)     | -    | id; a change asks for F_0           |
    | approach_direction | out       | vector (3)     | -    | of a guarded leg, in W; else 0      |
    | follow             | out       | vector (1)     | -    | 1: the trajectory follower drives   |
    | touch_plan         | out       | TouchPlan      | m    | the curve for it                    |
    | progress           | out       | Progress       | -    | last program ended, leg, felt       |

    In a closing leg the hand follows the fingers' measured travel until a motor stalls, or
    something pushes the hand up hard: from then on the fingers are not where their motors say,
    and the hand stands still, or it would press the object into the table. In a leg that stands
    it does so from the beginning. It yields, level, to forces that push it: an object that one
    finger meets before its opponents brings the hand over itself; and up, where the table or a
    tall object pushes hard. A tape does not.

    A leg ends when its time is over and the hand has arrived (or is late by 2 s), a guarded
    leg also at a contact. Where a leg ends with less weight on the wrist than it wants, its other
    legs follow instead of the rest. A program whose touch curve was missed ends.

    Args:
        hand: the hand that moves.
        X_WH: hand pose (4, 4) at the start.
    """

    def __init__(self, hand: HandModel, X_WH: Array) -> None:
        super().__init__()
        self._hand = hand
        k = len(hand.description.motors)
        self._program = self.DeclareAbstractInputPort("program", Value[object](MotionProgram()))
        self._pose = self.DeclareAbstractInputPort("hand_pose", Value(RigidTransform()))
        self._fraction = self.DeclareVectorInputPort("motor_fraction", k)
        self._contact = self.DeclareVectorInputPort("contact", 1)
        self._force = self.DeclareVectorInputPort("force", 3)
        self._missed = self.DeclareVectorInputPort("missed", 1)
        start = _Run(X_WH0=np.array(X_WH), motors0=np.zeros(k))
        state = self.DeclareAbstractState(Value[object](start))
        self.DeclarePeriodicUnrestrictedUpdateEvent(PERIOD_S, 0.0, self._update)
        run = {self.abstract_state_ticket(state)}
        timed = run | {self.time_ticket()}
        self._target_index = self.DeclareAbstractOutputPort(
            "target_pose",
            lambda: Value(RigidTransform()),
            self._calc_target,
            prerequisites_of_calc=timed | {self._fraction.ticket()},
        ).get_index()
        self.DeclareVectorOutputPort(
            "target_velocity",
            6,
            self._calc_velocity,
            prerequisites_of_calc=timed | {self._fraction.ticket()},
        )
        self.DeclareVectorOutputPort(
            "motor_command", k, self._calc_motors, prerequisites_of_calc=timed
        )
        self.DeclareVectorOutputPort("tare", 1, self._calc_tare, prerequisites_of_calc=run)
        self.DeclareVectorOutputPort(
            "approach_direction", 3, self._calc_direction, prerequisites_of_calc=run
        )
        self.DeclareVectorOutputPort("follow", 1, self._calc_follow, prerequisites_of_calc=run)
        self.DeclareAbstractOutputPort(
            "touch_plan",
            lambda: Value[object](TouchPlan()),
            self._calc_touch,
            prerequisites_of_calc=run,
        )
        self.DeclareAbstractOutputPort(
            "progress",
            lambda: Value[object](Progress()),
            self._calc_progress,
            prerequisites_of_calc=run,
        )

    def _run(self, context: Context) -> _Run:
        run: _Run = context.get_abstract_state(0).get_value()
        return run

    def _update(self, context: Context, state: State) -> EventStatus:
        before = run = self._run(context)
        program: MotionProgram = self._program.Eval(context)
        if program.id > run.program.id:
            motors = self._motors(context, run)
            run = dc.replace(run, program=program, leg=0, motors0=motors)
            run = self._begin(context, run, self._pose.Eval(context).GetAsMatrix4())
        elif (ended := self._ended(context, run)) is not None:
            run = self._next(context, run, felt=ended)
        elif run.current is not None and run.current.closing and not run.current.tape:
            if self._stalls(context, run):
                run = dc.replace(run, held=self._closing_pose(context, run))
            run = self._yielding(context, run)
        if run is before:
            return EventStatus.DidNothing()
        state.get_mutable_abstract_state(0).set_value(run)
        return EventStatus.Succeeded()

    def _yielding(self, context: Context, run: _Run) -> _Run:
        """The run after a period in which the hand gave way to the force on it."""
        x, y, z = self._force.Eval(context)
        level, up = np.array([x, y, 0.0]), np.array([0.0, 0.0, max(z, 0.0)])
        if _size(level) > YIELD_OVER_N:
            run = dc.replace(run, resisted=run.resisted + level)
        if run.current is None or not run.current.yields:
            return run
        velocity = _given_way(level, YIELD_OVER_N) + _given_way(up, PRESS_OVER_N)
        shift = run.shift + velocity * PERIOD_S
        if not velocity.any() or _size(shift) > YIELD_MOST_M:
            return run
        return dc.replace(run, shift=shift)

    def _begin(self, context: Context, run: _Run, X_WH0: Array) -> _Run:
        """The running leg starts now, in a pose (4, 4)."""
        leg = run.current
        if leg is None:
            return dc.replace(run, done=run.program.id, X_WH0=X_WH0)
        fraction = run.motors0 if leg.tape else self._fraction.Eval(context)
        offset = closing_offset(self._hand, leg.closing, fraction) if leg.closing else np.eye(4)
        if leg.rise_m is not None:
            run = _with_leg(run, dc.replace(leg, X_WH=_raised(X_WH0, leg.rise_m)))
        elif leg.seek_m:
            run = _with_leg(run, dc.replace(leg, X_WH=_towards(X_WH0, run.resisted, leg.seek_m)))
        held = None
        if leg.closing and run.held is not None:
            held = _shifted(run.held, run.shift)
        elif leg.stands:
            held = X_WH0
        return dc.replace(
            run,
            since_s=context.get_time(),
            X_WH0=X_WH0,
            X_WH0Open=X_WH0 @ np.linalg.inv(offset),
            held=held,
            shift=np.zeros(3),
            tare=run.tare + leg.guarded,
        )

    def _next(self, context: Context, run: _Run, *, felt: bool) -> _Run:
        """Go on to the next leg, or end the program."""
        leg = run.current
        assert leg is not None
        X_WH = self._pose.Eval(context).GetAsMatrix4()
        # A hand that closes lags behind its target; what it has not caught up with is not lost.
        start = self._target(context, run) if leg.closing else X_WH
        motors = self._motors(context, run)
        run = dc.replace(run, motors0=motors, felt=felt if leg.guarded else run.felt)
        if leg.otherwise and -self._force.Eval(context)[2] < leg.least_load_n:
            program = dc.replace(run.program, legs=leg.otherwise)
            return self._begin(context, dc.replace(run, program=program, leg=0), start)
        if leg.touch is not None or run.leg + 1 == len(run.program.legs):
            keep = leg.X_WH if not felt and leg.touch is None and not leg.closing else X_WH
            return dc.replace(run, done=run.program.id, X_WH0=keep)
        return self._begin(context, dc.replace(run, leg=run.leg + 1), start)

    def _ended(self, context: Context, run: _Run) -> bool | None:
        """None while the leg runs; else whether a contact ended it."""
        leg = run.current
        if leg is None:
            return None
        elapsed = context.get_time() - run.since_s
        if leg.guarded and elapsed > 2 * PERIOD_S and self._touches(context, leg):
            return True
        if leg.touch is not None:
            return False if self._missed.Eval(context)[0] > 0 else None
        if elapsed < leg.duration_s:
            return None
        arrived = leg.closing or self._arrived(context, leg)
        return False if arrived or elapsed > leg.duration_s + PATIENCE_S else None

    def _touches(self, context: Context, leg: Leg) -> bool:
        if leg.guard_n > 0:
            return bool(np.linalg.norm(self._force.Eval(context)) > leg.guard_n)
        return bool(self._contact.Eval(context)[0] > 0)

    def _arrived(self, context: Context, leg: Leg) -> bool:
        X_WH = self._pose.Eval(context).GetAsMatrix4()
        turn = np.clip((np.trace(X_WH[:3, :3].T @ leg.X_WH[:3, :3]) - 1) / 2, -1, 1)
        distance = np.linalg.norm(X_WH[:3, 3] - leg.X_WH[:3, 3])
        return bool(distance < SETTLE_M and np.arccos(turn) < SETTLE_RAD)

    def _share(self, context: Context, run: _Run, leg: Leg, ahead_s: float = 0.0) -> float:
        """Of the leg's time that has passed, or will have in a while; from 0 to 1."""
        elapsed = context.get_time() + ahead_s - run.since_s
        return min(max(elapsed / max(leg.duration_s, 1e-9), 0.0), 1.0)

    def _motors(self, context: Context, run: _Run, ahead_s: float = 0.0) -> Array:
        """Motor command (k,) now, or in a while."""
        leg = run.current
        if leg is None:
            return run.motors0
        share = self._share(context, run, leg, ahead_s)
        return (1.0 - share) * run.motors0 + share * leg.motors

    def _stalls(self, context: Context, run: _Run) -> bool:
        """Whether an object stops a closing hand, or a motor of it, for the first time."""
        leg = run.current
        if leg is None or run.held is not None or leg.motors.max() < 1e-9:
            return False  # An opening hand leaves what stops it.
        lag = self._motors(context, run) - self._fraction.Eval(context)
        return bool(lag.max() > STALL or self._force.Eval(context)[2] > PRESS_OVER_N)

    def _closing_pose(self, context: Context, run: _Run, ahead_s: float = 0.0) -> Array:
        """The hand pose (4, 4) that goes with the fingers' measured travel."""
        leg = run.current
        assert leg is not None
        travel = self._motors(context, run, ahead_s)
        if not leg.tape:
            travel = travel - self._motors(context, run) + self._fraction.Eval(context)
        now = closing_offset(self._hand, leg.closing, travel)
        X_WH: Array = run.X_WH0Open @ now
        return X_WH

    def _target(self, context: Context, run: _Run, ahead_s: float = 0.0) -> Array:
        """Where the hand (4, 4) shall be now, or in a while."""
        leg = run.current
        if leg is None:
            return run.X_WH0
        if leg.closing:
            still = run.held
            if still is None:
                still = self._closing_pose(context, run, ahead_s)
            return _shifted(still, run.shift)
        share = self._share(context, run, leg, ahead_s)
        share = share if leg.guarded else smooth(share)
        X_WH: Array = interpolate(run.X_WH0, leg.X_WH, share)
        return X_WH

    def _calc_target(self, context: Context, output: Value) -> None:
        output.set_value(RigidTransform(self._target(context, self._run(context))))

    def _calc_velocity(self, context: Context, output: BasicVector) -> None:
        run = self._run(context)
        if run.stands:
            output.SetZero()
            return
        now = self.get_output_port(self._target_index).Eval(context).GetAsMatrix4()
        soon = self._target(context, run, PERIOD_S)
        output.SetFromVector(pose_error(soon, now) / PERIOD_S)

    def _calc_motors(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._motors(context, self._run(context)))

    def _calc_tare(self, context: Context, output: BasicVector) -> None:
        output.SetAtIndex(0, float(self._run(context).tare))

    def _calc_direction(self, context: Context, output: BasicVector) -> None:
        run = self._run(context)
        leg = run.current
        direction = np.zeros(3)
        if leg is not None and leg.guarded:
            way = leg.X_WH[:3, 3] - run.X_WH0[:3, 3]
            if leg.touch is not None:
                way = leg.touch.control_points[3] - leg.touch.control_points[2]
            direction = way / max(float(np.linalg.norm(way)), 1e-9)
        output.SetFromVector(direction)

    def _calc_follow(self, context: Context, output: BasicVector) -> None:
        leg = self._run(context).current
        output.SetAtIndex(0, float(leg is not None and leg.touch is not None))

    def _calc_touch(self, context: Context, output: Value) -> None:
        leg = self._run(context).current
        output.set_value(leg.touch if leg is not None and leg.touch is not None else TouchPlan())

    def _calc_progress(self, context: Context, output: Value) -> None:
        run = self._run(context)
        leg = run.current
        output.set_value(Progress(run.done, leg.name if leg is not None else "", run.felt))
