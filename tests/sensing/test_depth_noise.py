import numpy as np
import pytest

from vh_drake.sensing.depth_noise import DepthNoiseSettings, add_depth_noise
from vh_drake.sensing.intrinsics import Intrinsics

CAMERA = Intrinsics.from_fov(160, 120, 0.8)


def noisy(depth, seed=0, **settings):
    return add_depth_noise(
        depth, CAMERA, np.random.default_rng(seed), DepthNoiseSettings(**settings)
    )


@pytest.mark.parametrize("z", [0.6, 1.1, 2.0])
def test_axial_noise_head_on_has_the_published_deviation(z):
    wall = np.full((120, 160), z)
    middle = noisy(wall, disparity_step_px=0.0)[40:80, 50:110]
    assert np.std(middle) == pytest.approx(0.0012 + 0.0019 * (z - 0.4) ** 2, rel=0.08)
    assert np.mean(middle) == pytest.approx(z, abs=3e-4)


def test_depth_takes_only_the_values_of_whole_disparity_steps():
    z = noisy(np.full((120, 160), 1.1))
    steps = 580.0 * 0.075 / 0.125 / z[z > 0].astype(float)
    assert np.abs(steps - np.rint(steps)).max() < 1e-3


def test_noise_grows_with_the_angle_of_incidence():
    def tilted(angle):
        q = np.cos(angle) - CAMERA.rays()[..., 0] * np.sin(angle)
        return np.cos(angle) / np.where(q > 0.05, q, np.nan)

    deviation = [
        np.nanstd((noisy(tilted(np.deg2rad(a)), disparity_step_px=0.0) - tilted(np.deg2rad(a)))
                  [50:70, 70:90])
        for a in (0.0, 60.0, 75.0)
    ]  # fmt: skip
    assert deviation[0] < deviation[1] < deviation[2]


def test_surfaces_that_graze_the_rays_drop_out():
    height = 0.05  # of the camera over a plane, so that far rays graze it
    with np.errstate(divide="ignore"):
        floor = np.where(CAMERA.rays()[..., 1] > 0.01, height / CAMERA.rays()[..., 1], np.inf)
    lost = noisy(floor, edge_m=1.0) == 0.0
    assert lost[66:76].all()
    assert lost[100:].mean() < 0.05


def test_edges_fray_and_drop_out_and_the_rest_stays():
    step = np.full((120, 160), 1.0)
    step[:, 80:] = 1.3
    z = noisy(step)
    assert 0.2 < np.mean(z[:, 79:81] == 0.0) < 0.4
    left = z[:, 79][z[:, 79] > 0.0]
    assert 0.1 < np.mean(left > 1.15) < 0.5
    assert np.all(z[:, :77] < 1.1)
    assert np.all(z[:, :77] > 0.9)


def test_pixels_without_a_measurement_stay_without():
    depth = np.full((120, 160), 1.0)
    depth[10:20], depth[30:40], depth[50:60] = np.inf, np.nan, 0.0
    z = noisy(depth)
    assert np.isfinite(z).all()
    assert not z[10:20].any()
    assert not z[30:40].any()
    assert not z[50:60].any()


def test_the_seed_alone_decides_the_noise():
    wall = np.full((120, 160), 1.0)
    assert np.array_equal(noisy(wall, seed=3), noisy(wall, seed=3))
    assert not np.array_equal(noisy(wall, seed=3), noisy(wall, seed=4))
