import numpy as np
import pytest
from learning_scenes import FAST

from vh_drake.geometry.signed_distance import interpolate
from vh_drake.learning.generating import seen_scene
from vh_drake.learning.touches import KinematicTouchSettings, approach_direction, explore, feel
from vh_drake.learning.training_objects import object_mesh
from vh_drake.types import ObjectView, Plane, TouchPlan

EXACT = KinematicTouchSettings(position_std_m=0.0, normal_std_deg=0.0)


@pytest.fixture(scope="module")
def seen():
    return seen_scene(object_mesh("can", None), FAST, np.random.default_rng(4), touches=0)


def test_exact_touches_lie_on_the_object_and_on_its_hidden_side(seen):
    contacts = explore(seen.view, seen.field, 2, np.random.default_rng(0), EXACT)
    assert len(contacts) >= 1
    distance, gradient = interpolate(seen.field.distance, contacts.p_WC)
    assert np.abs(distance).max() < 0.002
    assert np.einsum("ij,ij->i", contacts.n_WC, gradient).min() > 0.9
    away = contacts.p_WC[0] - seen.field.center
    assert away @ (seen.view.p_WCamera - seen.field.center) < 0


def test_errors_of_the_sensor_have_the_size_that_was_asked_for(seen):
    rng = np.random.default_rng(1)
    way = np.array([-1.0, 0.0, 0.0])
    target = seen.field.center + np.array([0.03, 0.0, 0.0])
    settings = KinematicTouchSettings()
    exact = feel(target, way, seen.field, EXACT, rng)
    felt = [feel(target, way, seen.field, settings, rng) for _ in range(400)]
    error = np.array([p for p, _ in felt]) - exact[0]
    np.testing.assert_allclose(error.std(axis=0), settings.position_std_m, rtol=0.15)
    cosines = np.array([n @ exact[1] for _, n in felt])
    angle = np.rad2deg(np.arccos(np.clip(cosines, -1, 1)))
    # Two of the three turns tilt the normal.
    assert np.sqrt((angle**2).mean() / 2) == pytest.approx(settings.normal_std_deg, rel=0.15)


def test_a_way_that_passes_the_object_feels_nothing(seen):
    past = seen.field.center + np.array([0.0, 0.3, 0.0])
    assert feel(past, np.array([-1.0, 0, 0]), seen.field, EXACT, np.random.default_rng(0)) is None


def test_undercut_places_are_approached_level():
    view = ObjectView(table=Plane())
    n = np.array([0.8, 0.0, -0.6])
    way = approach_direction(TouchPlan(n_WT=n), view)
    np.testing.assert_allclose(way, [-1.0, 0.0, 0.0])
    up = np.array([0.6, 0.0, 0.8])
    np.testing.assert_allclose(approach_direction(TouchPlan(n_WT=up), view), -up)
