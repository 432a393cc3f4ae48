"""Parts of pictures of touches, with the colours of table 3.4; lengths are drawn in centimetres."""

import numpy as np
from matplotlib import colormaps
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

from vh_drake.exploration.trajectory import position
from vh_drake.types import Array, IntArray

CM = 100.0
_BLUE = "tab:blue"
_NORMAL_M = 0.012
_STEPS = 20  # of a drawn curve


def curve_points(control_points: Array, tau: float = 1.0) -> Array:
    """Points (k, 3) along a Bezier curve (4, 3) up to τ [m]."""
    return np.array([position(control_points, t) for t in np.linspace(0.0, tau, _STEPS)])


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


def rating_colors(rating: Array) -> Array:
    """Colours (m, 4) from red for the worst to green for the best; what was not rated is red."""
    low = rating[np.isfinite(rating)].min(initial=np.inf)
    high = rating[np.isfinite(rating)].max(initial=-np.inf)
    share = (np.where(np.isfinite(rating), rating, low) - low) / max(high - low, 1e-300)
    colors: Array = colormaps["RdYlGn"](share)
    return colors
