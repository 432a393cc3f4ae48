"""Depth images of triangles on the CPU, for machines that cannot render."""

import numpy as np
from numba import njit

from vh_drake.sensing.intrinsics import Intrinsics
from vh_drake.types import Array


def cast_depth(
    triangles_C: Array,
    intrinsics: Intrinsics,
    *,
    min_depth_m: float = 0.3,
    max_depth_m: float = 3.0,
) -> Array:
    """Depth along the optical axis of the nearest triangle in every pixel.

    Each triangle meets the rays of the pixels inside its projection's bounding box, so the
    cost follows the area that is seen, and no search structure is needed.

    Args:
        triangles_C: (n, 3, 3) corners in the optical frame C [m]; both sides are seen.
        intrinsics: the camera.
        min_depth_m: nearer hits give 0, as Drake's depth images have it.
        max_depth_m: farther hits and misses give infinity.

    Returns:
        (height, width) depth [m].
    """
    depth = np.full((intrinsics.height, intrinsics.width), np.inf)
    finite = triangles_C[np.isfinite(triangles_C).all(axis=(1, 2))]
    _cast(
        np.ascontiguousarray(finite, dtype=float),
        intrinsics.fx,
        intrinsics.fy,
        intrinsics.cx,
        intrinsics.cy,
        depth,
    )
    depth[depth > max_depth_m] = np.inf
    depth[depth < min_depth_m] = 0.0
    return depth


@njit(cache=True)
def _cast(triangles: Array, fx: float, fy: float, cx: float, cy: float, depth: Array) -> None:
    """Lowers `depth` to the nearest hit of each pixel's ray."""
    height, width = depth.shape
    for i in range(triangles.shape[0]):
        a, b, c = triangles[i, 0], triangles[i, 1], triangles[i, 2]
        u_0, u_1, v_0, v_1 = _pixels(triangles[i], fx, fy, cx, cy, width, height)
        # Ray d meets the plane at z with z * (d . n) = a . n; inside where the three
        # triple products d . (p x q) of the edges share their sign.
        n_ab, n_bc, n_ca = np.cross(a, b), np.cross(b, c), np.cross(c, a)
        n = n_ab + n_bc + n_ca
        volume = a[0] * n[0] + a[1] * n[1] + a[2] * n[2]
        for v in range(v_0, v_1):
            y = (v - cy) / fy
            for u in range(u_0, u_1):
                x = (u - cx) / fx
                s_ab = x * n_ab[0] + y * n_ab[1] + n_ab[2]
                s_bc = x * n_bc[0] + y * n_bc[1] + n_bc[2]
                s_ca = x * n_ca[0] + y * n_ca[1] + n_ca[2]
                inside = (s_ab >= 0.0 and s_bc >= 0.0 and s_ca >= 0.0) or (
                    s_ab <= 0.0 and s_bc <= 0.0 and s_ca <= 0.0
                )
                slope = s_ab + s_bc + s_ca  # d . n
                if not inside or slope == 0.0:
                    continue
                z = volume / slope
                if 0.0 < z < depth[v, u]:
                    depth[v, u] = z


@njit(cache=True)
def _pixels(
    triangle: Array, fx: float, fy: float, cx: float, cy: float, width: int, height: int
) -> tuple[int, int, int, int]:
    """Half-open pixel ranges (u_0, u_1, v_0, v_1) that a triangle can cover."""
    near = 1e-3
    z = triangle[:, 2]
    if z.max() < near:
        return 0, 0, 0, 0
    if z.min() < near:  # It crosses the image plane: every pixel may see it.
        return 0, width, 0, height
    u = triangle[:, 0] / z * fx + cx
    v = triangle[:, 1] / z * fy + cy
    u_0, u_1 = max(0.0, np.floor(u.min())), min(float(width), np.floor(u.max()) + 2.0)
    v_0, v_1 = max(0.0, np.floor(v.min())), min(float(height), np.floor(v.max()) + 2.0)
    if u_0 >= u_1 or v_0 >= v_1:
        return 0, 0, 0, 0
    return int(u_0), int(u_1), int(v_0), int(v_1)
