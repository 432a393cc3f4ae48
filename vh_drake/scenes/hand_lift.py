"""Lifts of one object by the hand alone: the physics of a grasp without the arm's."""

import dataclasses as dc

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, Diagram, DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from vh_drake.geometry.signed_distance import interpolate, signed_distance_grid
from vh_drake.grasping.approach import GraspMotionSettings, closing_legs
from vh_drake.hand.model import HandModel
from vh_drake.hand.program import SLOW_M_S, Leg, MotionProgram, Progress, travel_time
from vh_drake.objects.model import ObjectModel
from vh_drake.scenes.moving_hand import MovingHand, make_moving_hand
from vh_drake.scenes.scenario import POINT_STEP_S, Table
from vh_drake.systems.base_drive import BaseDrive
from vh_drake.systems.grasp_executor import GraspExecutor
from vh_drake.types import Array

GAP_M = 0.0005  # of the object over the table at the start
_TICK_S = 0.04
_BACK_M, _BACK_STEP_M, _FARTHEST_M = 0.04, 0.02, 0.2  # where the approach starts
_CLEAR_M = 0.002  # of the open hand there
_FALLEN_M = 0.05  # below the table
_HELD_SHARE = 0.5  # of the lift's height: long objects hang


def lift_motion() -> GraspMotionSettings:
    """A grasp as in a whole trial, with a shorter lift and hold."""
    return GraspMotionSettings(lift_m=0.1, hang_m=0.0, lift_s=0.8, hold_s=0.7)


@dc.dataclass(frozen=True)
class Lift:
    """What came of a grasp."""

    lifted: bool  # held up until the end
    height_m: float  # of the object's lowest point over the table at the end
    simulated_s: float
    leg: str  # in which it was lost, or "hold"


