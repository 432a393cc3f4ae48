r"""What the metric sees of a grasp (sections 4.3 and 4.3.3): a voxel grid and a pose.

The grid has 32³ voxels and a side of 30 cm, and is aligned with the hand. Each voxel holds

1. the distance of its centre to the nearest fused point, camera's or contact's, and
2. the implicit surface potential of the estimate, negative inside,

both bounded and divided by the bound. They are computed once a scene on a grid of the world
(`scene_fields`) and resampled for all candidates (`sample_grids`); `exact_grid` computes the same
without the detour.

The pose is that of the hand relative to the object's centre, the top three rows of the matrix,
with a few numbers about motion and scene. What the conventional metrics say of the grasp on the
estimate may come along (`hints`): the metric then combines both (section 5.2).
"""

from dataclasses import dataclass

import numpy as np
import torch
from numba import njit
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from vh_drake.errors import BadInput
from vh_drake.geometry.signed_distance import interpolate
from vh_drake.learning.hints import HINT_NUMBERS, Hints, hint_inputs
from vh_drake.types import Array, Candidates, ContactSet, ObjectView, Plane, Surface

VOXELS = 32
SIDE_M = 0.3
BOUND_M = 0.06  # of distance and potential
CHANNELS = 2
SPACING_M = 0.0075  # of the fields of a scene
NUMBERS = 17 + HINT_NUMBERS
_TRANSLATION_M = 0.1  # one unit of translations and heights
_SIZE_M = 0.1
_FAR = 1e9  # voxels; more than any row has, and finite, as fast arithmetic wants it

Float32 = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class SceneFields:
    """Bounded distance and potential on a grid that covers all that is within the bound."""

    origin: Array  # (3,) first node [m]
    spacing: float  # [m]
    values: Float32  # (2, nx, ny, nz), scaled: distance in 0..1, potential in -1..1
    center: Array  # (3,) of the estimated object [m]
    size: Array  # (3,) sides of its box [m]
    table: Plane
    contacts: int  # touches that count


def scene_fields(
    view: ObjectView, contacts: ContactSet, surface: Surface, *, spacing_m: float = SPACING_M
) -> SceneFields:
    """The fields of a scene.

    Raises:
        BadInput: the surface is empty, or there is neither point nor contact.
    """
    if len(surface.faces) == 0:
        raise BadInput("the estimated surface is empty; add points or contacts first")
    fused = fused_points(view, contacts)
    low = np.minimum(fused.min(axis=0), surface.vertices.min(axis=0)) - BOUND_M - spacing_m
    high = np.maximum(fused.max(axis=0), surface.vertices.max(axis=0)) + BOUND_M + spacing_m
    shape = np.ceil((high - low) / spacing_m).astype(int) + 1
    axes = [low[i] + spacing_m * np.arange(shape[i]) for i in range(3)]
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    values = _features(nodes, fused, surface).reshape(CHANNELS, *shape)
    middle = (surface.vertices.max(axis=0) + surface.vertices.min(axis=0)) / 2
    return SceneFields(
        origin=low,
        spacing=spacing_m,
        values=values,
        center=middle,
        size=np.ptp(surface.vertices, axis=0),
        table=view.table,
        contacts=len(contacts),
    )


def fused_points(view: ObjectView, contacts: ContactSet) -> Array:
    """Points of the camera and of touches, (n, 3) [m].

    Raises:
        BadInput: there is none.
    """
    points = np.vstack([view.p_WO, contacts.p_WC])
    if len(points) == 0:
        raise BadInput("neither camera points nor contacts; give at least one")
    return points


def voxel_centers() -> Array:
    """Centres (32³, 3) of the voxels in the hand's frame, the last axis fastest [m]."""
    axis = (np.arange(VOXELS) + 0.5) * (SIDE_M / VOXELS) - SIDE_M / 2
    return np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)


def exact_grid(view: ObjectView, contacts: ContactSet, surface: Surface, X_WH: Array) -> Float32:
    """The grid (2, 32, 32, 32) of one pose (4, 4), each voxel by itself."""
    points = voxel_centers() @ X_WH[:3, :3].T + X_WH[:3, 3]
    values = _features(points, fused_points(view, contacts), surface)
    return values.reshape(CHANNELS, VOXELS, VOXELS, VOXELS)


