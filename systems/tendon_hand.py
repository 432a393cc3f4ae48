"""The hand's drive: motor commands in, motor set points and estimated finger joints out."""

from typing import Literal

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues

from vh_drake.errors import UnknownName
from vh_drake.hand.model import HandModel
from vh_drake.systems.collectable import CollectableSystem
from vh_drake.types import Array

Command = Literal["position", "force"]
COMMANDS = ("position", "force")
PERIOD_S = 0.005
STROKE_S = 0.6  # shortest time from open to closed
# Force control moves the set point by this for each newton and period. Fingers that are held
# give 3e4 N/m, so that a third of an error is left after a period.
_STEP_M_N = 2e-5
_LEAD_M = 0.002  # Of the set point before the motor, so that it never winds up.


class TendonHand(CollectableSystem):
    """Drives an underactuated hand, and tells its joints from its motors.

    .. pydrake_system::

        name: TendonHand
        input_ports:
        - motor_command
        - motor_state
        - motor_force
        output_ports:
        - motor_set_point
        - motor_fraction
        - tendon_force
        - finger_joints

    | port            | direction | type        | unit   | meaning                                 |
    |-----------------|-----------|-------------|--------|-----------------------------------------|
    | motor_command   | in        | vector (k)  | - or N | wanted travel, 0 to 1, or wanted pull   |
    | motor_state     | in        | vector (2k) | m, m/s | measured travel of the motors           |
    | motor_force     | in        | vector (k)  | N      | measured pull of the motors             |
    | motor_set_point | out       | vector (2k) | m, m/s | for the motors' servos                  |
    | motor_fraction  | out       | vector (k)  | -      | measured travel, 0 open to 1 closed     |
    | tendon_force    | out       | vector (f)  | N      | in each finger's tendon; 0 where slack  |
    | finger_joints   | out       | vector (n)  | rad    | free-space joints at the measured travel|

    The set points approach the command at a bounded rate, as the motors' gears do. Wanted pulls
    are reached by moving the set points until the measured pulls agree; below what the springs
    need, the hand opens. A finger that an object blocks leaves the free-space joints: the
    estimate is what the motors know.

    Args:
        hand: the hand, its motors in the order of its description.
        command: what `motor_command` holds: travel ("position") or pull ("force").

    Raises:
        UnknownName: no such kind of command.
    """

    def __init__(self, hand: HandModel, command: Command = "position") -> None:
        super().__init__()
        if command not in COMMANDS:
            raise UnknownName("motor command", command, list(COMMANDS))
        self._hand = hand
        self._by_force = command == "force"
        motors = hand.description.motors
        k = len(motors)
        self._stroke = np.array([motor.closed_m for motor in motors])
        self._most = self._stroke * PERIOD_S / STROKE_S  # in a period
        self._strongest = np.array([motor.force_n for motor in motors])
        fingers = np.bincount(hand.motor_of_finger, minlength=k)
        self._share = 1.0 / fingers[hand.motor_of_finger]
        self._command = self.DeclareVectorInputPort("motor_command", k)
        self._measured = self.DeclareVectorInputPort("motor_state", 2 * k)
        self._force = self.DeclareVectorInputPort("motor_force", k)
        state = self.DeclareDiscreteState(2 * k)
        self.DeclareStateOutputPort("motor_set_point", state)
        self.DeclarePeriodicDiscreteUpdateEvent(PERIOD_S, 0.0, self._step)
        measured = {self._measured.ticket()}
        self.DeclareVectorOutputPort(
            "motor_fraction", k, self._calc_fraction, prerequisites_of_calc=measured
        )
        self.DeclareVectorOutputPort(
            "tendon_force",
            hand.num_fingers,
            self._calc_force,
            prerequisites_of_calc={self._force.ticket()},
        )
        self.DeclareVectorOutputPort(
            "finger_joints",
            len(hand.joints),
            self._calc_joints,
            prerequisites_of_calc=measured,
        )

    def _fraction(self, context: Context) -> Array:
        travel = self._measured.Eval(context)[: len(self._stroke)]
        fraction: Array = np.minimum(np.maximum(travel / self._stroke, 0.0), 1.0)
        return fraction

    def _step(self, context: Context, values: DiscreteValues) -> None:
        now = context.get_discrete_state_vector().value()[: len(self._stroke)]
        if self._by_force:
            wanted = self._travel_for_force(context, now)
        else:
            fraction = np.minimum(np.maximum(self._command.Eval(context), 0.0), 1.0)
            wanted = fraction * self._stroke
        most = self._most
        step = np.minimum(np.maximum(wanted - now, -most), most)
        values.set_value(np.concatenate([now + step, step / PERIOD_S]))

    def _travel_for_force(self, context: Context, now: Array) -> Array:
        """Set points (k,) [m] that bring the measured pulls nearer to the wanted ones."""
        pull = np.clip(self._command.Eval(context), 0.0, self._strongest)
        travel = self._measured.Eval(context)[: len(now)]
        moved = now + _STEP_M_N * (pull - self._force.Eval(context))
        wanted: Array = np.maximum(np.clip(moved, travel - _LEAD_M, travel + _LEAD_M), 0.0)
        return wanted

    def _calc_fraction(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._fraction(context))

    def _calc_force(self, context: Context, output: BasicVector) -> None:
        pull = np.maximum(self._force.Eval(context), 0.0)
        output.SetFromVector(pull[self._hand.motor_of_finger] * self._share)

    def _calc_joints(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._hand.joint_angles(self._fraction(context)))
