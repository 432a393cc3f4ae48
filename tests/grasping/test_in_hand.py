import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from vh_drake.grasping.field import ObjectField
from vh_drake.grasping.in_hand import PlaceSettings, lie_in_hand, narrowest, well_placed
from vh_drake.grasping.motions import CollectSettings, collect_pose, hand_axes
from vh_drake.types import Plane, ScalarGrid

SETTINGS = PlaceSettings()
TABLE = Plane(np.array([0.0, 0.0, 1.0]), 0.0)
SHIFTS = np.array([0.0, 0.005, 0.01, 0.02, 0.03])


def hand_from_top(hand):
    """Fingers along +x, the power TCP over the origin."""
    return collect_pose(hand, hand.lower, CollectSettings())


def hand_from_side(hand):
    """Fingers along +x, palm towards -y, the hand's base 6 cm over the table."""
    fingers, palm = hand_axes(hand)
    X = np.eye(4)
    own = np.stack([fingers, palm, np.cross(fingers, palm)])
    X[:3, :3] = np.array([[1.0, 0, 0], [0, -1, 0], [0, 0, -1]]).T @ own
    X[2, 3] = 0.06
    return X


def tcp_of(hand, X):
    return X[:3, :3] @ np.asarray(hand.description.tcps["power"]) + X[:3, 3]


def thumb_side(hand):
    """+1 where the thumb is to the left of fingers along +x, -1 to the right."""
    thumb = hand.tips(hand.lower)[hand.opposing == 1].mean(axis=0)
    return np.sign((hand_from_top(hand)[:3, :3] @ thumb)[1])


def block(center, sides=(0.05, 0.05, 0.05)):
    """Vertices of a block on the table, and its field."""
    mesh = trimesh.creation.box(sides).subdivide().subdivide().subdivide()
    middle = np.array([*center, sides[2] / 2])
    vertices = np.array(mesh.vertices) + middle
    return vertices, ObjectField(ScalarGrid(), TABLE, middle, float(np.linalg.norm(sides)) / 2)


def wanted_place(hand, motion):
    """Where a block lies best, x and y."""
    if motion == "side":
        return tcp_of(hand, hand_from_side(hand))[:2] + np.array([SETTINGS.side_along_m, 0.0])
    return np.array([SETTINGS.collect_along_m, thumb_side(hand) * SETTINGS.collect_beside_m])


def pose(hand, motion):
    return hand_from_side(hand) if motion == "side" else hand_from_top(hand)


def moved(X, shifts_W):
    """The pose, shifted by each row."""
    poses = np.tile(X, (len(shifts_W), 1, 1))
    poses[:, :3, 3] += shifts_W
    return poses


def test_where_the_object_lies_is_told_in_metres(hand):
    place = wanted_place(hand, "collect")
    vertices, field = block(place, sides=(0.07, 0.05, 0.05))
    X = moved(hand_from_top(hand), np.array([[0.0, 0.0, 0.0], [-0.01, 0.0, 0.0], [0.5, 0.0, 0.0]]))
    lie = lie_in_hand(X, "collect", vertices, field, hand, SETTINGS)
    assert lie.met.all()
    np.testing.assert_allclose(lie.middle - place[0], [0.0, 0.01, -0.5], atol=1e-9)
    np.testing.assert_allclose(lie.beside, SETTINGS.collect_beside_m, atol=1e-9)
    np.testing.assert_allclose(lie.excess, 0.02, atol=1e-3)  # 7 cm, where 5 cm would do


@pytest.mark.parametrize("motion", ["collect", "side"])
def test_an_object_at_the_wanted_place_gets_all(hand, motion):
    vertices, field = block(wanted_place(hand, motion))
    X = pose(hand, motion)[None]
    assert well_placed(X, motion, vertices, field, hand, SETTINGS) == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("motion", ["collect", "side"])
