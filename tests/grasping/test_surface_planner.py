import dataclasses as dc

import numpy as np
import pytest
import trimesh

from vh_drake.errors import BadInput
from vh_drake.grasping.closing import close_hand
from vh_drake.grasping.field import object_field
from vh_drake.grasping.motions import motion_of
from vh_drake.grasping.surface_planner import PlannerSettings, plan_candidates
from vh_drake.types import Candidates, Surface

SETTINGS = PlannerSettings(candidates=60, draws=150)


def brick():
    return trimesh.creation.box([0.05, 0.08, 0.05]).subdivide()


def bottle():
    return trimesh.creation.cylinder(0.035, 0.19).subdivide()


@pytest.mark.parametrize(("mesh", "motion"), [(brick(), "collect"), (bottle(), "side")])
def test_tall_objects_are_taken_from_the_side_and_low_ones_collected(
    hand, table, standing, mesh, motion
):
    candidates = plan_candidates(standing(mesh.copy()), table, hand, SETTINGS, 0)
    assert len(candidates) == 60
    assert set(candidates.motion) == {motion}
    assert set(candidates.planner) == {"surface"}


@pytest.mark.parametrize("mesh", [brick(), bottle()])
def test_every_candidate_starts_free_and_most_touch(hand, table, standing, mesh):
    surface = standing(mesh.copy())
    field = object_field(surface, table)
    candidates = plan_candidates(surface, table, hand, SETTINGS, 1)
    closures = [
        close_hand(hand, field, motion_of(motion, hand, SETTINGS.collect), X)
        for X, motion in zip(candidates.X_WH, candidates.motion, strict=True)
    ]
    assert all(closure.started_free for closure in closures)
    assert np.mean([len(closure.links) >= 3 for closure in closures]) > 0.8


def test_collecting_hands_start_just_over_the_table_or_up_to_30_mm_higher(hand, table, standing):
    candidates = plan_candidates(standing(brick()), table, hand, SETTINGS, 2)
    centers, radii = hand.spheres(hand.lower)
    for X in candidates.X_WH:
        lowest = (centers @ X[2, :3] + X[2, 3] - radii).min() - 0.9
        assert 0.004 - 1e-9 <= lowest <= 0.034 + 1e-9


def test_side_grasps_have_the_thumb_up_and_level_fingers(hand, table, standing):
    candidates = plan_candidates(standing(bottle()), table, hand, SETTINGS, 3)
    np.testing.assert_allclose(candidates.X_WH[:, 2, 1], -1, atol=1e-9)
    np.testing.assert_allclose(candidates.X_WH[:, 2, 2], 0, atol=1e-9)
    assert (candidates.X_WH[:, 2, 3] >= 0.9 + 0.065 - 1e-9).all()


def test_poses_are_rigid(hand, table, standing):
    for mesh in (brick(), bottle()):
        R = plan_candidates(standing(mesh), table, hand, SETTINGS, 4).X_WH[:, :3, :3]
        np.testing.assert_allclose(R @ R.swapaxes(1, 2), np.tile(np.eye(3), (60, 1, 1)), atol=1e-9)
        np.testing.assert_allclose(np.linalg.det(R), 1)


def test_the_same_seed_gives_the_same_candidates(hand, table, standing):
    one, other, third = (
        plan_candidates(standing(brick()), table, hand, SETTINGS, seed) for seed in (5, 5, 6)
    )
    np.testing.assert_array_equal(one.X_WH, other.X_WH)
    assert not np.array_equal(one.X_WH, third.X_WH)


def test_what_is_too_wide_for_the_hand_gets_no_candidates(hand, table, standing):
    crate = standing(trimesh.creation.box([0.3, 0.3, 0.15]))
    none: Candidates = plan_candidates(crate, table, hand, SETTINGS, 0)
    assert len(none) == 0


def test_candidates_come_from_all_around(hand, table, standing):
    X_WH = plan_candidates(standing(brick()), table, hand, SETTINGS, 7).X_WH
    headings = np.arctan2(X_WH[:, 1, 2], X_WH[:, 0, 2])
    assert (np.histogram(headings, 6, (-np.pi, np.pi))[0] > 0).all()


def test_an_empty_surface_gets_no_plan(hand, table):
    with pytest.raises(BadInput, match="empty"):
        plan_candidates(Surface(), table, hand, SETTINGS, 0)


def test_settings_that_ask_for_nothing_are_refused(hand, table, standing):
    settings = dc.replace(SETTINGS, candidates=0)
    with pytest.raises(BadInput, match="must be positive"):
        plan_candidates(standing(brick()), table, hand, settings, 0)
