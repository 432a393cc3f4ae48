"""Where the table is: the largest horizontal plane of a cloud."""

import numpy as np
from numpy.typing import NDArray

from vh_drake.errors import NothingSeen
from vh_drake.types import Array, Plane


def fit_table(
    p_W: Array,
    rng: np.random.Generator,
    *,
    inlier_m: float = 0.006,
    max_tilt_deg: float = 10.0,
    min_share: float = 0.15,
    hypotheses: int = 300,
) -> tuple[Plane, float]:
    """RANSAC (Fischler & Bolles 1981) over nearly horizontal planes, then least squares.

    Args:
        p_W: (n, 3) finite points [m].
        rng: draws the samples; the same state gives the same plane.
        inlier_m: distance [m] up to which a point supports a plane.
        max_tilt_deg: planes that lean more are no table.
        min_share: share of the points that must lie on the table.
        hypotheses: planes tried.

    Returns:
        The plane, its normal up, and the standard deviation [m] of the points about it.

    Raises:
        NothingSeen: no horizontal plane holds enough points.
    """
    sample = p_W[rng.choice(len(p_W), min(len(p_W), 20_000), replace=False)]
    normals, offsets = _hypotheses(sample, rng, np.cos(np.deg2rad(max_tilt_deg)), hypotheses)
    if len(normals) == 0:
        raise NothingSeen(_no_table(len(p_W), 0.0, min_share))
    few = sample[:4000]
    support = np.count_nonzero(np.abs(few @ normals.T - offsets) < inlier_m, axis=0)
    best = int(support.argmax())
    share = support[best] / len(few)
    if share < min_share:
        raise NothingSeen(_no_table(len(p_W), share, min_share))
    plane = Plane(normals[best], float(offsets[best]))
    for _ in range(3):
        plane = _least_squares(sample[np.abs(plane.height(sample)) < inlier_m])
    return plane, _spread(plane.height(sample), inlier_m)


def _no_table(points: int, share: float, min_share: float) -> str:
    return (
        f"no table: the largest horizontal plane holds {100 * share:.0f} % of {points} points, "
        f"{100 * min_share:.0f} % are needed; show the camera more of the table"
    )


def _hypotheses(
    p_W: Array, rng: np.random.Generator, min_up: float, number: int
) -> tuple[Array, NDArray[np.float64]]:
    """Planes through three random points each, those that lean too much dropped."""
    a, b, c = (p_W[rng.integers(len(p_W), size=number)] for _ in range(3))
    normals = np.cross(b - a, c - a)
    norms = np.linalg.norm(normals, axis=1)
    # Neighbouring points give planes that noise tilts, so they don't count.
    normals = normals[norms > 1e-4] / norms[norms > 1e-4, None]
    normals *= np.where(normals[:, 2:] < 0.0, -1.0, 1.0)
    up = normals[:, 2] > min_up
    normals, a = normals[up], a[norms > 1e-4][up]
    return normals, np.einsum("ij,ij->i", normals, a)


def _least_squares(p_W: Array) -> Plane:
    centre = p_W.mean(axis=0)
    _, vectors = np.linalg.eigh(np.cov((p_W - centre).T))
    normal = vectors[:, 0] * np.sign(vectors[2, 0] or 1.0)
    return Plane(normal, float(normal @ centre))


def _spread(height: Array, inlier_m: float) -> float:
    """Standard deviation from the median absolute deviation of what lies near the plane."""
    near = height[np.abs(height) < 2.0 * inlier_m]
    return float(1.4826 * np.median(np.abs(near)))
