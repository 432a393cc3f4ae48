import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from vh_drake.errors import BadInput
from vh_drake.geometry.skeleton import RAYS, curve_skeleton, wall_distances
from vh_drake.types import ScalarGrid

SPACING = 0.004
R = Rotation.from_rotvec([0.3, -0.5, 0.9]).as_matrix()  # no axis lies along the grid


def grid_of(field, half=0.13):
    steps = np.arange(-half, half + SPACING / 2, SPACING)
    nodes = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1)
    return ScalarGrid(np.full(3, -half), SPACING, field(nodes))


def capsule(a, b, radius):
    def field(p):
        t = np.clip((p - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
        return np.linalg.norm(p - a - t[..., None] * (b - a), axis=-1) - radius

    return field


def box(sides, rotation=R):
    def field(p):
        q = np.abs(p @ rotation) - np.array(sides) / 2
        return np.linalg.norm(np.maximum(q, 0), axis=-1) + np.minimum(q.max(axis=-1), 0)

    return field


def torus(radius, thickness):
    def field(p):
        q = p @ R
        return np.hypot(np.hypot(q[..., 0], q[..., 1]) - radius, q[..., 2]) - thickness

    return field


def cup(radius=0.04, height=0.09, wall=0.006):
    def field(p):
        q = p @ R
        across = np.hypot(q[..., 0], q[..., 1])
        solid = np.maximum(across - radius, np.abs(q[..., 2]) - height / 2)
        hollow = np.maximum(across - radius + wall, -(q[..., 2] + height / 2 - wall))
        return np.maximum(solid, -hollow)

    return field


def test_a_capsules_skeleton_is_its_axis_from_tip_to_tip():
    a, b = R @ [-0.06, 0, 0], R @ [0.06, 0, 0]
    (line,) = curve_skeleton(grid_of(capsule(a, b, 0.02))).lines
    axis = R[:, 0]
    away = line.p - np.outer(line.p @ axis, axis)
    assert np.linalg.norm(away, axis=1).max() < 0.5 * SPACING
    assert line.length == pytest.approx(0.16, abs=SPACING)
    assert line.free == (True, True)
    inner = np.abs(line.p @ axis) < 0.05
    np.testing.assert_allclose(line.reach[inner], 0.02, atol=0.002)
    assert (np.abs(line.tangent[inner] @ axis) > 0.995).all()


def test_rays_are_unit_vectors_across_the_line_and_come_in_opposite_pairs():
    (line,) = curve_skeleton(grid_of(capsule(R @ [-0.06, 0, 0], R @ [0.06, 0, 0], 0.02))).lines
    np.testing.assert_allclose(np.linalg.norm(line.rays, axis=2), 1)
    np.testing.assert_allclose(np.einsum("kri,ki->kr", line.rays, line.tangent), 0, atol=1e-9)
    np.testing.assert_allclose(line.rays[:, : RAYS // 2], -line.rays[:, RAYS // 2 :], atol=1e-9)


def test_sections_of_a_box_are_as_wide_as_its_sides():
    (line,) = curve_skeleton(grid_of(box([0.18, 0.06, 0.03]))).lines
    middle = line.widths[len(line.p) // 2]
    assert middle.min() == pytest.approx(0.03, rel=0.1)
    assert 0.06 <= middle.max() <= np.hypot(0.06, 0.03) + SPACING
    assert line.length == pytest.approx(0.18, rel=0.06)


def test_a_ring_is_a_closed_line_without_ends():
    (line,) = curve_skeleton(grid_of(torus(0.06, 0.015))).lines
    assert line.free == (False, False)
    np.testing.assert_array_equal(line.p[0], line.p[-1])
    q = line.p @ R
    np.testing.assert_allclose(np.hypot(q[:, 0], q[:, 1]), 0.06, atol=SPACING)
    np.testing.assert_allclose(q[:, 2], 0, atol=SPACING)


def test_three_arms_give_three_lines_that_end_at_the_tips():
    tips = 0.08 * np.array([[1, 0, 0], [-0.5, 0.86, 0], [-0.5, -0.86, 0]]) @ R.T
    arms = [capsule(np.zeros(3), tip, 0.015) for tip in tips]
    lines = curve_skeleton(grid_of(lambda p: np.min([arm(p) for arm in arms], axis=0))).lines
    assert len(lines) == 3
    ends = [line.p[0 if line.free[0] else -1] for line in lines]
    for tip in tips * 0.095 / 0.08:
        assert min(np.linalg.norm(end - tip) for end in ends) < 2 * SPACING


def test_a_cube_has_no_direction_so_it_is_a_point_in_its_middle():
    (line,) = curve_skeleton(grid_of(box([0.06, 0.06, 0.06]))).lines
    assert len(line.p) == 1
    np.testing.assert_allclose(line.p[0], 0, atol=2 * SPACING)
    assert not line.tangent.any()


def test_a_closed_shell_has_a_skeleton_too():
    def field(p):
        return np.abs(np.linalg.norm(p, axis=-1) - 0.03) - 0.006

    assert len(curve_skeleton(grid_of(field, half=0.05)).lines) > 0


def test_solids_are_trusted_and_a_cup_is_not():
    for field in (box([0.18, 0.06, 0.03]), torus(0.06, 0.015), box([0.06, 0.06, 0.06])):
        assert curve_skeleton(grid_of(field)).trusted
    hollow = curve_skeleton(grid_of(cup()))
    assert not hollow.trusted
    assert hollow.trust < 0.8


def test_a_shifted_solid_has_a_shifted_skeleton():
    field = capsule(R @ [-0.05, 0, 0], R @ [0.05, 0, 0], 0.02)
    shift = np.array([0.013, -0.006, 0.009])
    (one,) = curve_skeleton(grid_of(field)).lines
    (other,) = curve_skeleton(grid_of(lambda p: field(p - shift))).lines
    ends = {tuple(np.round(p, 2)) for p in (one.p[0] + shift, one.p[-1] + shift)}
    assert {tuple(np.round(p, 2)) for p in (other.p[0], other.p[-1])} == ends


def test_wall_distances_are_those_of_a_ball_and_zero_outside():
    radius = 0.05
    ball = grid_of(lambda p: np.linalg.norm(p, axis=-1) - radius)
    rng = np.random.default_rng(0)
    p = rng.uniform(-0.02, 0.02, (50, 3))
    d = rng.standard_normal((50, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    along = (p * d).sum(axis=1)
    expected = -along + np.sqrt(along**2 + radius**2 - (p**2).sum(axis=1))
    np.testing.assert_allclose(wall_distances(ball, p, d), expected, atol=3e-4)
    assert (wall_distances(ball, p + 0.1, d) == 0).all()


def test_an_empty_solid_has_no_skeleton():
    with pytest.raises(BadInput, match="encloses no node"):
        curve_skeleton(grid_of(lambda p: np.ones(p.shape[:-1])))
