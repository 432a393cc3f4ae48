from dataclasses import replace

import numpy as np
import pytest
import trimesh
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix

from vh_drake.errors import UnknownName
from vh_drake.exploration.next_touch import (
    TouchSettings,
    departure_direction,
    facing_camera,
    plan_touch,
)
from vh_drake.types import ContactSet, ObjectView, Plane, Surface

P_CAMERA = np.array([0.21, 0.0, 1.82])
STRICT = TouchSettings(tiers=TouchSettings().tiers[:1])
TIP = RigidTransform(RotationMatrix(RollPitchYaw(np.pi / 2, 0, 0)), [0.6, -0.6, 1.1])


def can(radius=0.04, height=0.14):
    """An estimated surface of a can that stands on the table, and the camera's view of it."""
    mesh = trimesh.creation.cylinder(radius, height, sections=60)
    for _ in range(3):
        mesh = mesh.subdivide()
    mesh.apply_translation([0.7, -0.3, 0.9 + height / 2])
    n = np.array(mesh.vertex_normals)
    p = np.array(mesh.vertices)
    variance = np.linalg.norm(p - P_CAMERA, axis=1)
    seen = np.einsum("ij,ij->i", n, P_CAMERA - p) > 0
    surface = Surface(p, np.array(mesh.faces, np.int64), n, variance)
    return surface, ObjectView(p[seen], n[seen], Plane(np.array([0, 0, 1.0]), 0.9), P_CAMERA)


def facing_of(plan):
    to_camera = P_CAMERA - plan.p_WT
    return plan.n_WT @ to_camera / np.linalg.norm(to_camera)


@pytest.mark.parametrize("strategy", ["igef", "gp_variance", "random"])
def test_every_plan_touches_where_the_camera_does_not_see(strategy):
    surface, view = can()
    plans = plan_touch(surface, view, ContactSet(), TIP, None, replace(STRICT, strategy=strategy))
    assert len(plans) > 10
    for plan in plans:
        assert facing_of(plan) < -0.25
        assert 0.93 - 1e-9 <= plan.p_WT[2] <= 0.9 + 0.75 * 0.14 + 1e-9
        assert abs(plan.n_WT[2]) <= 0.5
        np.testing.assert_allclose(plan.control_points[3], plan.p_WT)


def test_plans_are_ranked_and_apart():
    surface, view = can()
    plans = plan_touch(surface, view, ContactSet(), TIP, None, STRICT)
    ratings = [plan.rating for plan in plans]
    assert ratings == sorted(ratings, reverse=True)
    p = np.array([plan.p_WT for plan in plans])
    gaps = np.linalg.norm(p[:, None] - p[None], axis=2) + np.eye(len(p))
    assert gaps.min() >= 0.01


def test_flat_object_is_touched_lower_instead_of_never():
    surface, view = can(height=0.025)
    plans = plan_touch(surface, view, ContactSet(), TIP, None)
    assert plans
    assert all(facing_of(plan) < -0.1 for plan in plans)


def test_places_of_relaxed_limits_come_after_all_strict_ones():
    surface, view = can()
    strict = plan_touch(surface, view, ContactSet(), TIP, None, STRICT)
    relaxed = plan_touch(surface, view, ContactSet(), TIP, None)
    assert len(relaxed) > len(strict)
    np.testing.assert_array_equal(
        [p.p_WT for p in relaxed[: len(strict)]], [p.p_WT for p in strict]
    )


def test_only_feasible_plans_are_given_in_their_order():
    surface, view = can()
    everything = plan_touch(
        surface, view, ContactSet(), TIP, None, replace(TouchSettings(), most_plans=999)
    )
    some = plan_touch(
        surface, view, ContactSet(), TIP, None, feasible=lambda plan: plan.p_WT[1] > -0.3
    )
    expected = [plan.p_WT for plan in everything if plan.p_WT[1] > -0.3]
    np.testing.assert_allclose([plan.p_WT for plan in some], expected[: len(some)])
    assert plan_touch(surface, view, ContactSet(), TIP, None, feasible=lambda plan: False) == ()


