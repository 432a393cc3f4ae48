"""The zero set of a potential, followed cell by cell from its contacts.

Only cells that the surface passes are visited, so that the volume is never filled, and what is not
connected to a contact (the spurious sheets of the errata) is never met. Each of these cells gives
one vertex, the mean of the crossings of its edges, which a Newton step then moves onto the
surface; each crossed edge joins the four cells around it by two triangles (surface nets, Gibson
1998).
"""

from dataclasses import dataclass, field

import numba
import numpy as np

from vh_drake.errors import BadInput
from vh_drake.gpis.kernels import point_sum
from vh_drake.gpis.lattice import (
    EMPTY,
    FIRST_ROOM,
    indices,
    key_of,
    larger_table,
    new_table,
    shifts,
    slot_of,
)
from vh_drake.gpis.posterior import SCALE_M, Posterior, scaled
from vh_drake.types import Array, Immutable, IntArray

_LEAST_VALUE = 1e-6  # of a step: what is nearer to zero is rounding
_MOST_CELLS = 2**20  # along a side
_FIRST_CELLS = 1 << 12
# A corner's index has a bit for its step along each axis.
_FACES = (0b01010101, 0b00110011, 0b00001111)  # corners of the lower face across each axis
_EDGES = tuple((a, c) for a in range(3) for c in range(8) if not c >> a & 1)  # axis, corner


@dataclass(frozen=True, eq=False)
class Sheet(Immutable):
    """The part of a zero set that carries contacts, as triangles; open where it was cropped."""

    vertices: Array = field(default_factory=lambda: np.zeros((0, 3)))  # (v, 3) [m]
    normals: Array = field(default_factory=lambda: np.zeros((0, 3)))  # (v, 3) outward
    faces: IntArray = field(default_factory=lambda: np.zeros((0, 3), np.int64))  # (f, 3)


def follow_surface(
    posterior: Posterior,
    p_contacts: Array,
    *,
    spacing_m: float = 0.005,
    margin_m: float = 0.01,
) -> Sheet:
    """The estimated surface around contacts.

    The cells lie on a lattice that is fixed in space, so that vertices far from a new contact stay
    nearly where they were.

    Args:
        posterior: of the potential, negative inside.
        p_contacts: (n, 3) where the surface was touched [m]; the crop box lies around them.
        spacing_m: width of a cell [m]; vertices are about as far apart.
        margin_m: of the crop box beyond the contacts [m].

    Returns:
        Vertices on the zero set with the potential's unit gradient as outward normals, and faces
        that turn counter-clockwise seen from outside. Empty where no surface passes a contact, as
        with contacts that contradict each other entirely.

    Raises:
        BadInput: no contact, a spacing or margin that is no positive number, or a crop box of more
            than a million cells a side.
    """
    low, shape = _crop_box(p_contacts, spacing_m, margin_m)
    h = spacing_m / SCALE_M
    origin: Array = h * low.astype(float)
    near, _ = _projected(posterior, p_contacts, 2.0 * spacing_m)
    seeds = np.floor(near / spacing_m).astype(np.int64) - low
    vertices, faces = _flood(
        *scaled(posterior.kernel), posterior.columns, seeds, shape, shifts(shape), origin, h
    )
    if len(vertices) == 0:
        return Sheet()
    return Sheet(*_projected(posterior, SCALE_M * vertices, 0.5 * spacing_m), faces)


def _crop_box(p: Array, spacing_m: float, margin_m: float) -> tuple[IntArray, IntArray]:
    """Index of the first cell and number of cells along each axis."""
    if len(p) == 0:
        raise BadInput("no contact to follow a surface from; give at least one")
    if not (0 < spacing_m < np.inf and 0 < margin_m < np.inf):
        raise BadInput(f"spacing_m={spacing_m:g}, margin_m={margin_m:g}: choose positive numbers")
    low = np.floor((p.min(axis=0) - margin_m) / spacing_m)
    count = np.ceil((p.max(axis=0) + margin_m) / spacing_m) - low
    if count.max() >= _MOST_CELLS:
        raise BadInput(
            f"the contacts' box has {count.max():.3g} cells along a side; raise spacing_m "
            f"({spacing_m:g}) or drop contacts that lie far off"
        )
    return low.astype(np.int64), count.astype(np.int64)


