"""A random scene as the robot would see it: an object on the table, one look at it.

No simulator is needed: the object rests in a stable pose, rays are cast from the camera's place
on the robot, and the sensor's noise is added. The truth stays in `TrueObject`; what the robot
knows is the `ObjectView`.
"""

import dataclasses as dc

import numpy as np

from vh_drake.geometry.meshes import TriMesh
from vh_drake.geometry.stable_poses import draw_pose
from vh_drake.sensing.depth_noise import DepthNoiseSettings, add_depth_noise
from vh_drake.sensing.intrinsics import Intrinsics
from vh_drake.sensing.point_cloud import cloud_from_depth
from vh_drake.sensing.ray_caster import cast_depth
from vh_drake.sensing.segmentation import SegmentationSettings, segment
from vh_drake.types import Array, ObjectView, Plane

_SIDES_M = 0.3  # of the patch of table around the object that rays can meet


@dc.dataclass
class SceneSettings:
    """The table, the camera in the robot's head, and how much objects vary."""

    table_height_m: float = 0.9
    center: list[float] = dc.field(default_factory=lambda: [0.7, -0.3])  # of placement, x, y [m]
    radius_m: float = 0.06  # of placement
    p_WCamera: list[float] = dc.field(default_factory=lambda: [0.21, 0.0, 1.8235])  # [m]
    pitch_deg: float = 52.0  # of the view below the horizontal
    yaw_deg: float = -30.0  # to the left of straight ahead
    width: int = 640  # [pixel]
    height: int = 480  # [pixel]
    fov_y_rad: float = 0.7854
    noise: DepthNoiseSettings = dc.field(default_factory=DepthNoiseSettings)
    scale: list[float] = dc.field(default_factory=lambda: [0.8, 1.2])  # of all sides alike
    stretch: list[float] = dc.field(default_factory=lambda: [0.9, 1.1])  # of each side


@dc.dataclass(frozen=True, eq=False)
class TrueObject:
    """What only the generator and the judge may see."""

    mesh: TriMesh  # in the world [m]
    table: Plane
    X_WO: Array  # (4, 4) its pose


def camera_pose(settings: SceneSettings) -> Array:
    """X_WC (4, 4) of the optical frame: +z forward, +x right, +y down."""
    pitch, yaw = np.deg2rad(settings.pitch_deg), np.deg2rad(settings.yaw_deg)
    forward = [np.cos(pitch) * np.cos(yaw), np.cos(pitch) * np.sin(yaw), -np.sin(pitch)]
    right = [np.sin(yaw), -np.cos(yaw), 0.0]
    X = np.eye(4)
    X[:3, :3] = np.column_stack([right, np.cross(forward, right), forward])
    X[:3, 3] = settings.p_WCamera
    return X


def vary(mesh: TriMesh, settings: SceneSettings, rng: np.random.Generator) -> TriMesh:
    """The mesh scaled at random, alike and along its own axes."""
    scale, stretch = settings.scale, settings.stretch
    factors = rng.uniform(scale[0], scale[1]) * rng.uniform(stretch[0], stretch[1], 3)
    return TriMesh(mesh.vertices * factors, mesh.faces)


def place(mesh: TriMesh, settings: SceneSettings, rng: np.random.Generator) -> TrueObject:
    """Put a watertight mesh into a stable pose somewhere near the middle of the placement."""
    X_WO = draw_pose(mesh, seed=int(rng.integers(2**31)))
    radius = settings.radius_m * np.sqrt(rng.random())
    angle = rng.uniform(0.0, 2 * np.pi)
    X_WO[:2, 3] += np.array(settings.center) + radius * np.array([np.cos(angle), np.sin(angle)])
    X_WO[2, 3] += settings.table_height_m
    table = Plane(np.array([0.0, 0.0, 1.0]), settings.table_height_m)
    return TrueObject(mesh.transformed(X_WO), table, X_WO)


def look(truth: TrueObject, settings: SceneSettings, rng: np.random.Generator) -> ObjectView:
    """What the camera shows of the object, in single precision as it is kept on disk.

    Raises:
        NothingSeen: too little of the object is in view.
    """
    X_WC = camera_pose(settings)
    triangles_W = np.concatenate([truth.mesh.triangles, _table_triangles(truth.mesh, settings)])
    triangles_C = (triangles_W - X_WC[:3, 3]) @ X_WC[:3, :3]
    camera = Intrinsics.from_fov(settings.width, settings.height, settings.fov_y_rad)
    depth = add_depth_noise(cast_depth(triangles_C, camera), camera, rng, settings.noise)
    height = settings.table_height_m
    view = segment(
        cloud_from_depth(depth, camera, X_WC),
        SegmentationSettings(
            workspace_min=[0.42, -0.75, height - 0.1],
            workspace_max=[1.10, 0.15, height + 0.45],
            expected_place=[*settings.center, height],
        ),
    )
    return ObjectView(single(view.p_WO), single(view.n_WO), view.table, view.p_WCamera)


def single(values: Array) -> Array:
    """Rounded to single precision, so that what is read from disk gives the same results."""
    rounded: Array = np.asarray(values, np.float32).astype(np.float64)
    return rounded


def _table_triangles(mesh: TriMesh, settings: SceneSettings) -> Array:
    """Two triangles of the table's top around the object, (2, 3, 3) [m]."""
    (x0, y0, _), (x1, y1, _) = mesh.bounds + _SIDES_M * np.array([[-1.0, -1, 0], [1, 1, 0]])
    z = settings.table_height_m
    a, b, c, d = ([x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z])
    return np.array([[a, b, c], [a, c, d]])
