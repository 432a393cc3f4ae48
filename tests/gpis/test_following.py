import numpy as np
import pytest
import trimesh

from vh_drake.errors import BadInput
from vh_drake.gpis.following import follow_surface
from vh_drake.gpis.kernels import SquaredExponential, ThinPlate
from vh_drake.gpis.meshing import closed_mesh
from vh_drake.gpis.observations import surface_observations
from vh_drake.gpis.posterior import fit
from vh_drake.types import ScalarGrid

KERNELS = [ThinPlate(0.5, 0.5 / 6**0.5), SquaredExponential(0.06, 0.05)]


def ball(count=40, radius=0.05, centre=(0.0, 0.0, 0.0)):
    n = np.random.default_rng(0).normal(size=(count, 3))
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    return radius * n + np.asarray(centre), n


def posterior_of(kernel, p, n):
    return fit(kernel, surface_observations(p, n, value_std_m=5e-4, gradient_std=0.05))


@pytest.mark.parametrize("kernel", KERNELS)
def test_sheet_of_a_ball_is_closed_outward_and_on_the_zero_set(kernel):
    p, n = ball()
    posterior = posterior_of(kernel, p, n)
    sheet = follow_surface(posterior, p)
    mesh = trimesh.Trimesh(sheet.vertices, sheet.faces, process=False)
    assert mesh.is_watertight
    assert mesh.euler_number == 2
    assert mesh.volume == pytest.approx(4 / 3 * np.pi * 0.05**3, rel=0.02)
    assert np.abs(posterior.mean(sheet.vertices)).max() < 2e-5
    radial = sheet.vertices / np.linalg.norm(sheet.vertices, axis=1, keepdims=True)
    assert np.einsum("ij,ij->i", sheet.normals, radial).min() > 0.98


@pytest.mark.parametrize("kernel", KERNELS)
def test_following_finds_the_surface_that_filling_the_volume_finds(kernel):
    p, n = ball()
    posterior = posterior_of(kernel, p, n)
    sheet = follow_surface(posterior, p, spacing_m=0.004)
    axis = np.arange(-0.06, 0.0601, 0.004)
    filled = closed_mesh(
        ScalarGrid(np.full(3, -0.06), 0.004, posterior.mean_on_grid(axis, axis, axis)), p
    )
    a = trimesh.Trimesh(sheet.vertices, sheet.faces)
    b = trimesh.Trimesh(filled[0], filled[1])
    assert a.volume == pytest.approx(b.volume, rel=0.01)
    assert a.area == pytest.approx(b.area, rel=0.01)


def test_sheet_ends_at_the_crop_box():
    p = np.array([[0.1, 0.2, 0.3]])
    posterior = posterior_of(KERNELS[0], p, np.array([[0.0, 0.0, 1.0]]))
    sheet = follow_surface(posterior, p, margin_m=0.03)
    assert np.abs(sheet.vertices - p).max() < 0.03 + 0.005
    assert np.ptp(sheet.vertices, axis=0)[:2].min() > 0.05
    assert np.abs(sheet.vertices[:, 2] - 0.3).max() < 1e-5


def test_a_spurious_sheet_apart_from_the_contacts_is_not_met():
    p, n = ball()
    posterior = posterior_of(SquaredExponential(0.02, 0.05), p, n)
    far = np.array([[0.3, 0.0, 0.0]])
    hollow = posterior.append(surface_observations(far, -n[:1], value_std_m=1e-3, gradient_std=0.1))
    sheet = follow_surface(hollow, p, margin_m=0.4)
    assert np.linalg.norm(sheet.vertices, axis=1).max() < 0.2


def test_a_shift_by_whole_cells_shifts_the_sheet():
    p, n = ball()
    shift = 0.005 * np.array([3, -2, 7])
    sheet = follow_surface(posterior_of(KERNELS[0], p, n), p)
    moved = follow_surface(posterior_of(KERNELS[0], p + shift, n), p + shift)
    np.testing.assert_allclose(moved.vertices, sheet.vertices + shift, atol=1e-9)
    np.testing.assert_array_equal(moved.faces, sheet.faces)


@pytest.mark.parametrize(
    ("p", "spacing", "margin", "message"),
    [
        (np.zeros((0, 3)), 0.005, 0.01, "no contact"),
        (np.zeros((1, 3)), 0.0, 0.01, "positive"),
        (np.zeros((1, 3)), 0.005, np.nan, "positive"),
        (np.array([[0.0, 0, 0], [1e4, 0, 0]]), 0.005, 0.01, "raise spacing_m"),
    ],
)
def test_what_cannot_be_followed_says_so(p, spacing, margin, message):
    posterior = posterior_of(KERNELS[0], *ball(3))
    with pytest.raises(BadInput, match=message):
        follow_surface(posterior, p, spacing_m=spacing, margin_m=margin)
