"""Everything from the camera's cloud to commands for arm and hand; it sees sensors alone."""

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem

from vh_drake.control.arm_collisions import ArmCollisions, TableTop
from vh_drake.control.kinematics import ArmKinematics
from vh_drake.exploration.follow import FollowSettings
from vh_drake.exploration.touch_motion import TouchMotionSettings, fingertip_frame, pads_in_hand
from vh_drake.grasping.approach import GraspMotionSettings
from vh_drake.grasping.planner_settings import PlannerSettings
from vh_drake.hand.description import load_hand
from vh_drake.hand.model import HandModel, read_hand_model
from vh_drake.hand.shipped import hand_file
from vh_drake.scenes.rating import make_scorer
from vh_drake.scenes.scenario import Scenario
from vh_drake.sensing.contact_point import Skin, pad_skin
from vh_drake.sensing.ft_contact import FtContactSettings
from vh_drake.sensing.hand_load import HandInertia
from vh_drake.sensing.segmentation import SegmentationSettings
from vh_drake.systems.behaviour import Behaviour, BehaviourSettings
from vh_drake.systems.cartesian_position_controller import CartesianPositionController
from vh_drake.systems.collectable import Collectable
from vh_drake.systems.fingertip import Fingertip
from vh_drake.systems.ft_contact_estimator import FtContactEstimator
from vh_drake.systems.gpis_estimator import GpisEstimator
from vh_drake.systems.grasp_candidate_planner import GraspCandidatePlanner
from vh_drake.systems.grasp_executor import GraspExecutor
from vh_drake.systems.grasp_scorer import GraspScorer
from vh_drake.systems.next_best_touch_planner import NextBestTouchPlanner
from vh_drake.systems.object_segmenter import ObjectSegmenter
from vh_drake.systems.trajectory_follower import TrajectoryFollower
from vh_drake.systems.velocity_selector import VelocitySelector

TOUCH_SPEED_M_S = 0.03
_WRIST_PERIOD_S = 0.005


class Decision(Diagram, metaclass=Collectable):
    """From sensors to commands.

    | port              | direction | type           | unit       | meaning                       |
    |-------------------|-----------|----------------|------------|-------------------------------|
    | cloud             | in        | Cloud          | m          | what the head camera sees     |
    | wrist_wrench      | in        | vector (6)     | N m, N     | [torque; force] about Ho in H |
    | hand_pose         | in        | RigidTransform | m          | X_WH, measured                |
    | hand_velocity     | in        | vector (6)     | rad/s, m/s | [w; v] of H in W, measured    |
    | hand_acceleration | in        | vector (6)     | *          | its rate, rad/s², m/s²        |
    | commanded_pose    | in        | RigidTransform | m          | X_WH, commanded               |
    | commanded_state   | in        | vector (16)    | rad, rad/s | of the arm's servos           |
    | motor_fraction    | in        | vector (k)     | -          | measured travel of the motors |
    | spatial_velocity  | out       | vector (6)     | rad/s, m/s | wanted [w; v] of H in W       |
    | motor_command     | out       | vector (k)     | -          | wanted travel of the motors   |
    | story             | out       | Story          | -          | what happened so far          |
    | phase             | out       | str            | -          | for people                    |
    | view              | out       | ObjectView     | m          | the look                      |
    | contacts          | out       | ContactSet     | m          | felt so far                   |
    | surface           | out       | Surface        | m          | estimate                      |
    | touch_plan        | out       | TouchPlan      | m          | the touch under way           |
    | candidates        | out       | Candidates     | m          | grasps                        |
    | scores            | out       | GraspScores    | -          | their ratings                 |
    """


INPUTS = (
    ("cloud", "segmenter", "cloud"),
    ("wrist_wrench", "contact_estimator", "wrist_wrench"),
    ("hand_velocity", "contact_estimator", "hand_velocity"),
    ("hand_velocity", "fingertip", "hand_velocity"),
    ("hand_acceleration", "contact_estimator", "hand_acceleration"),
    ("hand_pose", "contact_estimator", "hand_pose"),
    ("commanded_pose", "fingertip", "hand_pose"),
    ("commanded_pose", "position_controller", "hand_pose"),
    ("commanded_pose", "executor", "hand_pose"),
    ("commanded_state", "behaviour", "joint_state"),
    ("motor_fraction", "executor", "motor_fraction"),
    ("motor_fraction", "behaviour", "motor_fraction"),
)

