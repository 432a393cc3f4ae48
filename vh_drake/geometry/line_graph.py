"""Lines of voxels as the branches of a graph."""

import dataclasses as dc
from collections.abc import Sequence

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from vh_drake.types import Array, IntArray

FREE = -1  # A branch that ends here meets no other.
_NEIGHBORS = 1.8  # Voxels nearer than this touch, at least by a corner.


@dc.dataclass(frozen=True, eq=False)
class Branch:
    """A line between junctions or free ends; a loop without junctions ends where it starts."""

    p: Array  # (k, 3) in voxels, k ≥ 1
    start: int = FREE  # number of the junction
    end: int = FREE

    @property
    def length(self) -> float:
        """Of the line, in voxels."""
        return float(np.linalg.norm(np.diff(self.p, axis=0), axis=1).sum())

    def reversed(self) -> "Branch":
        """The same line the other way round."""
        return Branch(self.p[::-1], self.end, self.start)


def traced(voxels: IntArray) -> tuple[Branch, ...]:
    """The branches of a line drawing (n, 3); a lump that no line leads to is one of a node."""
    graph = _graph(voxels)
    degree = np.diff(graph.indptr)
    junction = degree > 2
    clusters = np.full(len(voxels), FREE)
    inner = graph[junction][:, junction]
    clusters[junction] = connected_components(inner, directed=False)[1]
    centers = [voxels[clusters == i].mean(axis=0) for i in range(clusters.max(initial=FREE) + 1)]
    simple = np.flatnonzero(~junction)
    count, part = connected_components(graph[simple][:, simple], directed=False)
    branches = [_branch(simple[part == i], voxels, graph, clusters, centers) for i in range(count)]
    led_to = {end for branch in branches for end in (branch.start, branch.end)}
    lumps = [p for i, p in enumerate(centers) if i not in led_to]
    return (*branches, *(Branch(_nearest(voxels, p)) for p in lumps))


def pruned(branches: Sequence[Branch], thickness: dict[int, float]) -> tuple[Branch, ...]:
    """Branches without the spurs that the thickness of what they spring from explains.

    Args:
        branches: of a graph.
        thickness: length of a free branch, by junction, below which it is a spur [voxel].
    """
    kept = list(branches)
    while True:
        spurs = [
            branch
            for branch in kept
            if (branch.start == FREE) != (branch.end == FREE)
            and branch.length < thickness[max(branch.start, branch.end)]
            and _springs_from_others(branch, kept)
        ]
        if not spurs:
            return tuple(kept)
        shortest = min(spurs, key=lambda branch: branch.length)
        kept.remove(shortest)
        kept = _joined(kept, max(shortest.start, shortest.end))


def _springs_from_others(branch: Branch, branches: Sequence[Branch]) -> bool:
    """Whether others meet at a spur's junction; else it is all that there is of a part."""
    junction = max(branch.start, branch.end)
    return any(junction in (b.start, b.end) for b in branches if b is not branch)


def _nearest(voxels: IntArray, p: Array) -> Array:
    """The voxel (1, 3) nearest to a point (3,)."""
    nearest: Array = voxels[np.linalg.norm(voxels - p, axis=1).argmin()][None].astype(np.float64)
    return nearest


def _joined(branches: list[Branch], junction: int) -> list[Branch]:
    """The same graph, where a junction of two branches, or of one, is none any more."""
    meeting = [b for b in branches if junction in (b.start, b.end)]
    others = [b for b in branches if junction not in (b.start, b.end)]
    if len(meeting) == 2:
        one, other = meeting
        one = one if one.end == junction else one.reversed()
        other = other if other.start == junction else other.reversed()
        return [*others, Branch(np.vstack([one.p, other.p[1:]]), one.start, other.end)]
    if len(meeting) == 1 and meeting[0].start != meeting[0].end:
        (last,) = meeting
        last = last if last.end == junction else last.reversed()
        return [*others, Branch(last.p, last.start, FREE)]
    return branches


def _graph(voxels: IntArray) -> csr_array:
    """Neighbours, without the diagonals beside which a way by shorter steps leads."""
    pairs = cKDTree(voxels).query_pairs(_NEIGHBORS, output_type="ndarray")
    squares = ((voxels[pairs[:, 0]] - voxels[pairs[:, 1]]) ** 2).sum(axis=1)
    kept = np.zeros((0, 2), np.int64)
    for square in (1, 2, 3):
        shorter = _adjacency(pairs[squares < square], len(voxels))
        start, end = (shorter @ shorter).nonzero()
        edges = pairs[squares == square]
        around = np.isin(edges @ [len(voxels), 1], start * np.int64(len(voxels)) + end)
        kept = np.vstack([kept, edges[~around]])
    return _adjacency(kept, len(voxels))


def _adjacency(pairs: IntArray, count: int) -> csr_array:
    both = np.vstack([pairs, pairs[:, ::-1]])
    graph = coo_array((np.ones(len(both)), (both[:, 0], both[:, 1])), shape=(count, count))
    return csr_array(graph)


def _branch(
    members: IntArray, voxels: IntArray, graph: csr_array, clusters: IntArray, centers: list[Array]
) -> Branch:
    """One chain of voxels in its order, carried on into the junctions at its ends."""
    order = _ordered(members, graph)
    p = voxels[order].astype(np.float64)
    first, last = (_junctions(order[i], graph, clusters) for i in (0, -1))
    # One voxel alone may lie between two junctions.
    ends = (*first, FREE, FREE)[:2] if len(order) == 1 else (first[0], last[0])
    if ends[0] != FREE:
        p = np.vstack([centers[ends[0]], p])
    if ends[1] != FREE:
        p = np.vstack([p, centers[ends[1]]])
    closed = len(order) > 2 and ends == (FREE, FREE) and order[-1] in _neighbors(order[0], graph)
    return Branch(np.vstack([p, p[:1]]) if closed else p, ends[0], ends[1])


def _ordered(members: IntArray, graph: csr_array) -> list[int]:
    """The voxels of a chain from one end to the other; of a loop from anywhere."""
    own = set(members.tolist())
    inside = {i: [j for j in _neighbors(i, graph) if j in own] for i in own}
    ends = [i for i in members.tolist() if len(inside[i]) < 2]
    order = [ends[0] if ends else int(members[0])]
    seen = set(order)
    while following := [j for j in inside[order[-1]] if j not in seen]:
        order.append(following[0])
        seen.add(following[0])
    return order


def _neighbors(node: int, graph: csr_array) -> list[int]:
    neighbors: list[int] = graph.indices[graph.indptr[node] : graph.indptr[node + 1]].tolist()
    return neighbors


def _junctions(node: int, graph: csr_array, clusters: IntArray) -> list[int]:
    """Numbers of the junctions beside a voxel, each once; FREE where there are none."""
    return sorted({int(clusters[j]) for j in _neighbors(node, graph)} - {FREE}) or [FREE]
