import numpy as np
import pytest
import trimesh

from vh_drake.exploration.kinematic_tip import move_along
from vh_drake.exploration.trajectory import arc_length
from vh_drake.geometry.closest_points import closest_points, triangle_tree
from vh_drake.geometry.meshes import from_trimesh

RADIUS = 0.005
BALL = triangle_tree(from_trimesh(trimesh.creation.icosphere(5, 0.04)))
BOX = triangle_tree(from_trimesh(trimesh.creation.box((0.1, 0.06, 0.04))))


def line(a, b):
    return np.asarray(a, float) + np.linspace(0, 1, 4)[:, None] * (np.asarray(b, float) - a)


def test_a_ball_meets_a_sphere_where_geometry_says():
    motion = move_along(BALL, line([0.1, 0.02, 0.0], [-0.1, 0.02, 0.0]), radius_m=RADIUS)
    centre = np.array([np.sqrt(0.045**2 - 0.02**2), 0.02, 0.0])
    assert motion.touched
    np.testing.assert_allclose(motion.p_WTip, centre, atol=2e-4)
    np.testing.assert_allclose(motion.p_WC, centre * 0.04 / 0.045, atol=2e-4)
    np.testing.assert_allclose(motion.n_WC, centre / 0.045, atol=0.01)
    assert motion.length_m == pytest.approx(0.1 - centre[0], abs=2e-4)
    np.testing.assert_allclose(motion.direction_W, [-1, 0, 0], atol=1e-9)


def test_the_ball_never_enters_the_mesh():
    rng = np.random.default_rng(0)
    for _ in range(30):
        curve = rng.uniform(-0.1, 0.1, (4, 3))
        curve[0] *= 0.12 / np.linalg.norm(curve[0])
        motion = move_along(BOX, curve, radius_m=RADIUS)
        gap = np.linalg.norm(closest_points(BOX, motion.p_WTip[None])[0] - motion.p_WTip)
        assert gap > RADIUS - 2e-4
        assert not motion.touched or gap < RADIUS + 1e-4


def test_a_curve_that_passes_by_goes_on_straight_behind_its_end():
    curve = line([-0.1, 0.06, 0.0], [0.1, 0.06, 0.0])
    motion = move_along(BALL, curve, radius_m=RADIUS, beyond_m=0.02)
    assert not motion.touched
    np.testing.assert_allclose(motion.p_WTip, [0.12, 0.06, 0.0], atol=1e-9)
    assert motion.length_m == pytest.approx(0.22, abs=1e-9)
    assert motion.tau == pytest.approx(1.1)


def test_a_ball_in_contact_may_leave():
    start = np.array([0.045, 0.0, 0.0])
    away = move_along(BALL, line(start, [0.1, 0.0, 0.0]), radius_m=RADIUS)
    into = move_along(BALL, line(start, [0.0, 0.0, 0.0]), radius_m=RADIUS)
    assert not away.touched
    assert into.touched
    assert into.length_m < 1e-3


def test_the_length_is_that_of_the_part_that_was_followed():
    curve = np.array([[0.0, 0.1, 0], [0.05, 0.2, 0], [0.1, 0.2, 0], [0.15, 0.1, 0]])
    whole = move_along(BALL, curve, radius_m=RADIUS)
    assert whole.length_m == pytest.approx(arc_length(curve[None])[0], rel=1e-6)
    bent = np.array([[0.1, 0, 0], [0.1, 0.05, 0], [0.0, 0.05, 0], [-0.02, 0.0, 0]])
    part = move_along(BALL, bent, radius_m=RADIUS)
    tau = np.linspace(0, part.tau, 4000)[:, None]
    p = sum(c * (1 - tau) ** (3 - i) * tau**i * bent[i] for i, c in enumerate((1.0, 3.0, 3.0, 1.0)))
    walked = np.linalg.norm(np.diff(p, axis=0), axis=1).sum()
    assert part.touched
    assert part.length_m == pytest.approx(walked, rel=1e-4)


def test_a_curve_that_stands_still_ends_where_it_is():
    stand = np.tile([0.0, 0.0, 0.1], (4, 1))
    motion = move_along(BALL, stand, radius_m=0.005, beyond_m=0.005)
    assert not motion.touched
    np.testing.assert_array_equal(motion.p_WTip, stand[0])
