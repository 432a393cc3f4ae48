"""How well an estimate follows the sharp edges of a box, as a number and as a picture."""

import itertools

import numpy as np
from matplotlib import colormaps
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

from vh_drake.geometry.closest_points import closest_points, triangle_tree
from vh_drake.geometry.meshes import TriMesh
from vh_drake.types import Array

WORST_M = 0.02  # drawn red
_PER_EDGE = 24
_CM = 100.0


def box_edges(size: tuple[float, float, float]) -> Array:
    """Points (m, 3) on the edges of a box that stands on z = 0, as `lathe.box` [m]."""
    share = np.linspace(-0.5, 0.5, _PER_EDGE)
    points = []
    for axis in range(3):
        for signs in itertools.product((-0.5, 0.5), repeat=2):
            points.append(np.insert(np.tile(signs, (_PER_EDGE, 1)), axis, share, axis=1))
    edges: Array = (np.vstack(points) + np.array([0.0, 0.0, 0.5])) * np.asarray(size)
    return edges


def edge_rmse(estimate: TriMesh, edges: Array) -> float:
    """Root mean square distance of points on the edges (m, 3) to an estimate [m]."""
    nearest = closest_points(triangle_tree(estimate), edges)
    return float(np.sqrt(np.mean(np.sum((nearest - edges) ** 2, axis=1))))


def draw_edges(axes: Axes3D, estimate: TriMesh, edges: Array, p_contacts: Array) -> None:
    """The estimate, its contacts, and a coloured line from each edge point to the estimate."""
    faces = Poly3DCollection(_CM * estimate.triangles, facecolors=[(0.75, 0.78, 0.82)], shade=True)
    faces.set_alpha(0.55)
    axes.add_collection3d(faces)
    nearest = closest_points(triangle_tree(estimate), edges)
    share = np.linalg.norm(nearest - edges, axis=1) / WORST_M
    colors = colormaps["RdYlGn_r"](np.clip(share, 0.0, 1.0))
    lines = Line3DCollection(_CM * np.stack([edges, nearest], axis=1), colors=colors, linewidths=3)
    axes.add_collection3d(lines)
    axes.scatter(*(_CM * edges).T, s=4, c=colors, depthshade=False)
    axes.scatter(*(_CM * p_contacts).T, s=16, c="tab:blue", depthshade=False)
    low, high = _CM * edges.min(axis=0), _CM * edges.max(axis=0)
    axes.set(xlabel="x [cm]", ylabel="y [cm]", zlabel="z [cm]")
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_box_aspect(high - low)
