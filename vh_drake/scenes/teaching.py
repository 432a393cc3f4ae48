"""The simulated robot under the hands of a teacher."""

import dataclasses as dc

import numpy as np
from pydrake.geometry import Meshcat
from pydrake.math import RigidTransform
from pydrake.systems.framework import Context, Diagram, DiagramBuilder

from vh_drake.control.reach import rollout
from vh_drake.errors import BadInput
from vh_drake.grasping.motions import CollectSettings, collect_pose
from vh_drake.hand.model import HandModel
from vh_drake.objects.model import ObjectModel
from vh_drake.scenes.decision import make_contact_estimator
from vh_drake.scenes.placing import draw_object_pose, place_object
from vh_drake.scenes.scenario import Scenario
from vh_drake.scenes.showing import add_robot_visualizer
from vh_drake.scenes.station import Station, make_station
from vh_drake.systems.cartesian_position_controller import CartesianPositionController
from vh_drake.types import Array

_ABOVE_M = 0.05  # of the hand over the object at the start
_HEADINGS_DEG = (0, 20, -20, 40, -40, 60, -60, 80, -80)  # of the fingers; 0 is forward
_TO_DECISION = ("wrist_wrench", "hand_pose", "hand_velocity", "hand_acceleration")


@dc.dataclass(frozen=True)
class TeachingScene:
    """The diagram and what moves it.

    Ports of the diagram beside those of the station:

    | port               | direction | type           | unit | meaning                         |
    |--------------------|-----------|----------------|------|---------------------------------|
    | target_pose        | in        | RigidTransform | m    | X_WH where the hand shall be    |
    | motor_command      | in        | vector (k)     | -    | wanted travel of the motors     |
    | tare               | in        | vector (1)     | -    | id; a change asks for F_0       |
    | approach_direction | in        | vector (3)     | -    | of a guarded motion, in W       |
    | contact            | out       | vector (1)     | -    | 1: touched since the tare       |
    | commanded_pose     | out       | RigidTransform | m    | X_WH of the arm's servos        |
    | hand_pose          | out       | RigidTransform | m    | X_WH, measured                  |
    """

    diagram: Diagram
    station: Station
    context: Context  # with the object in its place
    X_WH0: Array  # (4, 4) over the object, within reach

    @property
    def hand(self) -> HandModel:
        """The hand that is taught."""
        return self.station.hand


def make_teaching_scene(
    scenario: Scenario, model: ObjectModel, meshcat: Meshcat | None = None
) -> TeachingScene:
    """The robot at its table, its hand driven by a target pose.

    Args:
        scenario: what is simulated; what concerns the decision plays no part.
        model: the object.
        meshcat: where to show it.

    Raises:
        BadInput: the arm can't bring the hand over the object.
    """
    builder = DiagramBuilder()
    station = builder.AddSystem(make_station(scenario, model))
    controller = builder.AddNamedSystem("position_controller", CartesianPositionController())
    estimator = builder.AddNamedSystem(
        "contact_estimator", make_contact_estimator(station.hand, scenario.time_step_s)
    )
    builder.Connect(station.GetOutputPort("commanded_pose"), controller.GetInputPort("hand_pose"))
    builder.Connect(
        controller.GetOutputPort("spatial_velocity"), station.GetInputPort("spatial_velocity")
    )
    for name in _TO_DECISION:
        builder.Connect(station.GetOutputPort(name), estimator.GetInputPort(name))
    builder.ExportInput(controller.GetInputPort("target_pose"), "target_pose")
    builder.ExportInput(station.GetInputPort("motor_command"), "motor_command")
    for name in ("tare", "approach_direction"):
        builder.ExportInput(estimator.GetInputPort(name), name)
    builder.ExportOutput(estimator.GetOutputPort("contact"), "contact")
    for name in ("commanded_pose", "hand_pose"):
        builder.ExportOutput(station.GetOutputPort(name), name)
    if meshcat is not None:
        add_robot_visualizer(builder, station.GetOutputPort("query_object"), meshcat)
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    X_WO = draw_object_pose(scenario, model)
    place_object(station, context, X_WO)
    return TeachingScene(diagram, station, context, start_pose(station, model, X_WO, scenario))


def start_pose(
    station: Station, model: ObjectModel, X_WO: RigidTransform, scenario: Scenario
) -> Array:
    """X_WH (4, 4) of the open hand, palm down, its power TCP over the object's middle.

    Fingertips and thumb are at one height, as a grasp from the top begins (figure 4.19).

    Raises:
        BadInput: no heading of the fingers is within reach.
    """
    hand, arm = station.hand, station.kinematics
    X_TH = collect_pose(hand, hand.lower, CollectSettings())
    points = (X_WO @ model.mesh.vertices.T).T
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    p_WT = [*middle[:2], max(float(points[:, 2].max()), scenario.table.height_m) + _ABOVE_M]
    for heading in np.deg2rad(_HEADINGS_DEG):
        c, s = np.cos(heading), np.sin(heading)
        X_WT = np.eye(4)
        X_WT[:2, :2] = [[c, -s], [s, c]]
        X_WT[:3, 3] = p_WT
        X_WH = X_WT @ X_TH
        if rollout(arm, arm.home, [X_WH]).reached:
            return X_WH
    raise BadInput(
        f"the arm can't bring its hand over the object at {np.round(middle, 2).tolist()} m; "
        "move `placement.center` of the scenario nearer"
    )
