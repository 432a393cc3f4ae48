"""A can on a table before the robot, as the estimation knows it; shared by several tests."""

import functools

import numpy as np
import trimesh

from vh_drake.control.kinematics import ArmKinematics
from vh_drake.geometry.model_files import models_folder
from vh_drake.hand.clearance import Obstacles, obstacles
from vh_drake.hand.description import load_hand
from vh_drake.hand.model import HandModel, read_hand_model
from vh_drake.types import ObjectView, Plane, Surface, TouchPlan

TABLE = Plane(np.array([0.0, 0.0, 1.0]), 0.9)
P_CAMERA = np.array([0.21, 0.0, 1.82])
CAN = np.array([0.7, -0.3, 0.97])  # middle [m]
RADIUS, HEIGHT = 0.04, 0.14


@functools.cache
def right_hand() -> HandModel:
    """The hand of ARMAR-6."""
    return read_hand_model(load_hand(models_folder() / "armar6_hand" / "armar6_hand.yaml"))


@functools.cache
def right_arm() -> ArmKinematics:
    """The arm that carries it."""
    return ArmKinematics("right")


@functools.cache
def can_surface() -> Surface:
    """A can of 8 by 14 cm."""
    mesh = trimesh.creation.cylinder(RADIUS, HEIGHT, sections=48)
    for _ in range(2):
        mesh = mesh.subdivide()
    mesh.apply_translation(CAN)
    vertices, normals = np.array(mesh.vertices), np.array(mesh.vertex_normals)
    variance = np.linalg.norm(vertices - P_CAMERA, axis=1)
    return Surface(vertices, np.array(mesh.faces, np.int64), normals, variance)


@functools.cache
def can_view() -> ObjectView:
    """What of it the camera sees."""
    surface = can_surface()
    seen = np.einsum("ij,ij->i", surface.normals, P_CAMERA - surface.vertices) > 0
    return ObjectView(surface.vertices[seen], surface.normals[seen], TABLE, P_CAMERA)


@functools.cache
def can_scene() -> Obstacles:
    """It as an obstacle."""
    return obstacles(can_surface(), TABLE)


def touch_of_the_can(heading_rad: float, height_m: float = 0.97) -> TouchPlan:
    """A touch of its side."""
    n = np.array([np.cos(heading_rad), np.sin(heading_rad), 0.0])
    p = np.array([*(CAN + RADIUS * n)[:2], height_m])
    control_points = np.linspace(p + 0.1 * n, p, 4)
    return TouchPlan(p, n, control_points)
