import dataclasses as dc
import math

import numpy as np
import pytest
import trimesh

from vh_drake.errors import BadInput
from vh_drake.exploration.loop import make_body
from vh_drake.exploration.stopping import (
    ErrorModel,
    StoppingSettings,
    at_radius,
    border_share,
    bound_m,
    explore_to,
    features,
    is_explored,
    refinements,
)
from vh_drake.geometry.closest_points import closest_points
from vh_drake.geometry.meshes import from_trimesh
from vh_drake.gpis.following import Sheet

BALL = make_body(from_trimesh(trimesh.creation.icosphere(4, 0.03)), np.zeros(3))
FEW = StoppingSettings(most_touches=40)


@pytest.fixture(scope="module")
def steps():
    return list(refinements(BALL, FEW, seed=0))


def test_a_ball_is_as_accurate_as_wanted_when_the_explorer_stops():
    for wanted in (0.002, 0.005):
        stopped = explore_to(BALL, wanted, FEW, seed=1)
        assert stopped.met
        p = stopped.last.sheet.vertices
        error = np.linalg.norm(closest_points(BALL.tree, p) - p, axis=1).mean()
        assert error <= wanted
        assert stopped.last.bound_m <= wanted


def test_a_finer_accuracy_takes_at_least_as_many_touches():
    touches = [explore_to(BALL, w, FEW, seed=2).last.touches for w in (0.01, 0.003, 0.0015)]
    assert touches == sorted(touches)


def test_what_cant_be_met_is_said():
    stopped = explore_to(BALL, 1e-6, dc.replace(FEW, most_touches=12), seed=0)
    assert not stopped.met
    assert "0.001 mm can't be met: after 12 touches" in stopped.reason


def test_the_explorer_never_stops_within_the_first_round(steps):
    for step in steps:
        assert math.isinf(step.bound_m) == (step.round == 0)
    assert [step.round for step in steps] == sorted(step.round for step in steps)
    assert [step.touches for step in steps] == list(range(1, len(steps) + 1))


def test_rounds_end_where_hardly_anything_is_far_from_all_contacts(steps):
    after = next(step for step in steps if step.round > 0)
    assert is_explored(after.known, FEW, FEW.radii_m[0])
    first = steps[0]
    assert not is_explored(first.known, FEW, FEW.radii_m[0])


def test_the_bound_falls_as_the_estimate_gets_better(steps):
    bounds = [step.bound_m for step in steps if step.round > 0]
    assert bounds[-1] < bounds[0]


def test_each_round_looks_closer():
    radii = [at_radius(FEW, i).explored_radius_m for i in range(len(FEW.radii_m))]
    assert radii == sorted(radii, reverse=True)
    assert all(at_radius(FEW, i).fresh_m == r for i, r in enumerate(radii))


def test_the_bound_is_the_formula():
    x = np.array([1.0, math.log(2.0), math.log(0.01)])
    model = ErrorModel((0.1, 2.0, 1.0), 3.0)
    expected = 3.0 * math.exp(0.1) * 2.0**2 * 0.01
    assert bound_m(x, model) == pytest.approx(1e-3 * expected)


def test_the_border_of_closed_and_open_surfaces():
    ball = trimesh.creation.icosphere(1)
    assert border_share(Sheet(ball.vertices, ball.vertices, ball.faces)) == 0.0
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    assert border_share(Sheet(square, square, faces)) == pytest.approx(4 / 5)


def test_an_empty_estimate_promises_nothing():
    x = features(Sheet(), [0.001])
    assert bound_m(x, ErrorModel()) > 0.1


@pytest.mark.parametrize("wanted", [0.0, -1.0, math.nan, math.inf])
def test_an_accuracy_that_is_none_is_refused(wanted):
    with pytest.raises(BadInput, match="accuracy"):
        explore_to(BALL, wanted)
