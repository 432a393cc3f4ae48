"""Meshcat with the robot and with what it believes."""

import numpy as np
from pydrake.geometry import (
    Meshcat,
    MeshcatParams,
    MeshcatVisualizer,
    MeshcatVisualizerParams,
    Role,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem, OutputPort

from vh_drake.hand.model import HandModel
from vh_drake.systems.candidates_publisher import CandidatesPublisher
from vh_drake.systems.cloud_publisher import CloudPublisher
from vh_drake.systems.contacts_publisher import ContactsPublisher
from vh_drake.systems.grasp_contacts_publisher import GraspContactsPublisher
from vh_drake.systems.phase_publisher import PhasePublisher
from vh_drake.systems.surface_publisher import SurfacePublisher
from vh_drake.systems.touch_publisher import TouchPublisher

ROBOT_PERIOD_S = 0.1  # Players interpolate; shorter ones make recordings larger.
CAMERA_W, TARGET_W = (1.4, -0.9, 1.45), (0.5, -0.22, 1.08)
P_W_SIGN, SIGN_HEIGHT_M = (0.75, 0.2, 1.22), 0.1
BACKGROUND = (0.97, 0.98, 1.0)


def make_meshcat(host: str = "localhost", port: int | None = None) -> Meshcat:
    """A server for one page, with a view of the table and a light background.

    Args:
        host: address that it listens at; "*" lets other machines in.
        port: None takes the first free one from 7000.
    """
    meshcat = Meshcat(MeshcatParams(host=host, port=port))
    for color in ("top_color", "bottom_color"):
        meshcat.SetProperty("/Background", color, list(BACKGROUND))
    for path in ("/Grid", "/Axes"):
        meshcat.SetProperty(path, "visible", False)
    # Colours stand for numbers, so that no side may lie in the dark.
    meshcat.SetProperty("/Lights/AmbientLight/<object>", "intensity", 0.9)
    meshcat.SetCameraPose(CAMERA_W, TARGET_W)
    return meshcat


def sign_pose() -> RigidTransform:
    """X_WSign of a sign that is parallel to the image of the camera of `make_meshcat`."""
    y = np.subtract(TARGET_W, CAMERA_W)
    y /= np.linalg.norm(y)
    x = np.cross(y, [0.0, 0.0, 1.0])
    x /= np.linalg.norm(x)
    return RigidTransform(RotationMatrix(np.column_stack([x, y, np.cross(x, y)])), P_W_SIGN)


def add_robot_visualizer(
    builder: DiagramBuilder, query_object: OutputPort, meshcat: Meshcat
) -> MeshcatVisualizer:
    """Shows robot, table and object as people see them.

    Args:
        builder: takes the visualizer.
        query_object: the scene graph's port, or the station's of the same name.
        meshcat: where it draws.
    """
    params = MeshcatVisualizerParams(
        role=Role.kIllustration, prefix="scene", publish_period=ROBOT_PERIOD_S
    )
    visualizer = builder.AddNamedSystem("robot_visualizer", MeshcatVisualizer(meshcat, params))
    builder.Connect(query_object, visualizer.query_object_input_port())
    return visualizer


def add_publishers(
    builder: DiagramBuilder, decision: Diagram, meshcat: Meshcat, hand: HandModel
) -> None:
    """Shows what the decision believes and plans.

    Args:
        builder: holds the decision and takes the publishers.
        decision: with the outputs of `vh_drake.scenes.decision.Decision`.
        meshcat: where they draw.
        hand: whose grasps are planned.
    """
    publishers: dict[str, LeafSystem] = {
        "surface_publisher": SurfacePublisher(meshcat),
        "cloud_publisher": CloudPublisher(meshcat),
        "contacts_publisher": ContactsPublisher(meshcat),
        "touch_publisher": TouchPublisher(meshcat),
        "candidates_publisher": CandidatesPublisher(hand, meshcat),
        "grasp_contacts_publisher": GraspContactsPublisher(hand, meshcat),
        "phase_publisher": PhasePublisher(meshcat, sign_pose(), height_m=SIGN_HEIGHT_M),
    }
    for name, publisher in publishers.items():
        builder.AddNamedSystem(name, publisher)
        for index in range(publisher.num_input_ports()):
            port = publisher.get_input_port(index)
            builder.Connect(decision.GetOutputPort(port.get_name()), port)
