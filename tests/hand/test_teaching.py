import dataclasses as dc

import numpy as np
import pytest

from vh_drake.errors import BadInput
from vh_drake.hand.key_points import MOST_KEY_POINTS, KeyPoint, KeyPointTrajectory
from vh_drake.hand.teaching import JOGS, LOWERING_M_S, Teaching


def times(teaching):
    return [point.time_s for point in teaching.points]


def taught(heights, spacing_s=0.5):
    """A hand that was jogged to heights [m], a key point at each."""
    teaching = Teaching()
    for height in heights:
        teaching = teaching.moved("z", height).key_point_set(spacing_s)
    return teaching


def heights(teaching):
    return [point.position_m[2] for point in teaching.points]


@pytest.mark.parametrize("name", JOGS)
def test_a_jog_moves_one_thing_by_its_step_and_back(name):
    step = 0.02
    there = Teaching().jogged(name, step)
    changed = there.target.values() - Teaching().target.values()
    expected = np.zeros(8)
    expected[list(JOGS).index(name)] = step
    np.testing.assert_allclose(changed, expected, atol=1e-9)
    np.testing.assert_array_equal(there.jogged(name, -step).target.values(), np.zeros(8))


@pytest.mark.parametrize("name", JOGS)
def test_jogs_end_at_the_limits(name):
    teaching, index = Teaching(), list(JOGS).index(name)
    low, high = JOGS[name]
    for _ in range(3):
        teaching = teaching.jogged(name, (high - low) / 2)
    assert teaching.target.values()[index] == high
    assert teaching.moved(name, low - 5.0).target.values()[index] == low


def test_key_points_are_set_one_spacing_apart_from_zero_on():
    teaching = taught([0.0, 0.1, 0.2]).moved("z", 0.3).key_point_set(1.5)
    assert times(teaching) == [0.0, 0.5, 1.0, 2.5]
    assert heights(teaching) == [0.0, 0.1, 0.2, 0.3]
    assert teaching.selected == 3


def test_a_key_point_set_in_the_middle_makes_the_later_ones_wait():
    teaching = taught([0.0, 0.1, 0.2]).gone(-1).moved("z", 0.15).key_point_set(0.25)
    assert heights(teaching) == [0.0, 0.1, 0.15, 0.2]
    assert times(teaching) == [0.0, 0.5, 0.75, 1.25]
    assert teaching.selected == 2


@pytest.mark.parametrize(
    ("back", "left", "left_times", "selected"),
    [
        (0, [0.0, 0.1], [0.0, 0.5], 1),
        (-1, [0.0, 0.2], [0.0, 0.5], 0),
        (-2, [0.1, 0.2], [0.0, 0.5], 0),
    ],
)
def test_a_deleted_key_point_leaves_no_gap(back, left, left_times, selected):
    teaching = taught([0.0, 0.1, 0.2]).gone(back).key_point_deleted()
    assert heights(teaching) == left
    assert times(teaching) == left_times
    assert teaching.selected == selected


def test_the_last_key_point_can_be_deleted_and_then_nothing():
    teaching = taught([0.1]).key_point_deleted()
    assert teaching.points == ()
    assert teaching.key_point_deleted() == teaching
    assert teaching.gone(1) == teaching
    assert teaching.played(1.0) == teaching
    assert times(teaching.key_point_set(0.5)) == [0.0]


def test_whatever_is_set_and_deleted_can_be_saved():
    rng = np.random.default_rng(2)
    teaching = taught([0.0])
    for _ in range(300):
        action = rng.integers(4)
        if action == 0:
            teaching = teaching.key_point_set(rng.uniform(0.1, 2.0))
        elif action == 1 and len(teaching.points) > 1:
            teaching = teaching.key_point_deleted()
        elif action == 2:
            teaching = teaching.gone(int(rng.integers(-3, 4)))
        else:
            teaching = teaching.jogged(str(rng.choice(list(JOGS))), rng.normal())
        assert 0 <= teaching.selected < len(teaching.points)
        teaching.trajectory("")  # It is checked there.


def test_going_to_a_key_point_moves_the_hand_there_and_stops_at_the_ends():
    teaching = taught([0.0, 0.1, 0.2]).moved("z", 0.7)
    for by, index in ((-1, 1), (-5, 0), (1, 1), (9, 2)):
        teaching = teaching.gone(by)
        assert teaching.selected == index
        assert teaching.target == teaching.points[index]


def test_playing_leads_to_the_first_key_point_and_ends_at_the_last():
    teaching = taught([0.0, 0.1, 0.3]).moved("z", 0.6).played(1.0)
    seen = []
    for _ in range(100):
        if teaching.playing_s is None:
            break
        seen.append((teaching.playing_s, teaching.target.position_m[2]))
        teaching = teaching.advanced(0.05)
    clock, height = np.array(seen).T
    np.testing.assert_allclose(height, np.interp(clock, [0, 0.5, 1.0], [0, 0.1, 0.3]), atol=1e-6)
    assert clock[0] == -1.0
    assert teaching.target == teaching.points[-1]
    assert teaching.selected == 2


def test_the_hand_sinks_until_it_touches():
    teaching = Teaching().lowered()
    for _ in range(10):
        teaching = teaching.advanced(0.1)
    assert teaching.target.position_m[2] == pytest.approx(-LOWERING_M_S)
    still = teaching.touched()
    assert still.advanced(1.0) == still


@pytest.mark.parametrize("start", [lambda t: t.played(0.5), lambda t: t.lowered()])
@pytest.mark.parametrize(
    "action",
    [
        lambda t: t.jogged("x", 0.01),
        lambda t: t.key_point_set(0.5),
        lambda t: t.key_point_deleted(),
        lambda t: t.gone(-1),
    ],
)
def test_every_action_ends_what_moves_the_hand_by_itself(start, action):
    teaching = action(start(taught([0.0, 0.1])).advanced(0.1))
    assert teaching.playing_s is None
    assert not teaching.lowering
    assert teaching.advanced(1.0) == teaching


def test_a_loaded_trajectory_is_what_was_saved_and_leaves_the_hand_alone():
    saved = taught([0.0, 0.1, 0.2]).trajectory("lift")
    assert saved.name == "lift"
    teaching = Teaching().jogged("x", 0.05).loaded(saved)
    assert teaching.trajectory("lift") == saved
    assert teaching.target.position_m == [0.05, 0.0, 0.0]


def test_a_new_start_keeps_the_fingers_and_counts_poses_anew():
    there = Teaching().jogged("x", 0.1).jogged("yaw", 20.0).moved("fingers", 0.4).rooted()
    assert there.target == KeyPoint(fingers=0.4)


def test_nothing_set_is_nothing_to_save():
    with pytest.raises(BadInput, match="0 key points"):
        Teaching().trajectory("")


def test_there_is_an_end_to_key_points():
    points = [KeyPoint(time_s=0.1 * i) for i in range(MOST_KEY_POINTS)]
    full = Teaching().loaded(KeyPointTrajectory("", points))
    with pytest.raises(BadInput, match="delete some"):
        full.key_point_set(0.5)
    assert len(full.key_point_deleted().key_point_set(0.5).points) == MOST_KEY_POINTS


def test_a_teaching_is_replaced_and_never_changed():
    before = taught([0.0, 0.1])
    copy = dc.replace(before, points=tuple(dc.replace(p) for p in before.points))
    before.jogged("x", 0.1).key_point_set(0.5)
    before.gone(-1).key_point_deleted()
    assert before == copy
