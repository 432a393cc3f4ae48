"""Camera points and contacts, checked and thinned out before they enter an estimate."""

import numba
import numpy as np
from scipy.spatial.distance import cdist

from vh_drake.errors import BadInput
from vh_drake.types import Array, ContactSet, IntArray, ObjectView


@numba.njit(cache=True)
def _farthest_points(p: Array, count: int) -> IntArray:
    chosen = np.zeros(count, np.int64)
    distance2 = np.full(len(p), np.inf)
    for i in range(1, count):
        last = p[chosen[i - 1]]
        for j in range(len(p)):
            dx, dy, dz = p[j, 0] - last[0], p[j, 1] - last[1], p[j, 2] - last[2]
            distance2[j] = min(distance2[j], dx * dx + dy * dy + dz * dz)
        chosen[i] = np.argmax(distance2)
    return chosen


def farthest_points(p: Array, count: int) -> IntArray:
    """Indices of at most `count` points (n, 3) that cover the set evenly, from the first on."""
    if len(p) <= count:
        return np.arange(len(p), dtype=np.int64)
    chosen: IntArray = _farthest_points(np.ascontiguousarray(p), count)
    return chosen


def kept_apart(p: Array, order: IntArray, apart_m: float) -> IntArray:
    """Those of an order of points that keep a distance from all earlier ones."""
    kept: list[int] = []
    for i in order:
        if not kept or cdist(p[i : i + 1], p[kept]).min() >= apart_m:
            kept.append(int(i))
    return np.array(kept, dtype=np.int64)


def require_finite(view: ObjectView, contacts: ContactSet) -> None:
    """Check what a user or a sensor gave.

    Raises:
        BadInput: shapes that do not fit, or numbers that are not finite.
    """
    pairs = {"object points": (view.p_WO, view.n_WO), "contacts": (contacts.p_WC, contacts.n_WC)}
    for name, (p, n) in pairs.items():
        if p.shape != n.shape or p.ndim != 2 or p.shape[1] != 3:
            raise BadInput(
                f"{name} of shape {p.shape} with normals of shape {n.shape}; give (n, 3)"
            )
        if not (np.isfinite(p).all() and np.isfinite(n).all()):
            raise BadInput(f"{name} hold NaN or infinite numbers; drop these points")
        if len(n) and np.abs(np.linalg.norm(n, axis=1) - 1.0).max() > 0.01:
            raise BadInput(f"normals of {name} are not of unit length; normalise them")
    if len(view.p_WO) + len(contacts) == 0:
        raise BadInput("neither object points nor contacts; give at least one")