def sample_grids(fields: SceneFields, X_WH: Array) -> torch.Tensor:
    """Grids (n, 2, 32, 32, 32) of poses (n, 4, 4), by trilinear interpolation.

    Compiled, since here that is two to nine times faster than `torch`'s `grid_sample`, with the
    same result; the channels lie innermost in memory, as convolutions on a CPU want them.
    """
    step = SIDE_M / VOXELS
    axes = X_WH[:, :3, :3] * (step / fields.spacing)
    corner = np.full(3, (step - SIDE_M) / 2)  # centre of the first voxel in H
    first = (X_WH[:, :3, :3] @ corner + X_WH[:, :3, 3] - fields.origin) / fields.spacing
    volume = np.ascontiguousarray(np.moveaxis(fields.values, 0, -1), np.float32)
    grids = np.empty((len(X_WH), VOXELS, VOXELS, VOXELS, CHANNELS), np.float32)
    _sample(volume, axes.astype(np.float32), first.astype(np.float32), grids)
    return torch.from_numpy(grids).permute(0, 4, 1, 2, 3)


@njit(cache=True, fastmath=True)
def _sample(volume: Float32, axes: Float32, first: Float32, grids: Float32) -> None:
    """Interpolate a volume (nx, ny, nz, c) along rows of voxels; 1 beyond it.

    `first` (n, 3) is the first voxel's place in units of the volume's spacing, the columns of
    `axes` (n, 3, 3) the steps from voxel to voxel.
    """
    channels = volume.shape[3]
    low, high = np.empty(3, np.float32), np.empty(3, np.float32)
    for n in range(len(first)):
        A, b = axes[n], first[n]
        for i in range(VOXELS):
            for j in range(VOXELS):
                row = grids[n, i, j]
                x = b[0] + i * A[0, 0] + j * A[0, 1]
                y = b[1] + i * A[1, 0] + j * A[1, 1]
                z = b[2] + i * A[2, 0] + j * A[2, 1]
                for axis, start in ((0, x), (1, y), (2, z)):
                    low[axis], high[axis] = _inside(start, A[axis, 2], volume.shape[axis] - 1)
                begin = int(np.ceil(min(max(low.max(), 0.0), VOXELS)))
                end = int(np.floor(max(min(high.min(), VOXELS - 1.0), -1.0))) + 1
                if end <= begin:
                    row[:] = 1
                    continue
                row[:begin] = 1
                row[end:] = 1
                for k in range(begin, end):
                    u, v, w = x + k * A[0, 2], y + k * A[1, 2], z + k * A[2, 2]
                    p, q, r = np.uintp(u), np.uintp(v), np.uintp(w)
                    u, v, w = u - p, v - q, w - r
                    for c in range(channels):
                        a = volume[p, q, r, c] * (1 - w) + volume[p, q, r + 1, c] * w
                        d = volume[p, q + 1, r, c] * (1 - w) + volume[p, q + 1, r + 1, c] * w
                        e = volume[p + 1, q, r, c] * (1 - w) + volume[p + 1, q, r + 1, c] * w
                        f = volume[p + 1, q + 1, r, c] * (1 - w)
                        f += volume[p + 1, q + 1, r + 1, c] * w
                        a, e = a * (1 - v) + d * v, e * (1 - v) + f * v
                        row[k, c] = a * (1 - u) + e * u


@njit(inline="always")
def _inside(start: float, step: float, last: int) -> tuple[float, float]:
    """Between which (real) steps a walk stays within 0 and `last`; reversed where it never is."""
    top = float(last) - 1e-3
    if abs(step) < 1e-9:
        return (-_FAR, _FAR) if 0 <= start <= top else (_FAR, -_FAR)
    enter, leave = -start / step, (top - start) / step
    return min(enter, leave), max(enter, leave)


def pose_inputs(fields: SceneFields, candidates: Candidates, hints: Hints | None = None) -> Float32:
    """Numbers (n, 28) about each candidate beside its grid.

    The pose relative to the object's centre (12), the motion (1 for "side"), the height of that
    centre and of the hand over the table, the object's largest side, how much was touched; then
    the hints, see `hints.hint_inputs`.
    """
    relative = candidates.X_WH[:, :3].copy()
    relative[:, :, 3] = (relative[:, :, 3] - fields.center) / _TRANSLATION_M
    count = len(candidates)
    side = np.array([name == "side" for name in candidates.motion], float)
    numbers = np.column_stack(
        [
            relative.reshape(count, 12),
            side,
            np.full(count, fields.table.height(fields.center) / _TRANSLATION_M),
            fields.table.height(candidates.X_WH[:, :3, 3]) / _TRANSLATION_M,
            np.full(count, fields.size.max() / _SIZE_M),
            np.full(count, min(fields.contacts, 5) / 5),
            hint_inputs(hints, count),
        ]
    )
    return numbers.astype(np.float32)


def _features(points: Array, fused: Array, surface: Surface) -> Float32:
    """Both channels (2, n) at points (n, 3)."""
    distance = cKDTree(fused).query(points, distance_upper_bound=BOUND_M)[0]
    potential = interpolate(surface.potential, points)[0]
    bounded = np.stack([np.minimum(distance, BOUND_M), np.clip(potential, -BOUND_M, BOUND_M)])
    return (bounded / BOUND_M).astype(np.float32)
