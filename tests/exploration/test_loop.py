from dataclasses import replace

import numpy as np
import pytest
import trimesh

from vh_drake.errors import UnknownName
from vh_drake.exploration.choosing import choose_touch
from vh_drake.exploration.explorer import ExplorerSettings, Known
from vh_drake.exploration.loop import EndSettings, explore, make_body, slerp
from vh_drake.exploration.strategies import (
    GpVariance,
    Igef,
    PotentialField,
    Random,
    UncertaintyCost,
)
from vh_drake.exploration.tuned import tuned
from vh_drake.geometry.closest_points import closest_points
from vh_drake.geometry.meshes import from_trimesh
from vh_drake.gpis.observations import surface_observations
from vh_drake.gpis.posterior import fit
from vh_drake.types import ContactSet

BALL = make_body(from_trimesh(trimesh.creation.icosphere(4, 0.04)), np.zeros(3))
BOX = make_body(from_trimesh(trimesh.creation.box((0.1, 0.06, 0.04))), np.zeros(3))
EVERY = [Igef(), GpVariance(), Random(), UncertaintyCost(), PotentialField()]


@pytest.mark.parametrize("strategy", EVERY, ids=lambda s: type(s).__name__)
@pytest.mark.parametrize("body", [BALL, BOX], ids=["ball", "box"])
def test_every_strategy_explores_a_ball_and_a_box(body, strategy):
    result = explore(body, ExplorerSettings(strategy), seed=1)
    assert result.end == "goal"
    assert result.shares[-1] >= 0.8
    assert (np.diff(result.shares) >= 0).all()


def test_every_contact_lies_on_the_object():
    contacts = explore(BOX, seed=2).known.contacts
    nearest = closest_points(BOX.tree, contacts.p_WC)
    np.testing.assert_allclose(contacts.p_WC, nearest, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(contacts.n_WC, axis=1), 1.0)


def test_the_same_seed_gives_the_same_exploration():
    first, second = explore(BOX, seed=3), explore(BOX, seed=3)
    np.testing.assert_array_equal(first.known.contacts.p_WC, second.known.contacts.p_WC)
    np.testing.assert_array_equal(first.lengths_m, second.lengths_m)
    assert not np.array_equal(first.start.p_WTip, explore(BOX, seed=4).start.p_WTip)


def test_the_way_is_at_least_as_long_as_the_crow_flies():
    result = explore(BALL, seed=0)
    tips = np.array([result.start.p_WTip, *(step.known.p_WTip for step in result.steps)])
    assert (np.diff(result.lengths_m) >= np.linalg.norm(np.diff(tips, axis=0), axis=1) - 1e-9).all()


@pytest.mark.parametrize("strategy", ["igef", "gp_variance", "random"])
def test_a_handle_is_found_beyond_an_estimate_that_has_closed_around_its_root(strategy):
    handle = trimesh.creation.cylinder(0.006, 0.16, sections=24).apply_translation((0, 0, 0.08))
    knob = trimesh.creation.icosphere(3, 0.02)
    body = make_body(from_trimesh(trimesh.util.concatenate([knob, handle])), np.zeros(3))
    ends = [explore(body, tuned(strategy), seed=seed).end for seed in range(6)]
    assert ends.count("goal") >= 5


def test_what_gains_nothing_ends_the_exploration():
    end = EndSettings(goal=1.1, most_without_gain=3)
    assert explore(BALL, end=end, seed=0).end == "stuck"
    assert explore(BALL, end=EndSettings(most_touches=2), seed=0).end == "touches"


def test_a_missed_target_is_followed_by_a_contact_from_below():
    result = explore(BOX, seed=0)
    missed = [step.touch for step in result.steps if step.touch.missed]
    assert missed
    for touch in missed:
        assert len(touch.curves) == 2
        assert np.linalg.norm(touch.curves[1, 0] - touch.p_WT) < 0.03


def test_an_unknown_departure_names_the_choices():
    with pytest.raises(UnknownName, match="contact_normal"):
        explore(BALL, replace(ExplorerSettings(), departure="sideways"))


def test_slerp_turns_in_the_plane_of_both_vectors():
    a, b = np.array([1.0, 0, 0]), np.array([0.0, 1, 0])
    turned, angle = slerp(a, b, 0.5)
    np.testing.assert_allclose(turned, [np.sqrt(0.5), np.sqrt(0.5), 0])
    assert angle == pytest.approx(np.pi / 4)
    half, angle = slerp(a, -a, 1.0)
    np.testing.assert_allclose(half, -a, atol=1e-12)
    assert angle == pytest.approx(np.pi)
    np.testing.assert_allclose(slerp(a, a, 0.3)[0], a)


def test_after_barren_touches_the_next_target_lies_elsewhere():
    settings = replace(ExplorerSettings(), most_barren=1, leave_m=0.06)
    known = explore(BALL, settings, EndSettings(goal=0.6), seed=0).known
    choice = choose_touch(replace(known, barren=1), settings, seed=0)
    away = np.linalg.norm(choice.p - known.contacts.p_WC[-1], axis=1)
    assert away.min() > settings.leave_m
    assert len(choice.curves) > 1  # around the object
    # Farther than the whole ball there is nothing, so that all of it counts again.
    near = choose_touch(replace(known, barren=9), settings, seed=0)
    assert np.linalg.norm(near.p - known.contacts.p_WC[-1], axis=1).min() < settings.leave_m


def test_a_way_out_of_a_groove_leads_off_both_of_its_walls():
    """Two contacts face each other below the tip's centre; what is free is up."""
    walls = [np.array([1.0, 0.0, 0.2]), np.array([-1.0, 0.0, 0.2])]
    n = np.array([wall / np.linalg.norm(wall) for wall in walls])
    tip, settings = np.zeros(3), ExplorerSettings()
    contacts = ContactSet(tip - settings.tip_radius_m * n, n)
    seen = surface_observations(contacts.p_WC, n, value_std_m=5e-4, gradient_std=0.03)
    known = Known(fit(settings.kernel, seen), contacts, tip, n[1], n[1], np.zeros((0, 3)), 3)
    choice = choose_touch(known, settings, seed=0)
    leave = choice.curves[0, 1] - choice.curves[0, 0]
    assert (leave / np.linalg.norm(leave) @ n.T).min() > 0.1