def _projected(posterior: Posterior, p: Array, most_m: float) -> tuple[Array, Array]:
    """Points (m, 3) after a Newton step towards the zero set [m], and unit gradients.

    The gradient is that before the step: along it, its direction hardly changes.
    """
    f, gradient = posterior.mean_and_gradient(p)
    slope = np.maximum(np.linalg.norm(gradient, axis=1), 1e-300)
    normal = gradient / slope[:, None]
    return p - np.clip(f / slope, -most_m, most_m)[:, None] * normal, normal


@numba.njit(cache=True)
def _flood(
    code: int,
    length: float,
    signal2: float,
    columns: Array,
    seeds: IntArray,
    shape: IntArray,
    shift: IntArray,
    origin: Array,
    h: float,
) -> tuple[Array, IntArray]:
    """Vertices (v, 3), one a crossed cell, and faces (f, 3) of the surface through the seeds.

    A table holds the potential and the vertex of known places of the lattice.
    """
    keys, values, vertex = new_table(FIRST_ROOM)
    cells, signs = np.empty(_FIRST_CELLS, np.int64), np.empty(_FIRST_CELLS, np.int64)
    vertices, corners = np.empty((_FIRST_CELLS, 3)), np.empty(8)
    count = done = used = 0
    for seed in range(len(seeds) + 1):
        while done < count:  # what is connected to the seeds so far
            if count + 6 > len(cells):
                cells = np.concatenate((cells, np.empty_like(cells)))
                signs = np.concatenate((signs, np.empty_like(signs)))
                vertices = np.concatenate((vertices, np.empty_like(vertices)))
            if 2 * (used + 14) > len(keys):
                keys, values, vertex = larger_table(keys, values, vertex)
            cell = cells[done]
            sign, added = _read(
                code, length, signal2, columns, keys, values, cell, shift, origin, h, corners
            )
            signs[done] = sign
            _place(cell, sign, corners, shift, origin, h, vertices[done])
            count, new = _spread(keys, vertex, cells, cell, sign, shape, shift, count)
            used += added + new
            done += 1
        for n in range(27 if seed < len(seeds) else 0):  # its own cell, else the first neighbour
            if 2 * (used + 8) > len(keys):
                keys, values, vertex = larger_table(keys, values, vertex)
            cell = _neighbour(seeds[seed], n, shift)
            if not _inside(cell, shape, shift):
                continue
            sign, added = _read(
                code, length, signal2, columns, keys, values, cell, shift, origin, h, corners
            )
            used += added
            if 0 < sign < 255:
                count, _ = _queue(keys, vertex, cells, cell, count)
                break
    return vertices[:count].copy(), _faces(keys, vertex, cells[:count], signs, shift)


