"""A hand in a picture: each link as the convex hull of the spheres that stand for it."""

import numpy as np
import trimesh
from matplotlib.colors import to_rgb
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from vh_drake.geometry.glyphs import ColorMesh, joined
from vh_drake.hand.model import HandModel
from vh_drake.types import Array

PALM, FINGERS, THUMB = "0.45", "0.65", "tab:blue"
_ROUND = 1  # subdivisions of an icosahedron


def hand_mesh(hand: HandModel, angles: Array, X_WH: Array) -> ColorMesh:
    """The hand in W at joint angles (n,): palm dark, fingers light, thumbs blue."""
    X_WL = X_WH @ _square(hand.link_poses(angles))
    parts = []
    for link, X in enumerate(X_WL):
        hull = _link_hull(hand, link)
        if hull is None:
            continue
        finger = int(hand.finger_of_link[link])
        name = PALM if finger < 0 else THUMB if hand.opposing[finger] else FINGERS
        p = np.asarray(hull.vertices) @ X[:3, :3].T + X[:3, 3]
        colors = np.tile(to_rgb(name), (len(p), 1))
        parts.append(ColorMesh(p, np.asarray(hull.faces, np.int64), colors))
    return joined(parts)


def _square(X: Array) -> Array:
    """Poses (k, 4, 4) of rows (k, 3, 4) or (k, 4, 4)."""
    last = np.tile([[[0.0, 0.0, 0.0, 1.0]]], (len(X), 1, 1))
    return np.concatenate([X[:, :3], last], axis=1)


def _link_hull(hand: HandModel, link: int) -> trimesh.Trimesh | None:
    """Around a link's spheres, in its frame; None for a link without any."""
    first = hand.arrays.first_sphere
    own = slice(first[link], first[link + 1])
    centers, radii = hand.arrays.sphere_center[own], hand.arrays.sphere_radius[own]
    if len(centers) == 0:
        return None
    ball = np.asarray(trimesh.creation.icosphere(subdivisions=_ROUND).vertices)
    points = centers[:, None] + radii[:, None, None] * ball
    return trimesh.convex.convex_hull(points.reshape(-1, 3))


def draw_solids(axes: Axes3D, mesh: ColorMesh) -> None:
    """Triangles in one collection, so that what is in front hides what is behind."""
    faces = Poly3DCollection(
        mesh.vertices[mesh.faces],
        facecolors=mesh.colors[mesh.faces].mean(axis=1),
        shade=True,
        antialiased=False,  # blended edges would let what is behind shine through
    )
    axes.add_collection3d(faces)
