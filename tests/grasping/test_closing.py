import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from vh_drake.grasping.closing import CONTACT_M, close_hand
from vh_drake.grasping.field import ObjectField, object_field
from vh_drake.grasping.motions import CollectSettings, collect_motion, collect_pose, side_motion
from vh_drake.types import Plane, ScalarGrid

FAR_BELOW = Plane(np.array([0.0, 0, 1]), -10.0)
# Where the closing fingers of ARMAR-6 meet around something, in H.
GRASPED = np.array([-0.045, -0.005, 0.03])


def ball_field(center, radius=0.035, spacing=0.003, table=FAR_BELOW):
    """The exact distance to a ball, sampled."""
    count = int(2 * (radius + 0.02) / spacing) + 1
    origin = center - spacing * (count - 1) / 2
    nodes = np.stack(np.meshgrid(*[np.arange(count)] * 3, indexing="ij"), axis=-1)
    values = np.linalg.norm(origin + spacing * nodes - center, axis=-1) - radius
    return ObjectField(ScalarGrid(origin, spacing, values), table, center, radius)


@pytest.fixture(scope="module")
def side(hand):
    return side_motion(hand)


def gaps(hand, closure, center, radius=0.035):
    """Exact distances of the closed hand's spheres from the ball."""
    centers, radii = hand.spheres(closure.angles)
    p = centers @ closure.X_WH[:3, :3].T + closure.X_WH[:3, 3]
    return np.linalg.norm(p - center, axis=1) - radius - radii


def test_fingers_and_thumb_close_onto_a_ball_without_entering_it(hand, side):
    closure = close_hand(hand, ball_field(GRASPED), side, np.eye(4))
    touching = {hand.links[link].split("_")[0] for link in closure.links}
    assert closure.started_free
    assert {"thumb", "index", "middle", "ring"} <= touching
    assert gaps(hand, closure, GRASPED).min() > -3 * CONTACT_M


def test_contacts_lie_on_the_ball_with_outward_normals(hand, side):
    closure = close_hand(hand, ball_field(GRASPED), side, np.eye(4))
    spokes = (closure.p_WC - GRASPED) / 0.035
    np.testing.assert_allclose(np.linalg.norm(spokes, axis=1), 1, atol=0.02)
    np.testing.assert_allclose((closure.n_WC * spokes).sum(axis=1), 1, atol=0.02)


def test_a_touching_link_locks_what_is_before_it_and_the_rest_goes_on(hand, side):
    closure = close_hand(hand, ball_field(GRASPED), side, np.eye(4))
    open_end = set(closure.links)
    for finger in range(hand.num_fingers):
        links = np.flatnonzero(hand.finger_of_link == finger)
        outermost = max((link for link in links if link in open_end), default=0)
        beyond = [link for link in links if link > outermost]
        joints = np.array(beyond, dtype=int) - 1
        np.testing.assert_allclose(closure.angles[joints], hand.upper[joints], atol=1e-9)
        if outermost:
            assert closure.angles[outermost - 1] < hand.upper[outermost - 1]


def test_an_empty_hand_closes_to_its_stops(hand, side):
    closure = close_hand(hand, ball_field(np.array([0, 0, 1.0])), side, np.eye(4))
    assert len(closure.links) == 0
    np.testing.assert_allclose(closure.angles, hand.upper, atol=1e-9)


def test_a_start_in_collision_is_invalid(hand, side):
    closure = close_hand(hand, ball_field(np.array([0.02, 0, 0.03])), side, np.eye(4))
    assert not closure.started_free
    assert len(closure.links) == 0


def test_a_start_below_the_table_is_invalid(hand, side):
    field = ball_field(np.array([0, 0, 1.0]), table=Plane(np.array([0, 0, 1.0]), 0.0))
    assert not close_hand(hand, field, side, np.eye(4)).started_free


def test_the_palm_advances_until_it_touches(hand, side):
    center = np.array([-0.075, 0.0, -0.005])
    field = ball_field(center, radius=0.025)
    still = close_hand(hand, field, side, np.eye(4))
    advanced = close_hand(hand, field, side, np.eye(4), palm_advance_m=0.1)
    assert 0 not in still.links
    assert 0 in advanced.links
    assert advanced.X_WH[0, 3] < -0.02


def test_closing_moves_with_object_and_hand(hand, side):
    X = np.eye(4)
    X[:3, :3] = Rotation.random(random_state=0).as_matrix()
    X[:3, 3] = [0.4, -0.2, 0.7]
    here = close_hand(hand, ball_field(GRASPED), side, np.eye(4))
    there = close_hand(hand, ball_field(X[:3, :3] @ GRASPED + X[:3, 3]), side, X)
    np.testing.assert_array_equal(here.links, there.links)
    np.testing.assert_allclose(there.angles, here.angles, atol=0.05)
    moved = here.p_WC @ X[:3, :3].T + X[:3, 3]
    np.testing.assert_allclose(there.p_WC, moved, atol=0.003)


def test_closing_agrees_with_small_fixed_steps(hand, side):
    """Peer: march the free-space motion of each finger in 2,000 steps on the exact ball."""
    closure = close_hand(hand, ball_field(GRASPED), side, np.eye(4))
    first = hand.arrays.first_sphere
    times = np.linspace(0, 1, 2000)
    knots = np.linspace(0, 1, len(side.angles))
    free = np.array([np.interp(times, knots, column) for column in side.angles.T]).T
    angles, locked = hand.lower.copy(), np.zeros(len(hand.joints), bool)
    for step in free:
        angles = np.where(locked, angles, step)
        centers, radii = hand.spheres(angles)
        gap = np.linalg.norm(centers - GRASPED, axis=1) - 0.035 - radii
        for finger in range(hand.num_fingers):
            links = np.flatnonzero(hand.finger_of_link == finger)
            touching = [
                k for k in links if not locked[k - 1] and gap[first[k] : first[k + 1]].min() < 0
            ]
            if touching:
                locked[links[0] - 1 : max(touching)] = True
    np.testing.assert_allclose(closure.angles, angles, atol=0.06)


def test_a_collecting_hand_stops_at_the_first_contact(hand, standing, table):
    settings = CollectSettings()
    field = object_field(standing(trimesh.creation.box([0.05, 0.08, 0.04])), table)
    X = collect_pose(hand, hand.lower, settings)
    X[:3, 3] += [0.7 - 0.03, -0.3, 0.9]
    closure = close_hand(hand, field, collect_motion(hand, settings), X)
    touching = {hand.links[link].split("_")[0] for link in closure.links}
    assert {"thumb", "middle"} <= touching
    assert closure.X_WH[2, 3] > X[2, 3] + 0.002
    assert (closure.p_WC[:, 2] > 0.9).all()
