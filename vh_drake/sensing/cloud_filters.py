"""Filters on point clouds: downsampling, clusters, normals, smoothing."""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

from vh_drake.types import Array, IntArray


def voxel_downsample(p_W: Array, voxel_m: float) -> Array:
    """The mean of the points in every occupied cell of a grid, in a fixed order.

    Args:
        p_W: (n, 3) points [m].
        voxel_m: edge of the cells [m].

    Returns:
        (m, 3) points [m], m <= n.
    """
    if len(p_W) == 0:
        return p_W
    _, cell = np.unique(_flat_cells(p_W, voxel_m), return_inverse=True)
    count = np.bincount(cell)
    sums = [np.bincount(cell, weights=p_W[:, axis]) for axis in range(3)]
    mean: Array = np.stack(sums, axis=1) / count[:, None]
    return mean


def _flat_cells(p_W: Array, cell_m: float) -> IntArray:
    cells = np.floor((p_W - p_W.min(axis=0)) / cell_m).astype(np.int64)
    size = cells.max(axis=0) + 1
    flat: IntArray = (cells[:, 0] * size[1] + cells[:, 1]) * size[2] + cells[:, 2]
    return flat


@dataclass(frozen=True, eq=False)
class Clusters:
    """Connected parts of a cloud; label -1 marks outliers."""

    label: IntArray  # (n,) of each point
    number: int


def cluster(p_W: Array, *, cell_m: float = 0.01, min_points: int = 4) -> Clusters:
    """Joins points whose cells lie within two cells of each other.

    Cells that hold fewer than `min_points` points are outliers. All is done on a grid, so
    the cost is linear in points and volume.

    Args:
        p_W: (n, 3) points [m].
        cell_m: edge of the cells [m]; gaps below twice of it are bridged.
        min_points: the least points of a cell that counts.

    Returns:
        A label a point.
    """
    if len(p_W) == 0:
        return Clusters(np.zeros(0, np.int64), 0)
    cells = np.floor((p_W - p_W.min(axis=0)) / cell_m).astype(np.int64) + 1
    count = np.zeros(tuple(cells.max(axis=0) + 2), np.int32)
    np.add.at(count, tuple(cells.T), 1)
    dense = count >= min_points
    cube = np.ones((3, 3, 3), bool)
    labels, number = ndimage.label(ndimage.binary_dilation(dense, cube), cube)
    index = tuple(cells.T)
    label = np.where(dense[index], labels[index].astype(np.int64) - 1, -1)
    return Clusters(label, int(number))


@dataclass(frozen=True, eq=False)
class LocalPlanes:
    """The plane that fits each point's neighbourhood best."""

    normal: Array  # (n, 3) unit, of either sign
    centre: Array  # (n, 3) mean of the neighbours [m]
    variance: Array  # (n,) of the neighbours about the plane [m^2]


def local_planes(p_W: Array, *, radius_m: float, neighbours: int = 32) -> LocalPlanes:
    """Principal components of each point's nearest neighbours (Hoppe et al. 1992).

    Args:
        p_W: (n, 3) points [m], at least 3.
        radius_m: neighbours lie within this distance [m].
        neighbours: at most so many are used.

    Returns:
        Normal, centre and variance of each neighbourhood; points with fewer than two
        neighbours get an arbitrary normal.
    """
    k = min(neighbours, len(p_W))
    _, index = cKDTree(p_W).query(p_W, k=k, distance_upper_bound=radius_m)
    found = index < len(p_W)
    weight = found[..., None] / found.sum(axis=1)[:, None, None]
    near = p_W[np.where(found, index, 0)]
    centre = (near * weight).sum(axis=1)
    spread = (near - centre[:, None]) * np.sqrt(weight)
    values, vectors = np.linalg.eigh(np.einsum("nki,nkj->nij", spread, spread))
    return LocalPlanes(vectors[:, :, 0], centre, np.maximum(values[:, 0], 0.0))


def towards(normals: Array, p_W: Array, p_WCamera: Array) -> Array:
    """The normals (n, 3) at points (n, 3), turned to the side where the camera stands."""
    facing = np.einsum("ij,ij->i", normals, p_WCamera - p_W) >= 0.0
    return np.where(facing[:, None], normals, -normals)


def smooth(p_W: Array, planes: LocalPlanes, noise_m: float) -> Array:
    """Moves points towards their local planes by the share of the variance that is noise.

    As a Wiener filter does: where the neighbourhood varies no more than the sensor's noise,
    the surface is flat and the point goes onto the plane; at edges it stays.

    Args:
        p_W: (n, 3) points [m].
        planes: their local planes.
        noise_m: standard deviation of the sensor along the normal [m].

    Returns:
        (n, 3) points [m].
    """
    share = np.minimum(1.0, noise_m**2 / np.maximum(planes.variance, 1e-18))
    offset = np.einsum("ij,ij->i", planes.centre - p_W, planes.normal)
    moved: Array = p_W + (share * offset)[:, None] * planes.normal
    return moved
