r"""Where flat faces meet: contacts nobody made, beside the edges that real contacts imply.

A Gaussian process rounds an edge as wide as the contacts beside it are apart. But contacts that lie
in one another's tangent planes with the same normal tell of a surface that is straight from one to
the next. Taken straight on, it meets the plane of another face, and there is the edge: from contact
k through contact i along :math:`v = (c_i - c_k) / |c_i - c_k|` to the plane of a contact j at

.. math:: e = c_i + t v, \qquad t = \frac{n_j \cdot (c_j - c_i)}{n_j \cdot v}

Only convex edges are found, where c_i lies below the plane of j and c_j below that of i, and only
where j lies in a flat face and no contact nearby has e outside its tangent plane. Surfaces that
bend everywhere hold no such contacts, so that nothing is added to them.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vh_drake.gpis.evidence import kept_apart
from vh_drake.types import Array

_LEAST_COSINE = 0.5  # of a ray with the normal of the face that it meets
_LEAST_APART_M = 0.004  # contacts that are nearer tell nothing of a direction
_LEAST_WIDTH_M = 0.008  # across the contacts of a flat face; less is a line


@dataclass(frozen=True)
class EdgeSettings:
    """What counts as flat and how far faces go on; for contacts almost without noise."""

    angle_rad: float = 0.06  # between normals that are the same
    height_m: float = 0.0005  # out of a tangent plane that still is in it
    near_m: float = 0.05  # between contacts that are compared
    reach_m: float = 0.04  # how far a face goes on beyond its contacts
    beside_m: float = 0.003  # of what is added, from the edge
    apart_m: float = 0.008  # between places along edges


def edge_contacts(p: Array, n: Array, settings: EdgeSettings | None = None) -> tuple[Array, Array]:
    """Places (k, 3) on either side of the edges [m], and outward normals (k, 3) there.

    Args:
        p: (m, 3) contacts [m].
        n: (m, 3) outward unit normals.
        settings: what counts as flat.
    """
    s = settings or EdgeSettings()
    edge, way, ray, face, of = _meetings(p, n, s)
    possible = _outside_of_none(edge, p, n, s)
    order = np.argsort(way, kind="stable")
    kept = kept_apart(edge, order[possible[order]], s.apart_m)
    edge, way, ray, n_of, n_face = edge[kept], way[kept], ray[kept], n[of[kept]], n[face[kept]]
    down = np.einsum("ij,ij->i", n_of, n_face)[:, None] * n_face - n_of  # in the face, off the edge
    down /= np.linalg.norm(down, axis=1, keepdims=True)
    far = way > 1.5 * s.beside_m  # else the contact itself is beside the edge
    places = np.vstack([edge[far] - s.beside_m * ray[far], edge + s.beside_m * down])
    return places, np.vstack([n_of[far], n_face])


def _meetings(p: Array, n: Array, s: EdgeSettings) -> tuple[Array, Array, Array, Array, Array]:
    """Where rays along a surface meet flat faces.

    Returns:
        Places (k, 3), ways from the contacts before them (k,) [m], directions of the rays (k, 3),
        and indices of a contact of the face (k,) and of the one before the place (k,).
    """
    apart = p[None] - p[:, None]
    height = np.einsum("ijk,ik->ij", apart, n)  # of contact j over the plane of contact i
    same = _in_one_plane(apart, height, n, s)
    flat = np.flatnonzero([_is_wide(apart[i, same[i]]) for i in range(len(p))])
    of, behind = np.nonzero(same)
    ray = -apart[of, behind] / np.linalg.norm(apart[of, behind], axis=1, keepdims=True)
    cosine = ray @ n[flat].T
    below = -np.maximum(height[flat][:, of].T, height[of][:, flat])
    r, f = np.nonzero((cosine > _LEAST_COSINE) & (below > s.height_m))
    face, of = flat[f], of[r]
    way = -height[face, of] / cosine[r, f]
    place = p[of] + way[:, None] * ray[r]
    reached = (way < s.reach_m) & (np.linalg.norm(place - p[face], axis=1) < s.reach_m)
    return place[reached], way[reached], ray[r][reached], face[reached], of[reached]


def _in_one_plane(apart: Array, height: Array, n: Array, s: EdgeSettings) -> NDArray[np.bool_]:
    """(m, m) which contacts nearby lie in each other's tangent planes with the same normal."""
    distance = np.linalg.norm(apart, axis=2)
    near = (distance > _LEAST_APART_M) & (distance < s.near_m)
    level = np.maximum(abs(height), abs(height.T)) < s.height_m
    same: NDArray[np.bool_] = near & level & (n @ n.T > np.cos(s.angle_rad))
    return same


def _is_wide(offsets: Array) -> bool:
    """Whether contacts at offsets (k, 3) from one span a face, not only a line."""
    if len(offsets) < 2:
        return False
    return bool(np.linalg.svd(offsets, compute_uv=False)[1] > _LEAST_WIDTH_M)


def _outside_of_none(places: Array, p: Array, n: Array, s: EdgeSettings) -> NDArray[np.bool_]:
    """Which places (k, 3) lie outside the tangent plane of no contact near them (k,)."""
    offsets = places[:, None] - p[None]
    near = np.linalg.norm(offsets, axis=2) < 2.0 * s.reach_m
    outside = near & (np.einsum("ijk,jk->ij", offsets, n) > s.height_m)
    possible: NDArray[np.bool_] = ~outside.any(axis=1)
    return possible
