"""Explorations in pictures, with the colours of table 3.4.

Contacts are blue with their normals, the way of the fingertip is a blue curve, the estimate grey,
the true object yellow, candidates red to green by rating. Lengths are drawn in centimetres.
"""

from collections.abc import Iterable

import numpy as np
from matplotlib import colormaps
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

from vh_drake.exploration.trajectory import position
from vh_drake.types import Array, IntArray

CM = 100.0
_TRUTH, _ESTIMATE, _BLUE = "gold", "0.6", "tab:blue"
_NORMAL_M = 0.012
_STEPS = 20  # of a drawn curve


def curve_points(control_points: Array, tau: float = 1.0) -> Array:
    """Points (k, 3) along a Bezier curve (4, 3) up to τ [m]."""
    return np.array([position(control_points, t) for t in np.linspace(0.0, tau, _STEPS)])


def way_points(curves: Iterable[tuple[Array, float]]) -> Array:
    """Points (k, 3) along touches, each with control points (c, 4, 3) and the τ of its last one."""
    pieces = [
        curve_points(one, tau if i == len(control) - 1 else 1.0)
        for control, tau in curves
        for i, one in enumerate(control)
    ]
    return np.vstack(pieces) if pieces else np.zeros((0, 3))


def draw_truth(axes: Axes3D, triangles: Array, *, alpha: float = 0.35) -> None:
    """The true object from triangles (f, 3, 3) [m]."""
    _draw_faces(axes, triangles, _TRUTH, alpha)


def draw_estimate(axes: Axes3D, vertices: Array, faces: IntArray, *, alpha: float = 0.6) -> None:
    """The estimate from vertices (v, 3) [m] and faces (f, 3)."""
    _draw_faces(axes, vertices[faces], _ESTIMATE, alpha)


def draw_colored(axes: Axes3D, vertices: Array, faces: IntArray, values: Array, top: float) -> None:
    """A surface whose vertices have values (v,): green is 0, red is `top` and more."""
    share = np.clip(values[faces].mean(axis=1) / top, 0.0, 1.0)
    colors = colormaps["RdYlGn_r"](share)
    axes.add_collection3d(
        Poly3DCollection(CM * vertices[faces], facecolors=colors, shade=True, antialiased=False)
    )


def draw_contacts(axes: Axes3D, p: Array, n: Array) -> None:
    """Contacts (k, 3) [m] as boxes, and their normals (k, 3) as lines."""
    axes.scatter(*(CM * p).T, s=14, marker="s", color=_BLUE, depthshade=False)
    lines = CM * np.stack([p, p + _NORMAL_M * n], axis=1)
    axes.add_collection3d(Line3DCollection(lines, colors=_BLUE, linewidths=1.0))


def draw_way(axes: Axes3D, p: Array, *, color: str = _BLUE) -> None:
    """The way of the fingertip through points (k, 3) [m]."""
    axes.plot(*(CM * p).T, color=color, lw=1.2)


def draw_candidates(axes: Axes3D, p: Array, rating: Array) -> None:
    """Candidates (m, 3) [m] coloured by their place among the ratings (m,)."""
    axes.scatter(*(CM * p).T, s=8, marker="s", c=rating_colors(rating), depthshade=False)


def rating_colors(rating: Array) -> Array:
    """Colours (m, 4) from red for the worst to green for the best; what was not rated is red."""
    low = rating[np.isfinite(rating)].min(initial=np.inf)
    high = rating[np.isfinite(rating)].max(initial=-np.inf)
    share = (np.where(np.isfinite(rating), rating, low) - low) / max(high - low, 1e-300)
    colors: Array = colormaps["RdYlGn"](share)
    return colors


def frame_around(axes: Axes3D, p: Array, *, margin_m: float = 0.0) -> None:
    """Equal axes in centimetres around points (n, 3) [m]."""
    low, high = CM * (p.min(axis=0) - margin_m), CM * (p.max(axis=0) + margin_m)
    axes.set(xlabel="x [cm]", ylabel="y [cm]", zlabel="z [cm]")
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.locator_params(nbins=4)
    axes.set_box_aspect(high - low)


def _draw_faces(axes: Axes3D, triangles: Array, color: str, alpha: float) -> None:
    faces = Poly3DCollection(CM * triangles, facecolors=color, shade=True)
    faces.set_alpha(alpha)
    axes.add_collection3d(faces)
