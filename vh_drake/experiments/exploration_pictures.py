"""What explorations look like: explored share over distance, and the fingertip's way."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from mpl_toolkits.mplot3d.axes3d import Axes3D

from vh_drake.exploration.loop import Exploration, Touch
from vh_drake.exploration.trajectory import position
from vh_drake.geometry.meshes import TriMesh
from vh_drake.geometry.remesh import simplify
from vh_drake.types import Array

COLORS = {
    "igef": "tab:green",
    "gp_variance": "tab:orange",
    "random": "tab:blue",
    "gp_variance_equal_radius": "tab:orange",
    "uncertainty_cost": "tab:purple",
    "potential_field": "tab:brown",
    "shortest_way": "black",
    "igef_knowing": "tab:green",
}
_LABELS = {
    "igef": "IGEF",
    "gp_variance": "GP variance",
    "shortest_way": "shortest way found by who knows the object",
    "igef_knowing": "IGEF that knows the object",
}
_CM = 100.0
_PER_CURVE = 16  # points of a drawn curve
_MOST_FACES = 1500  # of a drawn mesh


def label(contender: str) -> str:
    """A contender's name for people."""
    strategy, _, equal = contender.partition("_equal_radius")
    words = _LABELS.get(strategy, strategy.replace("_", " "))
    return words if strategy == contender else f"{words} within 5 cm{equal}"


def share_at(distances_cm: Array, shares: Array, at_cm: Array) -> Array:
    """Explored shares (n,) after given distances; a run that ended keeps its last share."""
    known: Array = shares[np.searchsorted(distances_cm, at_cm, side="right") - 1]
    return known


def draw_progress(
    axes: Axes, curves: dict[str, list[tuple[Array, Array]]], *, goal: float = 0.8
) -> None:
    """Explored share over distance: runs light, their median thick and dashed.

    Args:
        axes: to draw on.
        curves: of each strategy, (distances [cm], shares) of each run.
        goal: the share that is to be reached.
    """
    longest = max(distances[-1] for runs in curves.values() for distances, _ in runs)
    at = np.linspace(0.0, longest, 400)
    for name, runs in curves.items():
        color = COLORS.get(name, "0.4")
        if len(runs) == 1:
            (distances, shares), words = runs[0], label(name)
            axes.plot(distances, 100.0 * shares, ".-", color=color, label=words)
            continue
        for distances, shares in runs:
            axes.plot(distances, 100.0 * shares, color=color, lw=0.8, alpha=0.35)
        median = np.median([share_at(d, s, at) for d, s in runs], axis=0)
        axes.plot(at, 100.0 * median, "--", color=color, lw=2.8, label=f"{label(name)}, median")
    axes.axhline(100.0 * goal, color="0.6", lw=1, label="goal")
    axes.set(xlabel="distance [cm]", ylabel="explored surface [%]", xlim=(0, None), ylim=(0, 100))
    axes.legend(loc="lower right")


def draw_way(axes: Axes3D, result: Exploration, truth: TriMesh, title: str) -> None:
    """The object in yellow, contacts and normals in blue squares, and the fingertip's way."""
    draw_mesh(axes, truth, "gold", alpha=0.3)
    way = _CM * way_points([step.touch for step in result.steps])
    if len(way):
        axes.plot(*way.T, color="tab:blue", lw=0.8)
    contacts = result.known.contacts
    p, n = _CM * contacts.p_WC, contacts.n_WC
    axes.scatter(*p.T, color="navy", marker="s", s=9)
    for a, b in zip(p, p + n, strict=True):
        axes.plot(*np.stack([a, b], axis=1), color="navy", lw=0.8)
    axes.set_title(title, fontsize=10)
    set_view(axes, truth)


def draw_mesh(axes: Axes3D, mesh: TriMesh, color: str, *, alpha: float) -> None:
    """A mesh in one colour, with as few triangles as a picture bears."""
    lighter = simplify(mesh, _MOST_FACES)
    triangles = _CM * lighter.triangles
    axes.add_collection3d(Poly3DCollection(triangles, facecolors=color, alpha=alpha, shade=True))


def way_points(touches: Sequence[Touch]) -> Array:
    """Points (n, 3) along the fingertip's way [m]."""
    points = [
        position(curve, float(tau))
        for touch in touches
        for i, curve in enumerate(touch.curves)
        for tau in np.linspace(0.0, touch.tau if i == len(touch.curves) - 1 else 1.0, _PER_CURVE)
    ]
    return np.array(points).reshape(-1, 3)


def set_view(axes: Axes3D, truth: TriMesh) -> None:
    """Equal scales around an object."""
    low, high = _CM * truth.bounds
    middle, half = (low + high) / 2, 0.55 * float((high - low).max())
    axes.set(
        xlim=(middle[0] - half, middle[0] + half),
        ylim=(middle[1] - half, middle[1] + half),
        zlim=(middle[2] - half, middle[2] + half),
        xlabel="x [cm]",
        ylabel="y [cm]",
        zlabel="z [cm]",
    )
    axes.set_box_aspect((1, 1, 1))