class HandLifter:
    """A hand on a carriage, an object, a table; grasps are tried one after the other.

    The diagram is built once. Every lift starts in the same default state, so that its outcome
    does not depend on those before it.

    Args:
        hand: that grasps.
        model: of the object.
        table: that the object stands on.
        motion: times and distances.
        step_s: of the simulation, in point contact.
    """

    def __init__(
        self,
        hand: HandModel,
        model: ObjectModel,
        table: Table,
        motion: GraspMotionSettings | None = None,
        *,
        step_s: float = POINT_STEP_S,
    ) -> None:
        self._hand, self._table = hand, table
        self._motion = motion or lift_motion()
        self._lowest_m = _HELD_SHARE * self._motion.lift_m
        self._moving = make_moving_hand(
            hand, contact="point", model=model, table=table, step_s=step_s
        )
        self._diagram, self._drive = _control(hand, self._moving)
        self._simulator = Simulator(self._diagram)
        self._initial = self._diagram.CreateDefaultContext()
        self._corners = model.mesh.convex_hull.vertices
        self._distance = signed_distance_grid(model.mesh, spacing=0.005, padding=0.02)

    def lift(self, X_WO: Array, X_WH: Array, motion: str) -> Lift:
        """Come to a grasp, close and lift.

        Args:
            X_WO: pose of the object on the table (4, 4).
            X_WH: hand pose (4, 4) in which the closing starts.
            motion: name of the closing motion.
        """
        start = self._start(X_WO, X_WH, motion)
        context = self._begin(X_WO, start, self._legs(start, X_WH, motion))
        port = self._diagram.GetOutputPort("progress")
        while True:
            self._simulator.AdvanceTo(context.get_time() + _TICK_S)
            progress: Progress = port.Eval(context)
            height = self._height(context)
            if progress.done or self._is_lost(context, progress.leg, height):
                break
        held = progress.done > 0 and height > self._lowest_m
        return Lift(held, height, context.get_time(), progress.leg or "hold")

    def _start(self, X_WO: Array, X_WH: Array, motion: str) -> Array:
        """Back along the approach until the open hand is off the true object."""
        back = np.array([0.0, 0.0, 1.0])
        if motion == "side":
            back = -X_WH[:3, :3] @ np.asarray(self._hand.description.palm)
        centers, radii = self._hand.spheres(self._hand.lower)
        start = X_WH.copy()
        for way in np.arange(_BACK_M, _FARTHEST_M, _BACK_STEP_M):
            start[:3, 3] = X_WH[:3, 3] + way * back
            p_WS = centers @ start[:3, :3].T + start[:3, 3]
            p_OS = (p_WS - X_WO[:3, 3]) @ X_WO[:3, :3]
            if (interpolate(self._distance, p_OS)[0] - radii).min() > _CLEAR_M:
                break
        return start

    def _legs(self, start: Array, X_WH: Array, motion: str) -> tuple[Leg, ...]:
        """The last piece of the way, guarded, and the grasp."""
        slow = travel_time(start, X_WH, linear_m_s=2 * SLOW_M_S)
        opened, guard_n = self._hand.motor_fractions(0.0, 0.0), self._motion.guard_n
        approach = Leg("approach", X_WH, opened, slow, guarded=True, guard_n=guard_n)
        return (approach, *closing_legs(X_WH, motion, self._hand, self._motion))

    def _begin(self, X_WO: Array, start: Array, legs: tuple[Leg, ...]) -> Context:
        context: Context = self._simulator.get_mutable_context()
        context.SetTimeStateAndParametersFrom(self._initial)
        moving = self._moving
        program = Value[object](MotionProgram(1, legs))
        self._diagram.GetInputPort("program").FixValue(context, program)
        position = self._drive.place(self._drive.GetMyMutableContextFromRoot(context), start)
        own = moving.plant.GetMyMutableContextFromRoot(context)
        moving.plant.SetPositions(own, moving.base, position)
        X_WO = X_WO.copy()
        X_WO[2, 3] += GAP_M
        moving.plant.SetFreeBodyPose(own, moving.object, RigidTransform(X_WO))
        self._simulator.Initialize()
        return context

    def _height(self, context: Context) -> float:
        """Of the object's lowest point over the table [m]."""
        own = self._moving.plant.GetMyContextFromRoot(context)
        X_WO = self._moving.plant.EvalBodyPoseInWorld(own, self._moving.object)
        lowest = (self._corners @ X_WO.rotation().matrix()[2]).min()
        return float(lowest + X_WO.translation()[2] - self._table.height_m)

    def _is_lost(self, context: Context, leg: str, height: float) -> bool:
        """Whether nothing can come of it: the object fell, or the hand closed without it."""
        if leg in ("squeeze", "lift"):
            rig = self._moving.diagram
            touch = rig.GetOutputPort("touch").Eval(rig.GetMyContextFromRoot(context))
            return not touch.any()
        return height < -_FALLEN_M or (leg == "hold" and height < self._lowest_m)


def _control(hand: HandModel, moving: MovingHand) -> tuple[Diagram, BaseDrive]:
    """The executor of whole trials moves the carriage and the fingers."""
    builder = DiagramBuilder()
    rig = builder.AddNamedSystem("rig", moving.diagram)
    drive = builder.AddNamedSystem("drive", BaseDrive(hand))
    executor = builder.AddNamedSystem("executor", GraspExecutor(hand, np.eye(4)))
    nothing = builder.AddNamedSystem("nothing", ConstantVectorSource([0.0]))
    builder.ExportInput(executor.GetInputPort("program"), "program")
    for name in ("contact", "missed"):
        builder.Connect(nothing.get_output_port(), executor.GetInputPort(name))
    for source, output, sink, port in (
        (drive, "hand_pose", executor, "hand_pose"),
        (rig, "touch", executor, "force"),
        (rig, "motor_fraction", executor, "motor_fraction"),
        (executor, "motor_command", rig, "motor_command"),
        (executor, "target_pose", drive, "target_pose"),
        (drive, "base_state", rig, "base_state"),
    ):
        builder.Connect(source.GetOutputPort(output), sink.GetInputPort(port))
    builder.ExportOutput(executor.GetOutputPort("progress"), "progress")
    return builder.Build(), drive