def test_next_touch_keeps_its_distance_from_the_last_one():
    surface, view = can()
    first = plan_touch(surface, view, ContactSet(), TIP, None)[0]
    contacts = ContactSet(first.p_WT[None], first.n_WT[None])
    second = plan_touch(surface, view, contacts, TIP, np.array([0, 0.05, 0.0]))[0]
    assert 0.02 < np.linalg.norm(second.p_WT - first.p_WT) < 0.06


def test_weight_of_the_hidden_side_draws_the_touch_away_from_the_camera():
    surface, view = can()
    beside = RigidTransform(RotationMatrix(RollPitchYaw(-np.pi / 2, 0, 0)), [0.68, -0.5, 1.0])
    plain, hidden = (
        plan_touch(surface, view, ContactSet(), beside, None, replace(STRICT, hidden_power=power))[
            0
        ]
        for power in (0.0, 50.0)
    )
    assert facing_of(hidden) < facing_of(plain)


def test_variance_strategy_takes_the_least_certain_place():
    surface, view = can()
    settings = replace(STRICT, strategy="gp_variance")
    best = plan_touch(surface, view, ContactSet(), TIP, None, settings)[0]
    allowed = plan_touch(
        surface,
        view,
        ContactSet(),
        TIP,
        None,
        replace(settings, apart_m=0.0, most_plans=9999),
    )
    assert best.rating == max(plan.rating for plan in allowed)


def test_random_strategy_repeats_with_its_seed():
    surface, view = can()
    runs = [
        plan_touch(surface, view, ContactSet(), TIP, None, TouchSettings("random", seed=seed))[0]
        for seed in (1, 1, 2)
    ]
    np.testing.assert_array_equal(runs[0].p_WT, runs[1].p_WT)
    assert np.linalg.norm(runs[0].p_WT - runs[2].p_WT) > 0


def test_candidate_radius_limits_the_distance():
    surface, view = can()
    near = RigidTransform([0.74, -0.34, 0.97])
    plans = plan_touch(
        surface, view, ContactSet(), near, None, TouchSettings(candidate_radius_m=0.05)
    )
    assert plans
    assert all(np.linalg.norm(plan.p_WT - near.translation()) <= 0.05 for plan in plans)


def test_departure_follows_the_chosen_rule():
    contacts = ContactSet(np.zeros((1, 3)), np.array([[0, 0, 1.0]]))
    v = np.array([0.0, -0.05, 0.0])
    np.testing.assert_allclose(departure_direction(contacts, v, "inverse_velocity"), [0, 1, 0])
    np.testing.assert_allclose(departure_direction(contacts, v, "contact_normal"), [0, 0, 1])
    assert departure_direction(ContactSet(), None, "contact_normal") is None


def test_facing_is_the_cosine_to_the_camera():
    surface, view = can()
    direction = (P_CAMERA - surface.vertices) / np.linalg.norm(
        P_CAMERA - surface.vertices, axis=1, keepdims=True
    )
    cosine = np.sum(direction * surface.normals, axis=1)
    upward = surface.normals[:, 2] >= 0
    np.testing.assert_allclose(facing_camera(surface, view)[upward], cosine[upward])
    # Undercut places count as level, and so as less hidden than they are.
    assert (facing_camera(surface, view)[~upward] >= cosine[~upward] - 1e-12).all()


def test_unknown_strategy_lists_the_choices():
    surface, view = can()
    with pytest.raises(UnknownName, match="gp_variance, igef, random"):
        plan_touch(surface, view, ContactSet(), TIP, None, TouchSettings("greedy"))
    with pytest.raises(UnknownName, match="contact_normal, inverse_velocity"):
        plan_touch(surface, view, ContactSet(), TIP, None, TouchSettings(departure="up"))


def test_unknown_surface_gives_no_plan():
    assert plan_touch(Surface(), can()[1], ContactSet(), TIP, None) == ()