WIRES = (
    ("segmenter", "object_view", "behaviour", "object_view"),
    ("segmenter", "status", "behaviour", "view_status"),
    ("behaviour", "view", "estimator", "object_view"),
    ("behaviour", "contacts", "estimator", "contacts"),
    ("behaviour", "surface_request", "estimator", "request"),
    ("estimator", "surface", "behaviour", "surface"),
    ("estimator", "served", "behaviour", "surface_served"),
    ("estimator", "surface", "touch_planner", "surface"),
    ("behaviour", "view", "touch_planner", "object_view"),
    ("behaviour", "contacts", "touch_planner", "contacts"),
    ("fingertip", "fingertip_pose", "touch_planner", "fingertip_pose"),
    ("fingertip", "fingertip_velocity", "touch_planner", "fingertip_velocity"),
    ("behaviour", "touch_request", "touch_planner", "request"),
    ("touch_planner", "plans", "behaviour", "touch_plans"),
    ("touch_planner", "served", "behaviour", "touch_served"),
    ("estimator", "surface", "grasp_planner", "surface"),
    ("behaviour", "view", "grasp_planner", "object_view"),
    ("behaviour", "grasp_request", "grasp_planner", "request"),
    ("grasp_planner", "candidates", "scorer", "candidates"),
    ("grasp_planner", "served", "scorer", "request"),
    ("estimator", "surface", "scorer", "surface"),
    ("behaviour", "view", "scorer", "object_view"),
    ("behaviour", "contacts", "scorer", "contacts"),
    ("grasp_planner", "candidates", "behaviour", "candidates"),
    ("scorer", "scores", "behaviour", "scores"),
    ("scorer", "ranking", "behaviour", "ranking"),
    ("scorer", "served", "behaviour", "grasp_served"),
    ("behaviour", "program", "executor", "program"),
    ("executor", "progress", "behaviour", "progress"),
    ("contact_estimator", "contact_point", "behaviour", "contact_point"),
    ("contact_estimator", "contact", "executor", "contact"),
    ("contact_estimator", "force", "executor", "force"),
    ("contact_estimator", "force", "behaviour", "force"),
    ("executor", "tare", "contact_estimator", "tare"),
    ("executor", "approach_direction", "contact_estimator", "approach_direction"),
    ("executor", "target_pose", "position_controller", "target_pose"),
    ("executor", "target_velocity", "position_controller", "target_velocity"),
    ("executor", "touch_plan", "follower", "plan"),
    ("executor", "follow", "follower", "enable"),
    ("fingertip", "fingertip_pose", "follower", "fingertip_pose"),
    ("follower", "missed", "executor", "missed"),
    ("follower", "spatial_velocity", "fingertip", "tip_command"),
    ("position_controller", "spatial_velocity", "selector", "position_control"),
    ("fingertip", "hand_command", "selector", "trajectory"),
    ("executor", "follow", "selector", "follow"),
)

OUTPUTS = (
    ("selector", "spatial_velocity"),
    ("executor", "motor_command"),
    ("behaviour", "story"),
    ("behaviour", "phase"),
    ("behaviour", "view"),
    ("behaviour", "contacts"),
    ("estimator", "surface"),
    ("executor", "touch_plan"),
    ("grasp_planner", "candidates"),
    ("scorer", "scores"),
)


def make_decision(scenario: Scenario) -> Decision:
    """The part of the diagram that decides; the same on the robot and in simulation."""
    builder = DiagramBuilder()
    hand = read_hand_model(load_hand(hand_file(scenario.hand)))
    systems = {
        name: builder.AddNamedSystem(name, system)
        for name, system in _systems(scenario, hand).items()
    }
    for source, output, sink, port in WIRES:
        builder.Connect(systems[source].GetOutputPort(output), systems[sink].GetInputPort(port))
    exported: set[str] = set()
    for name, sink, port in INPUTS:
        if name in exported:
            builder.ConnectInput(name, systems[sink].GetInputPort(port))
        else:
            builder.ExportInput(systems[sink].GetInputPort(port), name)
            exported.add(name)
    for source, port in OUTPUTS:
        builder.ExportOutput(systems[source].GetOutputPort(port), port)
    decision = Decision()
    builder.BuildInto(decision)
    decision.set_name("decision")
    return decision


