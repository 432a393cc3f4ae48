"""`bench control`: random reaches over the table by our three controllers and by Drake's.

Each reach starts with the hand at one random grasp pose over the table and ends at another; the
arm has a configuration for both. Our controllers, the same without the null space, and Drake's
`DifferentialInverseKinematicsSystem` command joint velocities every 10 ms, which the same limits
of the joints bound and sum up. Drake's gets the same speeds, the same gain, and the middle of the
joints' ranges as its nominal posture, which is where eq. 4.5 draws them too. Its collision
constraint is left out, since ours has none; costs and margins are its defaults, but the hand
counts 10,000 times as much as the posture: with 100 times it reaches less, with the larger gain
that its documentation names it leaves the straight way farther.
"""

import contextlib
import os
import sys
import time
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.multibody.inverse_kinematics import DifferentialInverseKinematicsSystem
from pydrake.multibody.math import SpatialVelocity
from pydrake.planning import (
    DofMask,
    JointLimits,
    RobotDiagramBuilder,
    SceneGraphCollisionChecker,
)
from pydrake.systems.framework import BusValue, DiagramBuilder
from scipy.spatial.transform import Rotation

from vh_drake.catalog import Options
from vh_drake.control.cartesian_position import (
    GAIN_PER_S,
    MAX_ANGULAR_RAD_S,
    MAX_LINEAR_M_S,
    pose_error,
)
from vh_drake.control.joint_limits import next_joint_state
from vh_drake.control.kinematics import (
    SUFFIX,
    TORSO_JOINT,
    ArmKinematics,
    arm_joint_names,
    home_configuration,
)
from vh_drake.control.null_space import GAIN
from vh_drake.control.reach import solve_ik
from vh_drake.geometry.robot_model import add_armar6
from vh_drake.grasping.motions import hand_axes, pitched_rotation
from vh_drake.hand.description import load_hand
from vh_drake.hand.model import HandModel, read_hand_model
from vh_drake.hand.shipped import hand_file
from vh_drake.reports import Report, Row
from vh_drake.systems.cartesian_position_controller import CartesianPositionController
from vh_drake.systems.cartesian_velocity_controller import CartesianVelocityController
from vh_drake.systems.nullspace_controller import NullspaceController
from vh_drake.types import Array

REACHES = 200
PERIOD_S = 0.01
LONGEST_S, PATIENCE_S = 8.0, 1.5
POSITION_M, ANGLE_RAD = 0.002, 0.02  # within which a pose is reached
# Of the power TCP [m]; the table's top is at z = 0.9.
LOW, HIGH = np.array([0.55, -0.55, 0.93]), np.array([0.85, 0.0, 1.2])
_POSTURE_WEIGHT = 1e-4

Controller = Callable[[Array, Array, Array, Array], tuple[Array, float]]
"""From X_target, X_WH, q and joint velocities to joint velocities and the time it took [s]."""


class Reach(NamedTuple):
    """How one controller fared."""

    reached: bool
    deviation_mm: float  # the hand's largest distance from the straight way
    duration_s: float


def run(options: Options) -> Report:
    """All reaches by the three controllers; one row a reach."""
    arm, hand = ArmKinematics(), read_hand_model(load_hand(hand_file()))
    tasks = reaches(arm, hand, options.runs or REACHES, options.seed)
    controllers = {
        "": ours(arm),
        "no_nullspace_": ours(arm, gain=0.0),
        "drake_": drakes(arm),
    }
    rows: list[Row] = [{"reach": i} for i in range(len(tasks))]
    summary: Row = {}
    for prefix, controller in controllers.items():
        times: list[float] = []
        for row, (q, X_WH) in zip(rows, tasks, strict=True):
            result = carried_out(arm, controller, q, X_WH, times)
            row[f"{prefix}reached"] = result.reached
            row[f"{prefix}deviation_mm"] = round(result.deviation_mm, 3)
            row[f"{prefix}duration_s"] = round(result.duration_s, 3)
        summary |= _summarized(rows, prefix, times)
    settings = {
        "reaches": len(tasks),
        "seed": options.seed,
        "period_s": PERIOD_S,
        "position_mm": 1e3 * POSITION_M,
        "angle_rad": ANGLE_RAD,
    }
    return Report("control", settings, summary, rows=rows)


