import gc

import numpy as np
import pytest
from scenery import right_arm, right_hand

from vh_drake.benches.soak import resident_mb
from vh_drake.control.arm_collisions import ArmCollisions, TableTop
from vh_drake.control.reach import rollout, solve_ik

ARM, HAND = right_arm(), right_hand()
TABLE_M = 0.9


@pytest.fixture(scope="module")
def collisions():
    return ArmCollisions(ARM, HAND.description.model, HAND.description.base)


def hand_at(p_WH):
    """Joint positions (1, 8) with the hand turned as at home."""
    X_WH = ARM.pose(ARM.home)
    X_WH[:3, 3] = p_WH
    q = solve_ik(ARM, X_WH, [ARM.home])
    assert q is not None
    return q[None]


def test_the_arm_is_free_at_home(collisions):
    assert collisions.first(ARM.home[None], TABLE_M) is None


def test_a_hand_in_the_table_collides_and_a_lower_table_frees_it(collisions):
    q = hand_at([0.7, -0.3, 0.95])
    found = collisions.first(q, TABLE_M)
    assert found is not None
    assert "table" in found.bodies
    assert collisions.first(q, 0.5) is None


def test_beside_the_table_a_low_hand_is_free():
    elsewhere = TableTop((0.7, 0.8), (0.4, 0.4))
    narrow = ArmCollisions(ARM, HAND.description.model, HAND.description.base, elsewhere)
    assert narrow.first(hand_at([0.7, -0.3, 0.95]), TABLE_M) is None


def test_a_hand_in_the_chest_collides_with_the_torso(collisions):
    rng, X_WC = np.random.default_rng(0), np.array([0.0, 0.0, 1.225])
    hits = [q for q in rng.uniform(ARM.lower, ARM.upper, (4000, 8)) if _palm_near(q, X_WC)]
    assert hits
    for q in hits:
        found = collisions.first(q[None], 0.0)
        assert found is not None
        assert any(name in ("torso", "lower_neck") for name in found.bodies) or "arm" in str(found)


def _palm_near(q, p_W):
    """Whether the middle of the palm is deep in the chest."""
    p_HPalm = np.array([0.0275, 0.0, -0.067, 1.0])
    return np.abs((ARM.pose(q) @ p_HPalm)[:3] - p_W).max() < 0.08


def test_the_first_collision_of_a_motion_is_named(collisions):
    X_WH = ARM.pose(ARM.home)
    down, below = X_WH.copy(), X_WH.copy()
    down[:3, 3] = [0.7, -0.3, 1.2]
    below[:3, 3] = [0.7, -0.3, 0.93]
    way = rollout(ARM, ARM.home, [down, below])
    assert way.reached
    found = collisions.first(way.q, TABLE_M)
    assert found is not None
    heights = [ARM.pose(q)[2, 3] for q in way.q]
    assert 0.93 < heights[found.index] < 1.1
    assert collisions.first(way.q[: found.index - 5], TABLE_M) is None


def test_two_questions_do_not_touch_each_other(collisions):
    q = hand_at([0.7, -0.3, 0.95])
    first = collisions.first(q, TABLE_M)
    collisions.first(ARM.home[None], 0.2)
    assert collisions.first(q, TABLE_M) == first


def test_many_that_are_dropped_leave_no_memory_behind():
    def build(count):
        for _ in range(count):
            ArmCollisions(ARM, HAND.description.model, HAND.description.base)
            gc.collect()

    build(4)
    before = resident_mb()
    build(20)
    assert resident_mb() - before < 6.0
