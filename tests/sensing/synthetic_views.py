"""Noisy clouds of known objects on a table, made by casting rays."""

import numpy as np
import trimesh

from vh_drake.sensing.depth_noise import add_depth_noise
from vh_drake.sensing.intrinsics import Intrinsics
from vh_drake.sensing.point_cloud import cloud_from_depth
from vh_drake.sensing.ray_caster import cast_depth
from vh_drake.types import Array, Cloud

TABLE_Z = 0.9
CAMERA = Intrinsics.from_fov(640, 480, np.deg2rad(45.0))


def camera_pose(pitch_deg: float = 50.0) -> Array:
    """(4, 4) optical frame at the robot's head, looking forward and down."""
    pitch = np.deg2rad(pitch_deg)
    z = np.array([np.cos(pitch), 0.0, -np.sin(pitch)])
    x = np.array([0.0, -1.0, 0.0])
    X_WC = np.eye(4)
    X_WC[:3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
    X_WC[:3, 3] = [0.21, 0.0, 1.82]
    return X_WC


def on_table(mesh: trimesh.Trimesh, x: float = 0.7, y: float = -0.3, yaw: float = 0.4):
    """The mesh turned about the vertical and put on the table."""
    mesh = mesh.copy()
    mesh.apply_transform(trimesh.transformations.rotation_matrix(yaw, [0, 0, 1]))
    centre = mesh.bounds.mean(axis=0)
    mesh.apply_translation([x - centre[0], y - centre[1], TABLE_Z - mesh.bounds[0, 2]])
    return mesh


def table() -> trimesh.Trimesh:
    """The table top, 0.6 by 1.2 m."""
    mesh = trimesh.creation.box((0.6, 1.2, 0.04))
    mesh.apply_translation([0.85, -0.2, TABLE_Z - 0.02])
    return mesh


def view(meshes: list[trimesh.Trimesh], X_WC: Array | None = None, seed: int | None = 0) -> Cloud:
    """What the camera sees of the meshes; without a seed the image is perfect."""
    X_WC = camera_pose() if X_WC is None else X_WC
    triangles_W = np.concatenate([np.asarray(mesh.triangles) for mesh in meshes])
    triangles_C = (triangles_W - X_WC[:3, 3]) @ X_WC[:3, :3]
    depth = cast_depth(triangles_C, CAMERA)
    if seed is not None:
        depth = add_depth_noise(depth, CAMERA, np.random.default_rng(seed))
    return cloud_from_depth(depth, CAMERA, X_WC)
