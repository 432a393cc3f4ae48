import numpy as np
import pytest
import trimesh

from vh_drake.experiments.hand_closing import (
    hand_aim,
    planned_hand,
    sheet_distance,
    true_closer,
)
from vh_drake.exploration.whole_hand import WholeHandSettings, poses
from vh_drake.geometry.meshes import from_trimesh
from vh_drake.gpis.following import Sheet
from vh_drake.hand.description import load_hand
from vh_drake.hand.model import read_hand_model
from vh_drake.hand.shipped import hand_file

RADIUS_M = 0.04
BALL = from_trimesh(trimesh.creation.icosphere(4, RADIUS_M))
SHEET = Sheet(BALL.vertices, BALL.vertices / RADIUS_M, BALL.faces)


@pytest.fixture(scope="module")
def hand():
    return read_hand_model(load_hand(hand_file()))


@pytest.fixture(scope="module")
def start(hand):
    n = np.array([0.0, 0.6, 0.8])
    return poses(RADIUS_M * n, n, hand_aim(hand), WholeHandSettings())[0]


def test_fingertips_touch_a_ball_on_its_surface(hand, start):
    found = true_closer(hand, BALL)(*start)
    assert 2 <= len(found.p_WC) <= 5
    np.testing.assert_allclose(np.linalg.norm(found.p_WC, axis=1), RADIUS_M, atol=1e-3)
    outward = np.einsum("ij,ij->i", found.n_WC, found.p_WC) / RADIUS_M
    assert (outward > 0.98).all()


def test_a_perfect_estimate_predicts_the_closing(hand, start):
    expected = planned_hand(hand).closer_on(SHEET)(*start)
    found = true_closer(hand, BALL)(*start)
    assert len(expected.p_WC) == len(found.p_WC)
    np.testing.assert_allclose(expected.p_WC, found.p_WC, atol=4e-3)


def test_a_hand_that_starts_inside_touches_nothing(hand):
    assert len(true_closer(hand, BALL)(np.eye(4), np.array([-1.0, 0.0, 0.0])).p_WC) == 0


def test_distances_around_a_closed_sheet_are_those_of_the_ball():
    grid = sheet_distance(SHEET)
    axes = [grid.origin[i] + grid.spacing * np.arange(grid.values.shape[i]) for i in range(3)]
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    truth = np.linalg.norm(nodes, axis=-1) - RADIUS_M
    near = np.abs(truth) < 0.03
    np.testing.assert_allclose(grid.values[near], truth[near], atol=1e-3)


def test_beyond_the_edge_of_an_open_sheet_space_is_free():
    x, y = np.meshgrid(np.arange(-0.03, 0.031, 0.005), np.arange(-0.03, 0.031, 0.005))
    p = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    grid = sheet_distance(Sheet(p, np.tile([0.0, 0.0, 1.0], (len(p), 1))))
    middle = tuple(n // 2 for n in grid.values.shape)
    assert grid.values[middle[0], middle[1], 0] < -0.015
    assert grid.values[middle[0], middle[1], -1] > 0.015
    assert grid.values[0, 0, 0] > 0.0
