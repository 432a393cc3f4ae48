import numpy as np
import pytest

from vh_drake.geometry.line_graph import FREE, Branch, pruned, traced


def line(start, step, count):
    return np.array(start) + np.arange(count)[:, None] * np.array(step)


def test_a_straight_row_of_voxels_is_one_branch_with_two_free_ends():
    (branch,) = traced(line([0, 0, 0], [1, 1, 0], 9))
    assert (branch.start, branch.end) == (FREE, FREE)
    assert branch.length == pytest.approx(8 * np.sqrt(2))
    assert {tuple(branch.p[0]), tuple(branch.p[-1])} == {(0, 0, 0), (8, 8, 0)}


def test_three_arms_meet_in_one_junction():
    voxels = np.vstack([line([0, 0, 0], step, 9) for step in ([1, 0, 0], [-1, 1, 0], [0, -1, 1])])
    branches = traced(np.unique(voxels, axis=0))
    assert len(branches) == 3
    for branch in branches:
        assert sorted([branch.start, branch.end]) == [FREE, 0]
        outer = branch.p[0] if branch.start == FREE else branch.p[-1]
        assert np.abs(outer).max() == 8


def test_a_ring_of_voxels_is_a_closed_branch():
    square = [line([0, 0, 0], [1, 0, 0], 9), line([8, 0, 0], [0, 1, 0], 9)]
    square += [line([8, 8, 0], [-1, 0, 0], 9), line([0, 8, 0], [0, -1, 0], 9)]
    (branch,) = traced(np.unique(np.vstack(square), axis=0))
    np.testing.assert_array_equal(branch.p[0], branch.p[-1])
    assert branch.length == pytest.approx(32, abs=4 * (2 - np.sqrt(2)))


def test_branches_of_a_ring_with_a_tail_share_their_junction():
    ring = [line([0, 0, 0], [1, 0, 0], 9), line([8, 0, 0], [0, 1, 0], 9)]
    ring += [line([8, 8, 0], [-1, 0, 0], 9), line([0, 8, 0], [0, -1, 0], 9)]
    tail = line([8, 4, 0], [1, 0, 0], 8)
    branches = traced(np.unique(np.vstack([*ring, tail]), axis=0))
    assert sorted((b.start, b.end) in ((0, FREE), (FREE, 0)) for b in branches) == [False, True]


def test_short_spurs_go_and_what_they_sprang_from_becomes_one():
    arms = [
        Branch(line([0, 0, 0], step, k), 0, FREE)
        for step, k in zip(np.eye(3), (9, 9, 3), strict=True)
    ]
    (whole,) = pruned(arms, {0: 3.0})
    assert (whole.start, whole.end) == (FREE, FREE)
    assert whole.length == pytest.approx(16)
    assert len(pruned(arms, {0: 1.0})) == 3


def test_a_lump_that_no_line_leads_to_is_a_node_of_its_own():
    lump = np.stack(np.meshgrid([0, 1], [0, 1], [0, 1]), axis=-1).reshape(-1, 3)
    branches = traced(np.vstack([lump, line([9, 0, 0], [1, 0, 0], 5)]))
    assert sorted(len(branch.p) for branch in branches) == [1, 5]
    (node,) = (branch for branch in branches if len(branch.p) == 1)
    assert (node.start, node.end) == (FREE, FREE)
    assert (lump == node.p).all(axis=1).any()


def test_a_spur_that_is_all_of_its_part_stays():
    alone = Branch(line([0, 0, 0], [1, 0, 0], 3), 0, FREE)
    arms = [Branch(line([0, 9, 0], step, 9), 1, FREE) for step in np.eye(3)]
    assert any(branch is alone for branch in pruned([alone, *arms], {0: 5.0, 1: 0.0}))