def reaches(
    arm: ArmKinematics, hand: HandModel, count: int, seed: int
) -> list[tuple[Array, Array]]:
    """Joint positions (8,) to start from and hand poses (4, 4) to reach.

    Of both the arm has a configuration, found from random ones.
    """
    rng = np.random.default_rng(seed)
    found: list[tuple[Array, Array]] = []
    q = None
    while len(found) < count:
        X_WH = _grasp_pose(hand, rng)
        after = solve_ik(arm, X_WH, [rng.uniform(arm.lower, arm.upper)], restarts=5, seed=seed)
        if after is None:
            continue
        if q is not None:
            found.append((q, X_WH))
        q = after if q is None else None
    return found


def _grasp_pose(hand: HandModel, rng: np.random.Generator) -> Array:
    """Palm down or, in every second pose, to the side; the power TCP over the table."""
    pitch = np.deg2rad(rng.uniform(15.0, 60.0))
    heading, roll = np.deg2rad(rng.uniform(-30.0, 90.0)), 0.0
    if rng.uniform() < 0.5:  # from the side, the thumb up
        pitch, roll = 0.0, np.pi / 2
    X = np.eye(4)
    turn = Rotation.from_euler("ZX", [heading, _thumb_up(hand) * roll]).as_matrix()
    X[:3, :3] = turn @ pitched_rotation(hand, float(pitch))
    X[:3, 3] = rng.uniform(LOW, HIGH) - X[:3, :3] @ np.asarray(hand.description.tcps["power"])
    return X


def _thumb_up(hand: HandModel) -> float:
    """The sense in which the hand rolls about its fingers so that the thumb comes up."""
    thumbs = hand.tips(hand.lower)[hand.opposing == 1]
    along, palm = hand_axes(hand)
    return float(np.sign(thumbs.mean(axis=0) @ np.cross(-palm, along))) if len(thumbs) else 1.0


def carried_out(
    arm: ArmKinematics, controller: Controller, q: Array, X_target: Array, times: list[float]
) -> Reach:
    """Follow a controller until the pose is reached or comes no nearer for a while."""
    velocity, best, since_s, deviation = np.zeros(8), np.inf, 0.0, 0.0
    start = arm.pose(q)[:3, 3]
    for step in range(int(LONGEST_S / PERIOD_S)):
        X_WH, now_s = arm.pose(q), step * PERIOD_S
        error = pose_error(X_target, X_WH)
        remaining = max(
            float(np.linalg.norm(error[:3])) / ANGLE_RAD,
            float(np.linalg.norm(error[3:])) / POSITION_M,
        )
        deviation = max(deviation, _off_line(X_WH[:3, 3], start, X_target[:3, 3]))
        if remaining <= 1.0:
            return Reach(True, 1e3 * deviation, now_s)
        if remaining < 0.99 * best:
            best, since_s = remaining, now_s
        if now_s - since_s > PATIENCE_S:
            break
        wanted, seconds = controller(X_target, X_WH, q, velocity)
        times.append(seconds)
        state = np.concatenate([q, velocity])
        after = next_joint_state(wanted, state, arm.limits, period_s=PERIOD_S)
        q, velocity = after[:8], after[8:]
    return Reach(False, 1e3 * deviation, now_s)


def _off_line(p: Array, start: Array, end: Array) -> float:
    """Distance of a point (3,) from the piece of a straight line between two others [m]."""
    way = end - start
    share = np.clip((p - start) @ way / max(float(way @ way), 1e-12), 0.0, 1.0)
    return float(np.linalg.norm(p - start - share * way))


