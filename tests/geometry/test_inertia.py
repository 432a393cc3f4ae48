import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from vh_drake.errors import BadInput
from vh_drake.geometry.inertia import mass_properties
from vh_drake.geometry.meshes import from_trimesh


def test_a_box_has_its_closed_form_inertia():
    a, b, c = 0.1, 0.2, 0.3
    box = from_trimesh(trimesh.creation.box((a, b, c)))
    result = mass_properties(box, 1.2)
    expected = 1.2 / 12 * np.diag([b**2 + c**2, a**2 + c**2, a**2 + b**2])
    np.testing.assert_allclose(result.inertia, expected, atol=1e-12)
    np.testing.assert_allclose(result.com, 0, atol=1e-12)


def test_a_fine_ball_approaches_two_fifths_m_r_squared():
    ball = from_trimesh(trimesh.creation.icosphere(5, 0.05))
    result = mass_properties(ball, 2.0)
    np.testing.assert_allclose(
        result.inertia, 0.4 * 2.0 * 0.05**2 * np.eye(3), rtol=2e-3, atol=1e-9
    )


def test_inertia_agrees_with_trimesh_on_an_asymmetric_body():
    peer = trimesh.creation.torus(0.04, 0.01)
    peer.vertices *= [1.0, 0.6, 1.3]
    peer.vertices += 0.2 * peer.vertices[:, [1, 2, 0]] + [1.0, -2.0, 3.0]
    peer.density = 0.7 / peer.volume
    result = mass_properties(from_trimesh(peer), 0.7)
    np.testing.assert_allclose(result.com, peer.center_mass, atol=1e-9)
    np.testing.assert_allclose(result.inertia, peer.moment_inertia, atol=1e-9)


def test_a_rigid_motion_turns_the_inertia_and_moves_the_centre():
    torus = from_trimesh(trimesh.creation.torus(0.04, 0.01))
    X = np.eye(4)
    X[:3, :3] = Rotation.from_rotvec([0.3, -0.8, 0.5]).as_matrix()
    X[:3, 3] = [0.4, 0.1, -0.6]
    before, after = mass_properties(torus, 0.3), mass_properties(torus.transformed(X), 0.3)
    R = X[:3, :3]
    np.testing.assert_allclose(after.inertia, R @ before.inertia @ R.T, atol=1e-12)
    np.testing.assert_allclose(after.com, R @ before.com + X[:3, 3], atol=1e-12)


@pytest.mark.parametrize("mass", [0.0, -1.0, np.nan, np.inf])
def test_an_impossible_mass_is_refused(mass):
    with pytest.raises(BadInput, match="mass"):
        mass_properties(from_trimesh(trimesh.creation.box()), mass)


def test_an_open_mesh_is_refused():
    box = from_trimesh(trimesh.creation.box())
    with pytest.raises(BadInput, match="watertight"):
        mass_properties(box.with_faces(np.arange(11)), 1.0)
