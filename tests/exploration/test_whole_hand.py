import itertools

import numpy as np
import pytest
import trimesh

from vh_drake.exploration.explorer import ExplorerSettings
from vh_drake.exploration.loop import EndSettings, begin, make_body
from vh_drake.exploration.whole_hand import (
    Hand,
    HandAim,
    HandContacts,
    WholeHandSettings,
    after_closing,
    explore_by_hand,
    plan_closing,
    poses,
)
from vh_drake.geometry.meshes import from_trimesh

RADIUS_M = 0.04
BODY = make_body(from_trimesh(trimesh.creation.icosphere(4, RADIUS_M)), np.zeros(3))
SETTINGS = ExplorerSettings()
AIM = HandAim(
    approaches=np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]),
    along=np.array([0.6, 0.0, 0.8]),
    places=np.array([[0.0, 0.0, 0.0], [0.01, 0.02, 0.05]]),
)
FEW = WholeHandSettings(targets=6, rolls=3)


def rake(X_WH, approach_H):
    """Three parallel fingers, 2 cm apart, that touch a ball around the origin head on."""
    side = np.cross(approach_H, [0.0, 1.0, 0.0])
    origins = X_WH[:3, 3] + np.outer([-0.02, 0.0, 0.02], X_WH[:3, :3] @ side)
    v = X_WH[:3, :3] @ approach_H
    along = origins @ v
    room = RADIUS_M**2 - np.sum(origins**2, axis=1) + along**2
    hit = room > 0
    p = origins[hit] + (-along[hit] - np.sqrt(room[hit]))[:, None] * v
    return HandContacts(p, p / RADIUS_M)


def nothing(X_WH, approach_H):
    return HandContacts()


RAKE = Hand(lambda _: rake, AIM, FEW)


def test_poses_come_against_the_normal_with_a_place_of_the_hand_over_the_target():
    n = np.array([2.0, -1.0, 2.0]) / 3.0
    p = np.array([0.1, 0.2, 0.3])
    found = poses(p, n, AIM, FEW)
    assert len(found) == 2 * 2 * 3
    for i, (X_WH, approach) in enumerate(found):
        R = X_WH[:3, :3]
        np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(R) == pytest.approx(1.0)
        np.testing.assert_allclose(R @ approach, -n, atol=1e-12)
        over = X_WH[:3, 3] + R @ AIM.places[i % 2]
        np.testing.assert_allclose(over, p + FEW.back_off_m * n, atol=1e-12)


def test_poses_of_one_place_and_approach_differ_by_even_turns():
    found = [X for X, _ in poses(np.zeros(3), np.array([0.0, 0.0, 1.0]), AIM, FEW)][:6:2]
    for a, b in itertools.pairwise(found):
        cosine = 0.5 * (np.trace(a[:3, :3].T @ b[:3, :3]) - 1.0)
        assert cosine == pytest.approx(np.cos(2.0 * np.pi / FEW.rolls))


def test_several_fingertips_need_fewer_motions_than_one():
    result = explore_by_hand(BODY, rake, RAKE, SETTINGS, seed=0)
    assert result.end == "goal"
    assert np.mean([m.contacts for m in result.motions if m.closing]) > 1.5
    assert result.share == result.motions[-1].share
    assert len(result.known.contacts) == 1 + sum(motion.contacts for motion in result.motions)
    assert [m.share for m in result.motions] == sorted(m.share for m in result.motions)
    assert len(result.motions) < 15


def test_a_hand_that_never_touches_leaves_it_to_one_finger():
    end = EndSettings(goal=0.6)
    result = explore_by_hand(BODY, nothing, RAKE, SETTINGS, end, seed=0)
    assert result.end == "goal"
    assert [motion.closing for motion in result.motions[:3]] == [True, True, False]
    assert all(m.contacts == (0 if m.closing else 1) for m in result.motions)


def test_what_was_written_off_is_not_aimed_at_again():
    known, _ = begin(BODY, SETTINGS, seed=0)
    first = plan_closing(known, RAKE, SETTINGS, np.zeros((0, 3)))
    again = plan_closing(known, RAKE, SETTINGS, first.expected.p_WC)
    assert not np.allclose(first.X_WH, again.X_WH)


def test_nothing_is_planned_where_nothing_would_be_touched():
    known, _ = begin(BODY, SETTINGS, seed=0)
    assert (
        plan_closing(known, Hand(lambda _: nothing, AIM, FEW), SETTINGS, np.zeros((0, 3))) is None
    )


def test_contacts_at_known_places_are_dropped():
    known, _ = begin(BODY, SETTINGS, seed=0)
    p, n = known.contacts.p_WC[0], known.contacts.n_WC[0]
    found = HandContacts(np.array([p, p + np.array([0, 0, 0.0005]), -p]), np.array([n, n, -n]))
    after = after_closing(known, found, SETTINGS)
    assert len(after.contacts) == 2
    assert len(after.set_aside) == 0


def test_the_same_seed_gives_the_same_exploration():
    runs = [explore_by_hand(BODY, rake, RAKE, SETTINGS, seed=3) for _ in "ab"]
    np.testing.assert_array_equal(runs[0].known.contacts.p_WC, runs[1].known.contacts.p_WC)