def _systems(scenario: Scenario, hand: HandModel) -> dict[str, LeafSystem]:
    kinematics = ArmKinematics("right")
    touch = TouchMotionSettings()
    follow = FollowSettings(speed_m_per_s=TOUCH_SPEED_M_S, missed_after_m=touch.beyond_m)
    return {
        "segmenter": ObjectSegmenter(_workspace(scenario)),
        "estimator": GpisEstimator(),
        "touch_planner": NextBestTouchPlanner(),
        "grasp_planner": GraspCandidatePlanner(
            hand,
            PlannerSettings(planners=scenario.planners, approaches=scenario.approaches),
            scenario.seed,
            arm=kinematics,
        ),
        "scorer": GraspScorer(make_scorer(scenario.scorer, hand, scenario.seed, scenario.weights)),
        "behaviour": Behaviour(
            hand,
            kinematics,
            BehaviourSettings(
                touches=scenario.touches,
                attempts=scenario.attempts,
                grasp=GraspMotionSettings(closing=scenario.closing),
            ),
            collisions=_collisions(scenario, hand, kinematics),
        ),
        "executor": GraspExecutor(hand, kinematics.pose(kinematics.home)),
        "position_controller": CartesianPositionController(),
        "fingertip": Fingertip(fingertip_frame(hand)),
        "follower": TrajectoryFollower(follow),
        "selector": VelocitySelector(),
        "contact_estimator": make_contact_estimator(hand, scenario.time_step_s),
    }


def make_contact_estimator(hand: HandModel, time_step_s: float) -> FtContactEstimator:
    """What the robot's wrist feels, the hand's own load taken off.

    Args:
        hand: on the wrist.
        time_step_s: of the plant.
    """
    return FtContactEstimator(
        touching_skin(hand),
        HandInertia(hand.mass_kg, hand.p_HCom, hand.I_H),
        FtContactSettings(period_s=wrist_period(time_step_s)),
    )


def wrist_period(time_step_s: float) -> float:
    """Between samples of the wrist [s]: the plant's steps that come nearest to `_WRIST_PERIOD_S`.

    A sample between two steps would have to solve the next one early, and for nothing.
    """
    return time_step_s * max(1, round(_WRIST_PERIOD_S / time_step_s))


def _collisions(scenario: Scenario, hand: HandModel, kinematics: ArmKinematics) -> ArmCollisions:
    """The robot knows itself, and where its table stands."""
    x, y = scenario.table.center
    length, width = scenario.table.size
    table = TableTop((x, y), (length, width))
    return ArmCollisions(kinematics, hand.description.model, hand.description.base, table)


def touching_skin(hand: HandModel) -> Skin:
    """The pads of the open fingers, that of the touching finger first, and their round ends."""
    p, n = pads_in_hand(hand)
    X_HT = fingertip_frame(hand)
    order = ((p - X_HT[:3, 3]) ** 2).sum(axis=1).argsort()
    pads = pad_skin(p[order], n[order])
    centers, radii = hand.spheres(hand.lower)
    ends = hand.tip_spheres[hand.opposing == 0]
    tilts = np.deg2rad(np.linspace(0.0, 70.0, 8))
    out = np.cos(tilts)[:, None] * X_HT[:3, 2] + np.sin(tilts)[:, None] * X_HT[:3, 0]
    p_HEnd = centers[ends][:, None] + radii[ends][:, None, None] * out
    return Skin(
        np.vstack([pads.p_H, p_HEnd.reshape(-1, 3)]),
        np.vstack([pads.n_H, np.tile(out, (len(ends), 1))]),
        pads.p_HExpected,
    )


def _workspace(scenario: Scenario) -> SegmentationSettings:
    """Where the object may be: around its place, on the table."""
    height = scenario.table.height_m
    defaults = SegmentationSettings()
    low, high = list(defaults.workspace_min), list(defaults.workspace_max)
    low[2], high[2] = height - 0.1, height + 0.45
    return SegmentationSettings(
        workspace_min=low,
        workspace_max=high,
        expected_place=[*scenario.placement.center, height],
        seed=scenario.seed,
        known_height_m=height,
    )
