import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from vh_drake.exploration.planar_registration import registered
from vh_drake.geometry.meshes import TriMesh
from vh_drake.geometry.sampling import sample_surface
from vh_drake.geometry.signed_distance import signed_distance_grid
from vh_drake.types import Plane

TABLE = Plane(np.array([0.0, 0.0, 1.0]), 0.9)
CAMERA = np.array([0.2, 0.0, 1.8])


def wedge():
    """Something without symmetry, standing on the table."""
    solid = trimesh.convex.convex_hull(
        [[0, 0, 0], [0.12, 0, 0], [0, 0.06, 0], [0.1, 0.05, 0], [0, 0, 0.08], [0.03, 0.04, 0.07]]
    )
    solid.apply_translation((0.68, -0.3, 0.9))
    return TriMesh(np.array(solid.vertices), np.array(solid.faces, np.int64))


def seen(mesh, noise_m=0.0):
    """Points of the side that the camera sees."""
    p, n = sample_surface(mesh, 3000, seed=1)
    towards = np.einsum("ij,ij->i", n, CAMERA - p) > 0
    return p[towards] + noise_m * np.random.default_rng(0).standard_normal(p[towards].shape)


def moved(shift, turn_deg):
    X = np.eye(4)
    X[:3, :3] = Rotation.from_rotvec([0, 0, np.deg2rad(turn_deg)]).as_matrix()
    middle = np.array([0.72, -0.27, 0.0])
    X[:3, 3] = middle - X[:3, :3] @ middle + [*shift, 0.0]
    return X


@pytest.mark.parametrize(
    ("shift", "turn_deg"), [((0, 0), 0), ((0.01, -0.02), 5), ((0.05, 0.04), -35), ((0.0, 0.1), 80)]
)
def test_a_motion_on_the_table_is_found(shift, turn_deg):
    mesh, X = wedge(), moved(shift, turn_deg)
    distance = signed_distance_grid(mesh, spacing=0.004, padding=0.03)
    motion = registered(distance, seen(mesh.transformed(X), noise_m=0.001), TABLE)
    assert motion.error_m < 0.002
    corners = mesh.vertices
    here = corners @ motion.X_NewOld[:3, :3].T + motion.X_NewOld[:3, 3]
    there = corners @ X[:3, :3].T + X[:3, 3]
    assert np.linalg.norm(here - there, axis=1).max() < 0.004
    np.testing.assert_allclose(motion.X_NewOld[2], [0, 0, 1, 0], atol=1e-12)


def test_a_thing_that_fell_over_does_not_fit():
    mesh = wedge()
    distance = signed_distance_grid(mesh, spacing=0.004, padding=0.03)
    tipped = mesh.vertices - [0.72, -0.27, 0.9]
    tipped = tipped @ Rotation.from_rotvec([np.pi / 2, 0, 0]).as_matrix().T
    tipped += np.array([0.72, -0.27, 0.9]) - [0, 0, tipped[:, 2].min()]
    motion = registered(distance, seen(TriMesh(tipped, mesh.faces)), TABLE)
    assert motion.error_m > 0.003
