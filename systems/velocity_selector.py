"""Hands the arm to one of two drivers."""

from pydrake.systems.framework import BasicVector, Context

from vh_drake.systems.collectable import CollectableSystem


class VelocitySelector(CollectableSystem):
    """Passes on one of two spatial velocities.

    .. pydrake_system::

        name: VelocitySelector
        input_ports:
        - position_control
        - trajectory
        - follow
        output_ports:
        - spatial_velocity

    | port             | direction | type       | unit       | meaning                           |
    |------------------|-----------|------------|------------|-----------------------------------|
    | position_control | in        | vector (6) | rad/s, m/s | [w; v] to a target pose           |
    | trajectory       | in        | vector (6) | rad/s, m/s | [w; v] along a touch's curve      |
    | follow           | in        | vector (1) | -          | 1 takes the trajectory's          |
    | spatial_velocity | out       | vector (6) | rad/s, m/s | the chosen one                    |
    """

    def __init__(self) -> None:
        super().__init__()
        self._position = self.DeclareVectorInputPort("position_control", 6)
        self._trajectory = self.DeclareVectorInputPort("trajectory", 6)
        self._follow = self.DeclareVectorInputPort("follow", 1)
        ports = (self._position, self._trajectory, self._follow)
        self.DeclareVectorOutputPort(
            "spatial_velocity",
            6,
            self._calc_velocity,
            prerequisites_of_calc={port.ticket() for port in ports},
        )

    def _calc_velocity(self, context: Context, output: BasicVector) -> None:
        follows = self._follow.Eval(context)[0] > 0.5
        source = self._trajectory if follows else self._position
        output.SetFromVector(source.Eval(context))
