import itertools

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from vh_drake.errors import BadInput
from vh_drake.geometry.model_files import models_folder
from vh_drake.hand.clearance import link_clearance, obstacles
from vh_drake.hand.description import load_hand
from vh_drake.hand.model import read_hand_model
from vh_drake.types import Plane, Surface

HALF = np.array([0.03, 0.05, 0.04])
CENTER = np.array([0.7, -0.3, 0.94])
TABLE = Plane(np.array([0.0, 0.0, 1.0]), 0.9)
GRID_M = 0.006  # spacing of the distances


@pytest.fixture(scope="module")
def hand():
    return read_hand_model(load_hand(models_folder() / "armar6_hand" / "armar6_hand.yaml"))


@pytest.fixture(scope="module")
def scene():
    mesh = trimesh.creation.box(2 * HALF).subdivide().subdivide()
    mesh.apply_translation(CENTER)
    return obstacles(Surface(np.array(mesh.vertices), np.array(mesh.faces, np.int64)), TABLE)


def box_distance(p):
    """Signed distance of points to the box."""
    q = np.abs(p - CENTER) - HALF
    return np.linalg.norm(np.maximum(q, 0), axis=1) + np.minimum(q.max(axis=1), 0)


def poses(count, seed=0):
    """Hands about the box, some of them in it."""
    rng = np.random.default_rng(seed)
    for rotation in Rotation.random(count, random_state=seed):
        X = np.eye(4)
        X[:3, :3] = rotation.as_matrix()
        X[:3, 3] = CENTER + rng.uniform(-0.12, 0.12, 3)
        yield X


def test_link_clearances_are_those_of_spheres_and_box(hand, scene):
    for X_WH in poses(8):
        links, table = link_clearance(hand, X_WH, scene)
        centers, radii = hand.spheres(hand.lower)
        p = centers @ X_WH[:3, :3].T + X_WH[:3, 3]
        gaps = box_distance(p) - radii
        first = hand.arrays.first_sphere
        for link, (start, stop) in enumerate(itertools.pairwise(first)):
            exact = gaps[start:stop].min()
            if exact < 0.02:  # Farther off the grid only bounds it from below.
                assert links[link] == pytest.approx(exact, abs=GRID_M / 2)
            else:
                assert links[link] > 0.01
        assert table == pytest.approx((p[:, 2] - radii).min() - 0.9)


def test_a_hand_far_from_the_object_is_clear_of_it(hand, scene):
    X_WH = np.eye(4)
    X_WH[:3, 3] = [0.2, 0.5, 1.4]
    links, table = link_clearance(hand, X_WH, scene)
    assert links.min() > 0.02
    assert table > 0.2


def test_closed_fingers_are_where_their_joints_put_them(hand, scene):
    X_WH = next(poses(1, seed=4))
    closed = hand.joint_angles(np.ones(2))
    links, table = link_clearance(hand, X_WH, scene, closed)
    centers, radii = hand.spheres(closed)
    p = centers @ X_WH[:3, :3].T + X_WH[:3, 3]
    assert table == pytest.approx((p[:, 2] - radii).min() - 0.9)
    assert len(links) == len(hand.links)


def test_the_object_s_top_is_its_height_over_the_table(scene):
    assert scene.top_m == pytest.approx(CENTER[2] + HALF[2] - 0.9)


def test_an_empty_estimate_is_no_obstacle_but_an_error():
    with pytest.raises(BadInput, match="empty surface"):
        obstacles(Surface(), TABLE)