@pytest.mark.parametrize("sign", [-1, 1])
def test_it_falls_when_the_object_is_nearer_or_farther_along_the_fingers(hand, motion, sign):
    vertices, field = block(wanted_place(hand, motion))
    X = moved(pose(hand, motion), sign * SHIFTS[:, None] * [1.0, 0.0, 0.0])
    placed = well_placed(X, motion, vertices, field, hand, SETTINGS)
    assert (np.diff(placed) < 0).all()
    expected = np.exp(-((SHIFTS / SETTINGS.along_std_m) ** 2) / 2)
    np.testing.assert_allclose(placed, expected, atol=1e-9)


@pytest.mark.parametrize("sign", [-1, 1])
def test_it_falls_when_the_object_lies_beside_the_thumb_and_fingers(hand, sign):
    vertices, field = block(wanted_place(hand, "collect"))
    X = moved(hand_from_top(hand), sign * SHIFTS[:, None] * [0.0, 1.0, 0.0])
    placed = well_placed(X, "collect", vertices, field, hand, SETTINGS)
    assert (np.diff(placed) < 0).all()


@pytest.mark.parametrize("motion", ["collect", "side"])
def test_a_turn_of_hand_and_object_about_the_vertical_changes_nothing(hand, motion):
    vertices, field = block(
        wanted_place(hand, motion) + np.array([0.007, 0.004]), (0.05, 0.08, 0.06)
    )
    X = moved(pose(hand, motion), np.array([[0.0, 0, 0], [0.01, 0, 0], [0.0, 0.012, 0]]))
    before = well_placed(X, motion, vertices, field, hand, SETTINGS)
    turn = np.eye(4)
    turn[:3, :3] = Rotation.from_euler("z", 1.1).as_matrix()
    turn[:2, 3] = 0.7, -0.3
    turned = vertices @ turn[:3, :3].T + turn[:3, 3]
    center = turn[:3, :3] @ field.center + turn[:3, 3]
    same = ObjectField(field.distance, TABLE, center, field.size_m)
    after = well_placed(turn @ X, motion, turned, same, hand, SETTINGS)
    np.testing.assert_allclose(after, before, atol=1e-9)
    assert before.max() > 0.2


def test_a_bar_is_better_held_across_its_narrow_side(hand):
    place = wanted_place(hand, "collect")
    vertices, field = block(place, (0.05, 0.09, 0.05))
    across = hand_from_top(hand)
    turn = np.eye(4)
    turn[:2, :2] = [[0, -1], [1, 0]]
    turn[:2, 3] = place - turn[:2, :2] @ place  # about the bar's middle
    placed = well_placed(
        np.stack([across, turn @ across]), "collect", vertices, field, hand, SETTINGS
    )
    assert placed[0] == pytest.approx(1.0, abs=1e-9)
    assert placed[1] < 0.5


@pytest.mark.parametrize("yaw", [0.0, 0.3, 1.1, 2.9])
def test_the_narrowest_width_is_that_of_the_narrow_side_at_any_heading(yaw):
    corners = np.array(trimesh.creation.box((0.12, 0.05, 0.2)).vertices)
    turned = corners @ Rotation.from_euler("z", yaw).as_matrix().T
    width = narrowest(turned, TABLE.normal)
    assert 0.05 - 1e-12 <= width < 0.058


@pytest.mark.parametrize("motion", ["collect", "side"])
def test_it_is_a_number_from_0_to_1_wherever_the_hand_is(hand, motion):
    rng = np.random.default_rng(0)
    vertices, field = block((0.0, 0.0))
    X = np.tile(np.eye(4), (50, 1, 1))
    X[:, :3, :3] = Rotation.random(50, random_state=0).as_matrix()
    X[:, :3, 3] = rng.uniform(-0.3, 0.3, (50, 3))
    placed = well_placed(X, motion, vertices, field, hand, SETTINGS)
    assert ((placed >= 0) & (placed <= 1)).all()


@pytest.mark.filterwarnings("error")
def test_an_object_out_of_the_hands_reach_gets_nothing(hand):
    vertices, field = block((0.0, 5.0))
    placed = well_placed(hand_from_top(hand)[None], "collect", vertices, field, hand, SETTINGS)
    assert placed.tolist() == [0.0]
