import numpy as np
import pytest
import torch
from learning_scenes import can_estimate, poses_around_the_can
from scipy.spatial.transform import Rotation

from vh_drake.errors import BadInput
from vh_drake.learning.features import (
    BOUND_M,
    NUMBERS,
    SIDE_M,
    VOXELS,
    exact_grid,
    pose_inputs,
    sample_grids,
    scene_fields,
    voxel_centers,
)
from vh_drake.learning.hints import HINT_NUMBERS, Hints
from vh_drake.types import Candidates, ContactSet, ObjectView, Plane, ScalarGrid, Surface


@pytest.fixture(scope="module")
def fields():
    return scene_fields(*can_estimate()[:2], can_estimate()[2])


def test_resampled_grids_agree_with_exact_ones_to_a_fifth_of_a_millimetre(fields):
    candidates = poses_around_the_can(8)
    grids = sample_grids(fields, candidates.X_WH).numpy()
    exact = np.stack([exact_grid(*can_estimate(), X_WH) for X_WH in candidates.X_WH])
    error_m = BOUND_M * np.abs(grids - exact)
    assert error_m.mean() < 2e-4
    assert error_m.max() < 0.008  # at the edges where distance to points bends


def test_the_compiled_sampler_gives_what_torch_gives(fields):
    X_WH = poses_around_the_can(5).X_WH
    half = (np.array(fields.values.shape[1:]) - 1) * fields.spacing / 2
    p_W = voxel_centers() @ X_WH[:, :3, :3].swapaxes(1, 2) + X_WH[:, None, :3, 3]
    places = torch.from_numpy((p_W - fields.origin - half) / half).float().flip(-1)
    outside = (places.abs() > 0.999).any(dim=-1).reshape(5, VOXELS, VOXELS, VOXELS)
    volume = torch.from_numpy(fields.values)[None].expand(5, -1, -1, -1, -1)
    peer = torch.nn.functional.grid_sample(
        volume, places.reshape(5, VOXELS, VOXELS, VOXELS, 3), align_corners=True
    )
    ours = sample_grids(fields, X_WH)
    inside = ~outside[:, None].expand_as(ours)
    torch.testing.assert_close(ours[inside], peer[inside], atol=2e-5, rtol=0)


def test_a_pose_along_the_axes_is_sampled_too(fields):
    X_WH = np.eye(4)[None].copy()
    X_WH[0, :3, 3] = fields.center
    grid = sample_grids(fields, X_WH).numpy()[0]
    assert np.isfinite(grid).all()
    np.testing.assert_allclose(grid, exact_grid(*can_estimate(), X_WH[0]), atol=0.15)


def test_far_from_the_object_all_voxels_are_at_the_bound(fields):
    X_WH = np.eye(4)[None].copy()
    X_WH[0, :3, 3] = [5.0, 5.0, 5.0]
    np.testing.assert_array_equal(sample_grids(fields, X_WH).numpy(), 1.0)


def test_a_rigid_motion_of_scene_and_hand_leaves_the_grid_as_it_is():
    view, contacts, surface = can_estimate()
    X_WH = poses_around_the_can(1).X_WH[0]
    move = np.eye(4)
    move[:3, 3] = [0.05, -0.02, 0.01]
    # A shift only: the potential's grid cannot be turned.
    moved = Surface(
        surface.vertices + move[:3, 3],
        surface.faces,
        surface.normals,
        surface.variance,
        ScalarGrid(
            surface.potential.origin + move[:3, 3],
            surface.potential.spacing,
            surface.potential.values,
        ),
    )
    there = ObjectView(view.p_WO + move[:3, 3], view.n_WO, view.table, view.p_WCamera)
    touched = ContactSet(contacts.p_WC + move[:3, 3], contacts.n_WC)
    np.testing.assert_allclose(
        exact_grid(there, touched, moved, move @ X_WH),
        exact_grid(view, contacts, surface, X_WH),
        atol=1e-6,
    )


def test_the_first_channel_is_zero_at_points_and_contacts():
    view, contacts, surface = can_estimate()
    for point in (view.p_WO[10], contacts.p_WC[0]):
        X_WH = np.eye(4)
        X_WH[:3, :3] = Rotation.random(random_state=1).as_matrix()
        corner = voxel_centers()[0]
        X_WH[:3, 3] = point - X_WH[:3, :3] @ corner
        assert exact_grid(view, contacts, surface, X_WH)[0].ravel()[0] < 1e-6


def test_voxels_are_centred_on_the_hand():
    centers = voxel_centers()
    np.testing.assert_allclose(centers.mean(axis=0), 0.0, atol=1e-12)
    np.testing.assert_allclose(np.ptp(centers, axis=0), SIDE_M * (VOXELS - 1) / VOXELS)


def test_pose_numbers_are_relative_to_the_object_and_hold_the_hints(fields):
    candidates = poses_around_the_can(3)
    blind = pose_inputs(fields, candidates)
    assert blind.shape == (3, NUMBERS)
    np.testing.assert_array_equal(blind[:, -HINT_NUMBERS:], 0.0)
    offset = (candidates.X_WH[:, :3, 3] - fields.center) / 0.1
    np.testing.assert_allclose(blind[:, [3, 7, 11]], offset, rtol=1e-5)
    samples = np.full(3, 20)
    closed = np.array([False, True, True])
    hints = Hints(
        np.array([0.0, 0.5, 1.0]),
        samples,
        closed,
        *[np.zeros(3)] * 2,
        np.zeros((3, 3)),
        (),
        *[np.zeros(3)] * 3,
    )
    hinted = pose_inputs(fields, candidates, hints)
    np.testing.assert_array_equal(hinted[:, :-HINT_NUMBERS], blind[:, :-HINT_NUMBERS])
    flag, odds = hinted[:, -HINT_NUMBERS], hinted[:, 1 - HINT_NUMBERS]
    np.testing.assert_array_equal(flag, 1.0)
    assert odds[0] == -odds[2] < 0
    assert odds[1] == 0


def test_a_scene_without_surface_or_points_is_refused():
    view, contacts, surface = can_estimate()
    with pytest.raises(BadInput, match="surface is empty"):
        scene_fields(view, contacts, Surface())
    with pytest.raises(BadInput, match="neither camera points nor contacts"):
        scene_fields(ObjectView(table=Plane()), ContactSet(), surface)


def test_no_candidates_give_no_numbers(fields):
    assert pose_inputs(fields, Candidates()).shape == (0, NUMBERS)
    assert sample_grids(fields, np.zeros((0, 4, 4))).shape == (0, 2, VOXELS, VOXELS, VOXELS)
