"""Velocity control of the fingertip along a planned curve as a LeafSystem."""

from dataclasses import dataclass, field

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.systems.framework import BasicVector, Context, EventStatus, State, ValueProducer

from vh_drake.exploration.follow import FollowSettings, FollowStep, follow
from vh_drake.systems.collectable import CollectableSystem
from vh_drake.types import Immutable, TouchPlan


@dataclass(frozen=True, eq=False)
class _Motion(Immutable):
    """The motion under way: its plan, the orientation in which it began, the last τ."""

    plan: TouchPlan | None = None  # None while not enabled
    R_WT0: RotationMatrix = field(default_factory=RotationMatrix)
    tau: float = 0.0


def _same(plan: TouchPlan, other: TouchPlan) -> bool:
    """Whether two plans lead along one curve to one orientation."""
    curves = np.array_equal(plan.control_points, other.control_points)
    return plan is other or (curves and np.array_equal(plan.n_WT, other.n_WT))


class TrajectoryFollower(CollectableSystem):
    """Follows a touch plan with constant speed (eq. 3.2 to 3.4, Algorithm 2).

    .. pydrake_system::

        name: TrajectoryFollower
        input_ports:
        - plan
        - fingertip_pose
        - enable
        output_ports:
        - spatial_velocity
        - missed

    | port             | direction | type           | unit       | meaning                        |
    |------------------|-----------|----------------|------------|--------------------------------|
    | plan             | in        | TouchPlan      | m          | target and curve               |
    | fingertip_pose   | in        | RigidTransform | m          | X_WT, z along the approach     |
    | enable           | in        | vector (1)     |            | above 0.5: follow              |
    | spatial_velocity | out       | vector (6)     | rad/s, m/s | V_WT, zero when not enabled    |
    | missed           | out       | vector (1)     |            | 1: passed the end by over Δm   |

    A motion begins when `enable` rises or the plan changes: then the
    orientation is latched and τ starts at 0. Beyond the target the curve goes on straight.

    Args:
        settings: speed and gains.
        period_s: between updates of τ.
    """

    def __init__(self, settings: FollowSettings | None = None, period_s: float = 0.01) -> None:
        super().__init__()
        self._settings = settings or FollowSettings()
        self._plan = self.DeclareAbstractInputPort("plan", Value[object](TouchPlan()))
        self._pose = self.DeclareAbstractInputPort("fingertip_pose", Value(RigidTransform()))
        self._enable = self.DeclareVectorInputPort("enable", 1)
        self._motion = self.DeclareAbstractState(Value[object](_Motion()))
        self.DeclarePeriodicUnrestrictedUpdateEvent(period_s, 0.0, self._advance)
        inputs = {port.ticket() for port in (self._plan, self._pose, self._enable)}
        needs = inputs | {self.abstract_state_ticket(self._motion)}
        self._kept = self.DeclareCacheEntry(
            "step",
            ValueProducer(lambda: Value[object](None), self.weakly(self._calc_step)),
            prerequisites_of_calc=needs,
        ).cache_index()  # The entry itself would keep this system for ever.
        after = {self.cache_entry_ticket(self._kept)}
        self.DeclareVectorOutputPort(
            "spatial_velocity", 6, self._calc_velocity, prerequisites_of_calc=after
        )
        self.DeclareVectorOutputPort("missed", 1, self._calc_missed, prerequisites_of_calc=after)

    def _motion_now(self, context: Context) -> _Motion:
        """The motion under way, begun anew where enable or plan has just changed."""
        if self._enable.Eval(context)[0] <= 0.5:
            return _Motion()
        motion: _Motion = context.get_abstract_state(self._motion).get_value()
        plan: TouchPlan = self._plan.Eval(context)
        if motion.plan is not None and _same(motion.plan, plan):
            return motion
        # A copy: the pose's own rotation would change along with the pose.
        return _Motion(plan, RotationMatrix(self._pose.Eval(context).rotation()))

    def _step(self, context: Context) -> FollowStep:
        step: FollowStep = self.get_cache_entry(self._kept).Eval(context)
        return step

    def _calc_step(self, context: Context, output: Value) -> None:
        motion = self._motion_now(context)
        step = FollowStep(np.zeros(6), 0.0, False)
        if motion.plan is not None:
            pose = self._pose.Eval(context)
            step = follow(
                motion.plan, motion.R_WT0, pose, tau_from=motion.tau, settings=self._settings
            )
        output.set_value(step)

    def _advance(self, context: Context, state: State) -> EventStatus:
        motion = self._motion_now(context)
        before: _Motion = context.get_abstract_state(self._motion).get_value()
        if motion.plan is None and before.plan is None:
            return EventStatus.DidNothing()
        advanced = _Motion(motion.plan, motion.R_WT0, self._step(context).tau)
        state.get_mutable_abstract_state(self._motion).set_value(advanced)
        return EventStatus.Succeeded()

    def _calc_velocity(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._step(context).V_WT)

    def _calc_missed(self, context: Context, output: BasicVector) -> None:
        output[0] = float(self._step(context).missed)
