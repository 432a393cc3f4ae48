import dataclasses as dc

import numpy as np
import pytest
import trimesh

from vh_drake.errors import BadInput
from vh_drake.exploration.explorer import ExplorerSettings
from vh_drake.exploration.kinematic_tip import move_along
from vh_drake.exploration.loop import EndSettings, explore, make_body
from vh_drake.geometry.meshes import from_trimesh
from vh_drake.objects import lathe
from vh_drake.objects.library import library_object
from vh_drake.scenes.fingertip import FingertipSettings, centre_way, make_fingertip, touch
from vh_drake.sensing.tactile import TactileSettings

MESHES = {
    "sphere": lambda: lathe.sphere(0.03),
    "box": lambda: lathe.box((0.06, 0.05, 0.03)),
    "banana": lambda: library_object("banana").mesh,
}
FAST = FingertipSettings(speed_m_s=0.05)
DOWN = np.linspace([0.0, 0.0, 0.05], [0.0, 0.0, 0.03], 4)  # straight onto a ball of 3 cm


@pytest.fixture(scope="module")
def ball():
    return from_trimesh(trimesh.creation.icosphere(3, 0.03))


@pytest.mark.slow
@pytest.mark.parametrize("name", MESHES)
def test_the_fingertip_in_drake_touches_where_the_kinematic_one_does(name):
    mesh = MESHES[name]()
    body = make_body(mesh, mesh.vertices.mean(axis=0))
    result = explore(body, ExplorerSettings(), EndSettings(most_touches=3), seed=0)
    for step in result.steps:
        known = step.touch
        found = touch(make_fingertip(mesh, known.curves, known.n_WC, FAST))
        assert found.touched
        assert np.linalg.norm(found.p_WC - known.p_WC) < 0.001
        assert found.n_WC @ known.n_WC > np.cos(np.radians(5.0))


def test_a_ball_is_touched_on_top_and_at_the_right_time(ball):
    kinematic = move_along(make_body(ball, np.zeros(3)).tree, DOWN, radius_m=FAST.radius_m)
    found = touch(make_fingertip(ball, DOWN[None], [0.0, 0.0, 1.0], FAST))
    np.testing.assert_allclose(found.p_WC, kinematic.p_WC, atol=2e-4)
    np.testing.assert_allclose(found.n_WC, [0, 0, 1], atol=0.02)
    assert found.time_s == pytest.approx(kinematic.length_m / FAST.speed_m_s, abs=0.02)


def test_a_way_beside_the_object_touches_nothing(ball):
    aside = DOWN + np.array([0.036, 0.0, 0.0])
    found = touch(make_fingertip(ball, aside[None], [0.0, 0.0, 1.0], FAST))
    assert not found.touched
    np.testing.assert_allclose(found.p_WTip, aside[-1] - [0, 0, FAST.beyond_m], atol=2e-3)


def test_the_tip_may_leave_what_it_touches(ball):
    away = DOWN[::-1] + np.array([0.0, 0.0, 0.005])
    assert not touch(make_fingertip(ball, away[None], [0.0, 0.0, 1.0], FAST)).touched


def test_the_tactile_sensor_feels_the_same_place_later(ball):
    settings = dc.replace(FAST, speed_m_s=0.02)
    wanted = touch(make_fingertip(ball, DOWN[None], [0.0, 0.0, 1.0], settings))
    scenes = [
        make_fingertip(ball, DOWN[None], [0, 0, 1.0], settings, tactile=TactileSettings(), seed=i)
        for i in (1, 1, 2)
    ]
    first, again, other = [touch(scene) for scene in scenes]
    assert first.touched
    assert other.touched
    assert first.time_s > wanted.time_s
    np.testing.assert_array_equal(first.n_WC, again.n_WC)
    assert not np.array_equal(first.n_WC, other.n_WC)
    assert np.linalg.norm(first.p_WC - wanted.p_WC) < 0.002


def test_the_way_has_constant_speed_and_goes_on_behind_its_end():
    curves = np.stack([DOWN, DOWN - [0.0, 0.0, 0.02]])
    way = centre_way(curves, FAST)
    assert way.end_time() == pytest.approx((0.04 + FAST.beyond_m) / FAST.speed_m_s, rel=1e-6)
    for time in np.linspace(0.01, way.end_time() - 0.01, 7):
        speed = np.linalg.norm(way.EvalDerivative(time, 1))
        assert speed == pytest.approx(FAST.speed_m_s, rel=1e-6)


@pytest.mark.parametrize(
    ("curves", "settings"),
    [
        (np.zeros((0, 4, 3)), FAST),
        (np.zeros((1, 4, 3)), FAST),
        (DOWN[None], FingertipSettings(radius_m=0.0)),
        (DOWN[None], FingertipSettings(speed_m_s=-1.0)),
    ],
)
def test_what_leads_nowhere_is_refused(curves, settings):
    with pytest.raises(BadInput):
        centre_way(curves, settings)
