import numpy as np
import trimesh

from vh_drake.sensing.intrinsics import Intrinsics
from vh_drake.sensing.ray_caster import cast_depth

CAMERA = Intrinsics.from_fov(64, 48, 0.9)


def test_a_plane_gives_its_analytic_depth_in_every_pixel():
    normal, offset = np.array([0.2, -0.3, 1.0]), 1.2
    corners = [
        [x, y, (offset - 0.2 * x + 0.3 * y)] for x, y in [(-3, -3), (3, -3), (3, 3), (-3, 3)]
    ]
    triangles = np.array(corners)[[[0, 1, 2], [0, 2, 3]]]
    expected = offset / (CAMERA.rays() @ normal)
    np.testing.assert_allclose(cast_depth(triangles, CAMERA), expected, rtol=1e-12)


def test_a_sphere_gives_the_nearer_root_of_its_quadratic():
    centre, radius = np.array([0.1, -0.05, 1.0]), 0.2
    ball = trimesh.creation.icosphere(5, radius)
    ball.apply_translation(centre)
    depth = cast_depth(np.asarray(ball.triangles), CAMERA)
    d = CAMERA.rays()
    dd, dc = (d * d).sum(-1), d @ centre
    disc = dc**2 - dd * (centre @ centre - radius**2)
    hit = disc > 0.01
    assert np.isfinite(depth[hit]).all()
    assert np.isinf(depth[disc < 0.0]).all()
    np.testing.assert_allclose(
        depth[hit], ((dc - np.sqrt(np.maximum(disc, 0))) / dd)[hit], atol=5e-4
    )


def test_a_triangle_that_reaches_behind_the_camera_is_seen_in_front_only():
    floor = np.array([[[-50.0, 0.5, -50.0], [50.0, 0.5, -50.0], [0.0, 0.5, 90.0]]])
    depth = cast_depth(floor, CAMERA, max_depth_m=2.0)
    down = CAMERA.rays()[..., 1]
    assert np.isinf(depth[down < 0.0]).all()
    near = down > 0.3
    np.testing.assert_allclose(depth[near], 0.5 / down[near])


def test_the_order_of_triangles_and_their_sense_do_not_matter():
    rng = np.random.default_rng(0)
    triangles = rng.uniform(-0.5, 0.5, (30, 3, 3)) + np.array([0, 0, 1.5])
    shuffled = triangles[rng.permutation(30)][:, ::-1]
    np.testing.assert_allclose(cast_depth(triangles, CAMERA), cast_depth(shuffled, CAMERA))


def test_too_near_is_zero_too_far_and_empty_are_infinite_and_nan_is_skipped():
    def wall(z):
        return np.array([[[-9, -9, z], [9, -9, z], [0, 20, z]]], dtype=float)

    assert (cast_depth(wall(0.2), CAMERA) == 0.0).all()
    assert np.isinf(cast_depth(wall(3.5), CAMERA)).all()
    assert np.isinf(cast_depth(np.zeros((0, 3, 3)), CAMERA)).all()
    assert np.isinf(cast_depth(wall(np.nan), CAMERA)).all()
    assert np.isinf(cast_depth(wall(-1.0), CAMERA)).all()
