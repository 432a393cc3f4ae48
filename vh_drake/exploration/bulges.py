r"""Where an estimate bulges out beyond what was touched.

An estimate that joins both faces of a thin shell, or rounds an edge it hardly knows, hangs over the
surface that carries its contacts. There a place lies far outside the tangent plane of a contact
nearby:

.. math:: b(p) = \max_{|p - c_i| < r} n_i \cdot (p - c_i)

with contacts c and outward normals n. In trials three of five touches that were meant for such
places passed them by, and one of five elsewhere. A concave corner, where the surface truly rises
so, looks the same; hence such places are put off, not given up.
"""

import numpy as np
from numba import njit

from vh_drake.types import Array, ContactSet


def bulge(p: Array, contacts: ContactSet, *, within_m: float) -> Array:
    """How far places lie outside the tangent planes of contacts nearby, b.

    Args:
        p: (m, 3) places [m].
        contacts: with outward unit normals.
        within_m: r, from where on a contact does not count.

    Returns:
        (m,) [m], negative inside all of them, -inf where no contact is so near.
    """
    heights: Array = _bulge(np.ascontiguousarray(p), contacts.p_WC, contacts.n_WC, within_m**2)
    return heights


@njit(cache=True)
def _bulge(p: Array, c: Array, n: Array, within2: float) -> Array:
    highest = np.full(len(p), -np.inf)
    for i in range(len(p)):
        for j in range(len(c)):
            x, y, z = p[i, 0] - c[j, 0], p[i, 1] - c[j, 1], p[i, 2] - c[j, 2]
            if x * x + y * y + z * z < within2:
                highest[i] = max(highest[i], x * n[j, 0] + y * n[j, 1] + z * n[j, 2])
    return highest