@numba.njit(cache=True)
def _neighbour(seed: IntArray, n: int, shift: IntArray) -> int:
    """The n-th of the 27 cells around one, itself first."""
    i, j, k = (n + 1) % 3 - 1, (n // 3 + 1) % 3 - 1, (n // 9 + 1) % 3 - 1
    return key_of(seed[0] + i, seed[1] + j, seed[2] + k, shift)


@numba.njit(cache=True)
def _spread(
    keys: IntArray,
    vertex: IntArray,
    cells: IntArray,
    cell: int,
    sign: int,
    shape: IntArray,
    shift: IntArray,
    count: int,
) -> tuple[int, int]:
    """Queue the neighbours across faces that the surface passes; how many are queued and new."""
    new = 0
    for axis in range(3):
        for side in range(2):
            face = _FACES[axis] << side * (1 << axis)
            if sign & face == 0 or sign & face == face:
                continue
            other = cell + (2 * side - 1 << shift[axis])
            if _inside(other, shape, shift):
                count, added = _queue(keys, vertex, cells, other, count)
                new += added
    return count, new


@numba.njit(cache=True)
def _queue(
    keys: IntArray, vertex: IntArray, cells: IntArray, cell: int, count: int
) -> tuple[int, int]:
    """Give a cell its vertex unless it has one; how many there are and how many places are new."""
    slot = slot_of(keys, cell)
    added = 1 if keys[slot] == EMPTY else 0
    keys[slot] = cell
    if vertex[slot] >= 0:
        return count, added
    vertex[slot] = count
    cells[count] = cell
    return count + 1, added


@numba.njit(cache=True)
def _place(
    cell: int,
    sign: int,
    corners: Array,
    shift: IntArray,
    origin: Array,
    h: float,
    vertex: Array,
) -> None:
    """Put a vertex at the mean of the places where the edges of its cell cross zero."""
    x = y = z = 0.0
    count = 0
    for e in range(12):
        axis, c = _EDGES[e]
        other = c | (1 << axis)
        if (sign >> c ^ sign >> other) & 1 == 0:
            continue
        t = corners[c] / (corners[c] - corners[other])
        x += t if axis == 0 else c & 1
        y += t if axis == 1 else c >> 1 & 1
        z += t if axis == 2 else c >> 2
        count += 1
    i, j, k = indices(cell, shift)
    vertex[0] = origin[0] + h * (i + x / count)
    vertex[1] = origin[1] + h * (j + y / count)
    vertex[2] = origin[2] + h * (k + z / count)


@numba.njit(cache=True)
def _faces(
    keys: IntArray, vertex: IntArray, cells: IntArray, signs: IntArray, shift: IntArray
) -> IntArray:
    """Two triangles for each crossed edge whose four cells have vertices."""
    faces, count = np.empty((6 * len(cells), 3), np.int64), 0
    for v in range(len(cells)):
        first = signs[v] & 1
        for axis in range(3):
            if first == signs[v] >> (1 << axis) & 1:
                continue
            back = 1 << shift[(axis + 1) % 3]  # along the next axis
            down = 1 << shift[(axis + 2) % 3]  # along the one after it
            b = _vertex_at(keys, vertex, cells[v] - back)  # counter-clockwise about the edge
            c = _vertex_at(keys, vertex, cells[v] - back - down)
            d = _vertex_at(keys, vertex, cells[v] - down)
            if min(b, c, d) < 0:
                continue
            faces[count] = (v, b, c) if first else (v, c, b)
            faces[count + 1] = (v, c, d) if first else (v, d, c)
            count += 2
    return faces[:count].copy()


@numba.njit(cache=True)
def _vertex_at(keys: IntArray, vertex: IntArray, cell: int) -> int:
    slot = slot_of(keys, cell)
    return vertex[slot] if keys[slot] == cell else -1


@numba.njit(cache=True)
def _read(
    code: int,
    length: float,
    signal2: float,
    columns: Array,
    keys: IntArray,
    values: Array,
    cell: int,
    shift: IntArray,
    origin: Array,
    h: float,
    corners: Array,
) -> tuple[int, int]:
    """Values at the corners of a cell; which are negative, and how many places are new.

    Bit a of a corner's index is its step along axis a; bit c of the first result is the sign of
    corner c.
    """
    sign = added = 0
    for c in range(8):
        node = cell + ((c & 1) << shift[0]) + ((c >> 1 & 1) << shift[1]) + (c >> 2)
        slot = slot_of(keys, node)
        if keys[slot] == EMPTY:
            keys[slot] = node
            added += 1
        if np.isnan(values[slot]):
            i, j, k = indices(node, shift)
            x, y, z = origin[0] + h * i, origin[1] + h * j, origin[2] + h * k
            values[slot] = point_sum(code, length, signal2, x, y, z, columns)[0]
        corners[c] = values[slot]
        sign |= int(values[slot] < -_LEAST_VALUE * h) << c
    return sign, added


@numba.njit(cache=True)
def _inside(cell: int, shape: IntArray, shift: IntArray) -> bool:
    i, j, k = indices(cell, shift)
    return bool(0 <= i < shape[0] and 0 <= j < shape[1] and 0 <= k < shape[2])
