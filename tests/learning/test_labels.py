import dataclasses as dc

import numpy as np
import pytest
from learning_scenes import FAST, can_scene
from scenery import right_hand

from vh_drake.grasping.closing import close_hand
from vh_drake.grasping.closure_rate import closure_rates
from vh_drake.grasping.motions import CollectSettings, motion_of
from vh_drake.grasping.wrench_space import ContactSettings, is_force_closure, wrench_matrix
from vh_drake.learning.generating import seen_scene
from vh_drake.learning.labels import (
    LabelSettings,
    guarded_rates,
    nominal_closure,
    nominal_epsilon,
    start_poses,
)
from vh_drake.learning.training_objects import object_mesh


@pytest.fixture(scope="module")
def seen():
    mesh = object_mesh("can", None)
    return seen_scene(mesh, FAST, np.random.default_rng([0, 0, 0]), touches=1)


@pytest.fixture(scope="module")
def candidates():
    return can_scene().candidates


def test_the_hand_starts_out_along_its_palm(candidates):
    hand = right_hand()
    starts = start_poses(candidates.X_WH, hand, 0.03)
    way = candidates.X_WH[:, :3, 3] - starts[:, :3, 3]
    palm = candidates.X_WH[:, :3, :3] @ np.asarray(hand.description.palm)
    np.testing.assert_allclose(np.linalg.norm(way, axis=1), 0.03)
    assert (np.einsum("ni,ni->n", way, palm) > 0).all()
    np.testing.assert_array_equal(starts[:, :3, :3], candidates.X_WH[:, :3, :3])


def test_rates_are_those_of_each_motion_by_itself(seen, candidates):
    hand, settings = right_hand(), LabelSettings(min_samples=6, max_samples=6)
    rates = guarded_rates(candidates, seen.field, hand, settings, 3)
    for name in set(candidates.motion):
        own = np.array([motion == name for motion in candidates.motion])
        direct = closure_rates(
            hand,
            seen.field,
            motion_of(name, hand, CollectSettings()),
            start_poses(candidates.X_WH[own], hand, settings.guarded_m),
            perturbation=settings.perturbation(),
            contact=ContactSettings(friction=settings.friction),
            seed=3 + len(name),
        )
        np.testing.assert_allclose(rates.rate[own], direct.rate)
        np.testing.assert_allclose(rates.standard_error[own], direct.standard_error)


def test_the_nominal_metric_is_the_closure_of_an_undisturbed_hand(seen, candidates):
    hand, settings = right_hand(), LabelSettings()
    nominal = nominal_closure(candidates, seen.estimate, hand, settings)
    for i in range(0, len(candidates), 5):
        closure = close_hand(
            hand,
            seen.estimate,
            motion_of(candidates.motion[i], hand, CollectSettings()),
            start_poses(candidates.X_WH[i : i + 1], hand, settings.guarded_m)[0],
            palm_advance_m=settings.guarded_m,
        )
        W = wrench_matrix(
            closure.p_WC,
            closure.n_WC,
            center=seen.estimate.center,
            size_m=seen.estimate.size_m,
            settings=ContactSettings(friction=settings.friction),
        )
        assert nominal[i] == (len(closure.links) >= 3 and is_force_closure(W))


def test_epsilon_is_positive_where_the_undisturbed_hand_closes_and_nowhere_else(seen, candidates):
    hand, settings = right_hand(), LabelSettings()
    nominal = nominal_closure(candidates, seen.estimate, hand, settings)
    epsilon = nominal_epsilon(candidates, seen.estimate, hand, settings)
    assert nominal.any()
    assert ((epsilon > 0) <= nominal).all()
    assert np.mean((epsilon > 0) == nominal) > 0.9  # Qhull may find a hull flat.


def test_without_a_guarded_approach_disturbed_hands_start_in_collision(seen, candidates):
    hand = right_hand()
    guarded = LabelSettings(min_samples=20, max_samples=20)
    blunt = dc.replace(guarded, guarded_m=0.0)
    gentle_rate = guarded_rates(candidates, seen.field, hand, guarded, 0).rate.mean()
    blunt_rate = guarded_rates(candidates, seen.field, hand, blunt, 0).rate.mean()
    assert gentle_rate > blunt_rate
