"""The tactile normal sensor as a LeafSystem."""

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.systems.framework import BasicVector, Context, State

from vh_drake.sensing.tactile import N_SPAD, PERIOD_S, TactileSensor, TactileSettings, TactileState
from vh_drake.systems.collectable import CollectableSystem


class TactileNormalSensor(CollectableSystem):
    """Feels contact by pressure, and how the surface stands by orientation.

    .. pydrake_system::

        name: TactileNormalSensor
        input_ports:
        - sensor_pose
        - contact_force
        output_ports:
        - pressure
        - filtered_pressure
        - orientation
        - contact
        - aligned
        - normal

    | port              | direction | type           | unit | meaning                              |
    |-------------------|-----------|----------------|------|--------------------------------------|
    | sensor_pose       | in        | RigidTransform | m    | X_WS; the pad faces -z of S          |
    | contact_force     | in        | vector (3)     | N    | on the pad, in W                     |
    | pressure          | out       | vector (1)     | Pa   | read, over that at the start         |
    | filtered_pressure | out       | vector (1)     | Pa   | filtered, drift compensated          |
    | orientation       | out       | RotationMatrix | -    | measured R_WS                        |
    | contact           | out       | vector (1)     | -    | 1: touched                           |
    | aligned           | out       | vector (1)     | -    | 1: touched, and pressed flat         |
    | normal            | out       | vector (3)     | -    | outward, of the surface last felt    |

    `normal` is zero until the first surface was felt, and is read once a contact. The sensor's
    body and its self-aligning mount are in `models/tactile_sensor`; S is the frame of its link
    `tactile_sensor`. On a rigid fingertip the same system measures the fingertip's orientation.

    Args:
        settings: of the sensor.
        seed: of noise and drift.
    """

    def __init__(self, settings: TactileSettings | None = None, seed: int = 0) -> None:
        super().__init__()
        self._sensor = TactileSensor(settings)
        self._seed = seed
        self._pose = self.DeclareAbstractInputPort("sensor_pose", Value(RigidTransform()))
        self._force = self.DeclareVectorInputPort("contact_force", 3)
        start = self._sensor.start(np.eye(3), np.random.default_rng([seed, 0]))
        state = self.DeclareAbstractState(Value[object](start))
        self.DeclarePeriodicUnrestrictedUpdateEvent(PERIOD_S, 0.0, self._update)
        after = {self.abstract_state_ticket(state)}
        for name, read in (
            ("pressure", lambda s: s.element.reading_pa),
            ("filtered_pressure", lambda s: s.detection.filtered_pa),
            ("contact", lambda s: s.detection.contact),
            ("aligned", lambda s: s.aligned),
        ):
            self.DeclareVectorOutputPort(
                name,
                1,
                lambda context, output, read=read: output.SetAtIndex(
                    0, float(read(self._state(context)))
                ),
                prerequisites_of_calc=after,
            )
        self.DeclareAbstractOutputPort(
            "orientation",
            lambda: Value(RotationMatrix()),
            self._calc_orientation,
            prerequisites_of_calc=after,
        )
        self.DeclareVectorOutputPort("normal", 3, self._calc_normal, prerequisites_of_calc=after)

    def _state(self, context: Context) -> TactileState:
        state: TactileState = context.get_abstract_state(0).get_value()
        return state

    def _update(self, context: Context, state: State) -> None:
        tick = round(context.get_time() / PERIOD_S) + 1
        rng = np.random.default_rng([self._seed, tick])
        R_WS = self._pose.Eval(context).rotation().matrix()
        pressing = -float(self._force.Eval(context) @ (R_WS @ N_SPAD))
        state.get_mutable_abstract_state(0).set_value(
            self._sensor.step(self._state(context), pressing, R_WS, rng)
        )

    def _calc_orientation(self, context: Context, output: Value) -> None:
        output.set_value(RotationMatrix(self._state(context).R_WS))

    def _calc_normal(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._state(context).normal_W)
