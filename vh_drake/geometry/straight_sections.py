"""Straight pieces of lines."""

import dataclasses as dc
import itertools

import numpy as np

from vh_drake.types import Array


@dc.dataclass(frozen=True, eq=False)
class StraightSection:
    """A piece of a line that leaves its chord by no more than a tolerance."""

    first: int  # node of the line
    last: int
    direction: Array  # (3,) unit vector of the chord
    length: float  # of the chord [m]


def straight_sections(
    p: Array, *, tolerance_m: float, least_length_m: float
) -> tuple[StraightSection, ...]:
    """The straight pieces of a line of nodes (k, 3) in its order; short ones are left out.

    A line is split where it is farthest from its chord, until no part leaves its own by more
    than the tolerance (Douglas and Peucker 1973). The one of a line too short to have any is the
    whole line; a single point has none.
    """
    if len(p) < 2:
        return ()
    corners = _corners(p, 0, len(p) - 1, tolerance_m)
    sections = [_section(p, a, b) for a, b in itertools.pairwise(corners)]
    long = tuple(section for section in sections if section.length >= least_length_m)
    return long or (max(sections, key=lambda section: section.length),)


def _corners(p: Array, first: int, last: int, tolerance_m: float) -> list[int]:
    """Nodes at which the line is cut, both ends among them."""
    chord = p[last] - p[first]
    length = float(np.linalg.norm(chord))
    offset = p[first : last + 1] - p[first]
    if length > tolerance_m:
        offset = offset - np.outer(offset @ chord, chord) / length**2
    distance = np.linalg.norm(offset, axis=1)
    farthest = first + int(distance.argmax())
    if distance.max() <= tolerance_m or farthest in (first, last):
        return [first, last]
    before = _corners(p, first, farthest, tolerance_m)
    return before[:-1] + _corners(p, farthest, last, tolerance_m)


def _section(p: Array, first: int, last: int) -> StraightSection:
    chord = p[last] - p[first]
    length = float(np.linalg.norm(chord))
    return StraightSection(first, last, chord / max(length, 1e-12), length)