def ours(arm: ArmKinematics, *, gain: float = GAIN) -> Controller:
    """The three LeafSystems in a row."""
    builder = DiagramBuilder()
    position = builder.AddSystem(CartesianPositionController())
    cartesian = builder.AddSystem(CartesianVelocityController(arm))
    nullspace = builder.AddSystem(NullspaceController(arm, gain=gain))
    builder.Connect(position.get_output_port(), cartesian.GetInputPort("spatial_velocity"))
    builder.Connect(cartesian.get_output_port(), nullspace.GetInputPort("joint_velocity"))
    builder.ExportInput(position.GetInputPort("target_pose"), "target_pose")
    builder.ExportInput(position.GetInputPort("hand_pose"), "hand_pose")
    builder.ExportInput(cartesian.GetInputPort("joint_state"), "joint_state")
    builder.ConnectInput("joint_state", nullspace.GetInputPort("joint_state"))
    builder.ExportOutput(nullspace.get_output_port(), "joint_velocity")
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    target, hand = (diagram.GetInputPort(name) for name in ("target_pose", "hand_pose"))
    state, output = diagram.GetInputPort("joint_state"), diagram.get_output_port()

    def control(X_target: Array, X_WH: Array, q: Array, velocity: Array) -> tuple[Array, float]:
        target.FixValue(context, Value(RigidTransform(X_target)))
        hand.FixValue(context, Value(RigidTransform(X_WH)))
        state.FixValue(context, np.r_[q, velocity])
        before = time.thread_time()
        wanted = output.Eval(context)
        return wanted.copy(), time.thread_time() - before

    return control


def drakes(arm: ArmKinematics) -> Controller:
    """Drake's system on the same arm."""
    fixed = dict(zip(arm_joint_names("left"), home_configuration("left"), strict=True))
    builder = RobotDiagramBuilder(time_step=0.0)
    robot = add_armar6(
        builder.plant(), fixed_joints=fixed | {TORSO_JOINT: arm.torso_position_m}, visuals=False
    )
    builder.plant().Finalize()
    checker = SceneGraphCollisionChecker(
        model=builder.Build(), robot_model_instances=[robot], edge_step_size=0.1
    )
    kind = DifferentialInverseKinematicsSystem
    recipe, cost = kind.Recipe(), kind.LeastSquaresCost.Config()
    cost.cartesian_qp_weight = 1.0 / _POSTURE_WEIGHT
    recipe.AddIngredient(kind.LeastSquaresCost(cost))
    recipe.AddIngredient(kind.JointCenteringCost(kind.JointCenteringCost.Config()))
    recipe.AddIngredient(
        kind.JointVelocityLimitConstraint(
            kind.JointVelocityLimitConstraint.Config(), JointLimits(checker.plant())
        )
    )
    system = kind(
        recipe,
        "world",
        checker,
        DofMask(8, True),
        PERIOD_S,
        GAIN_PER_S * PERIOD_S,
        SpatialVelocity(np.full(3, MAX_ANGULAR_RAD_S), np.full(3, MAX_LINEAR_M_S)),
    )
    context = system.CreateDefaultContext()
    system.GetInputPort("nominal_posture").FixValue(context, (arm.lower + arm.upper) / 2)
    frame = checker.plant().GetFrameByName(f"hand_fixed_{SUFFIX[arm.side]}").scoped_name()
    name = frame.get_full()
    target = system.GetInputPort("desired_cartesian_poses")
    position, output = system.GetInputPort("position"), system.get_output_port()

    def control(X_target: Array, X_WH: Array, q: Array, velocity: Array) -> tuple[Array, float]:
        goals = BusValue()
        goals.Set(name, Value(RigidTransform(X_target)))
        target.FixValue(context, Value(goals))
        position.FixValue(context, q)
        with _quiet():
            before = time.thread_time()
            wanted = output.Eval(context)
            seconds = time.thread_time() - before
        return wanted.copy(), seconds

    return control


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """The solver's chatter, which it writes past Python, does not reach standard output."""
    sys.stdout.flush()
    kept, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    try:
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nowhere)


def _summarized(rows: list[Row], prefix: str, times: list[float]) -> Row:
    """Metrics of one controller; its name comes last in theirs."""
    suffix = f"_{prefix}".removesuffix("_")
    deviations = np.array([row[f"{prefix}deviation_mm"] for row in rows])
    return {
        f"update_ms{suffix}": round(1e3 * float(np.median(times)), 4),
        f"reached_share{suffix}": round(
            float(np.mean([row[f"{prefix}reached"] for row in rows])), 4
        ),
        f"deviation_median_mm{suffix}": round(float(np.median(deviations)), 3),
        f"deviation_p95_mm{suffix}": round(float(np.quantile(deviations, 0.95)), 3),
    }
