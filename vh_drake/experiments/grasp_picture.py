"""A picture of planned grasps: what was seen and estimated, and how the hand would take it."""

import io

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from vh_drake.experiments.plan_grasps import GraspPlan
from vh_drake.geometry.colors import TOP_STD_M, score_colors, variance_colors
from vh_drake.geometry.glyphs import ColorMesh, joined, tube
from vh_drake.hand.model import HandModel
from vh_drake.types import Array, Cloud, Plane, Surface

MOST_HANDS = 3
_MOST_POINTS = 400
_AROUND_M = 0.05  # of the object, that is shown of cloud and table
_THICK_M, _THIN_M = 0.008, 0.003  # radii of the tubes of a hand [m]
_GREY = (0.7, 0.75, 0.85)
_TABLE, _SOLID, _LABELS = range(3)  # What is drawn over what


def draw_grasps(plan: GraspPlan, cloud: Cloud) -> bytes:
    """A PNG with the estimate on the left and the best grasps on the right.

    Args:
        plan: what was planned.
        cloud: what the user gave.
    """
    figure = Figure(figsize=(13.0, 6.5), layout="constrained")
    FigureCanvasAgg(figure)
    left: Axes3D = figure.add_subplot(1, 2, 1, projection="3d", computed_zorder=False)
    draw_estimate(left, plan, cloud)
    right: Axes3D = figure.add_subplot(1, 2, 2, projection="3d", computed_zorder=False)
    draw_hands(right, plan)
    _colorbar(figure, left, "viridis", 1000 * TOP_STD_M, "standard deviation of the surface [mm]")
    _colorbar(figure, right, "RdYlGn", 1.0, "score of the grasp")
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=100, metadata={"Software": None})
    return stream.getvalue()


def draw_estimate(axes: Axes3D, plan: GraspPlan, cloud: Cloud) -> None:
    """Cloud, touches and the estimated surface, coloured by how uncertain it is."""
    vertices = plan.surface.vertices
    low, high = vertices.min(axis=0) - _AROUND_M, vertices.max(axis=0) + _AROUND_M
    _draw_table(axes, plan.view.table, low, high)
    colors = variance_colors(plan.surface.variance)
    _draw_triangles(axes, ColorMesh(vertices, plan.surface.faces, colors))
    near = cloud.p_WC[((cloud.p_WC > low) & (cloud.p_WC < high)).all(axis=1)]
    near = near[:: max(1, len(near) // _MOST_POINTS)]
    axes.scatter(*near.T, s=1.0, color="grey", zorder=_LABELS, label="cloud")
    seen = plan.view.p_WO[:: max(1, len(plan.view.p_WO) // _MOST_POINTS)]
    axes.scatter(*seen.T, s=4.0, color="black", zorder=_LABELS, label="of it, the object")
    if len(plan.contacts):
        p = plan.contacts.p_WC.T
        axes.scatter(*p, s=60, color="red", zorder=_LABELS, label="touched places")
    axes.legend(loc="upper left")
    axes.set_title(f"Estimate; points: {len(plan.view.p_WO)}, touches: {len(plan.contacts)}")
    _finish(axes, plan, np.vstack([low, high]))


def draw_hands(axes: Axes3D, plan: GraspPlan) -> None:
    """The open hand where the best rated grasps start to close; thick is the best."""
    shown = plan.ranking[:MOST_HANDS]
    colors = score_colors(plan.scores.score[list(shown)])
    poses = plan.candidates.X_WH[list(shown)]
    hands = [
        _hand(plan.hand, X_WH, color, _THIN_M if rank else _THICK_M)
        for rank, (X_WH, color) in enumerate(zip(poses, colors, strict=True))
    ]
    everything = joined([_object(plan.surface), *hands])
    low, high = everything.vertices.min(axis=0), everything.vertices.max(axis=0)
    _draw_table(axes, plan.view.table, low, high)
    _draw_triangles(axes, everything)
    for rank, X_WH in enumerate(poses, 1):
        axes.text(*X_WH[:3, 3], f"  {rank}", fontsize=14, weight="bold", zorder=_LABELS)
    axes.set_title(f"Best {len(shown)} of {len(plan.candidates)} grasps, numbered at the wrist")
    _finish(axes, plan, np.vstack([low, high]))


def _hand(hand: HandModel, X_WH: Array, color: Array, radius: float) -> ColorMesh:
    """The open hand in W as tubes, one a finger: base, joints, tip."""
    origins = hand.link_poses(hand.lower)[:, :3, 3]
    tubes = []
    for finger, tip in enumerate(hand.tips(hand.lower)):
        first, last = hand.arrays.first_joint[finger : finger + 2]
        p_H = np.vstack([origins[0], origins[first + 1 : last + 1], tip])
        tubes.append(tube(p_H @ X_WH[:3, :3].T + X_WH[:3, 3], color, radius=radius))
    return joined(tubes)


def _object(surface: Surface) -> ColorMesh:
    return ColorMesh(surface.vertices, surface.faces, np.tile(_GREY, (len(surface.vertices), 1)))


def _draw_triangles(axes: Axes3D, mesh: ColorMesh) -> None:
    """All in one collection, so that what is in front hides what is behind."""
    axes.add_collection3d(
        Poly3DCollection(
            mesh.vertices[mesh.faces],
            facecolors=mesh.colors[mesh.faces].mean(axis=1),
            shade=True,
            zorder=_SOLID,
        )
    )


def _draw_table(axes: Axes3D, table: Plane, low: Array, high: Array) -> None:
    """The part of the table below a box."""
    x = np.array([low[0], high[0], high[0], low[0]])
    y = np.array([low[1], low[1], high[1], high[1]])
    n = table.normal
    corners = np.column_stack([x, y, (table.offset - n[0] * x - n[1] * y) / n[2]])
    axes.add_collection3d(
        Poly3DCollection([corners], facecolors=[[0.85, 0.75, 0.6]], zorder=_TABLE)
    )


def _finish(axes: Axes3D, plan: GraspPlan, box: Array) -> None:
    """Equal axes with units, seen along a diagonal from the camera's side."""
    low, high = box.min(axis=0), box.max(axis=0)
    axes.set(xlabel="x [m]", ylabel="y [m]", zlabel="z [m]")
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_box_aspect(high - low, zoom=0.95)
    axes.locator_params(nbins=5)
    away = plan.view.p_WCamera - plan.view.p_WO.mean(axis=0)
    azimuth = float(np.degrees(np.arctan2(away[1], away[0])))
    axes.view_init(elev=30.0, azim=45.0 + 90.0 * round((azimuth - 45.0) / 90.0))


def _colorbar(figure: Figure, axes: Axes3D, name: str, highest: float, label: str) -> None:
    scale = ScalarMappable(Normalize(0.0, highest), name)
    figure.colorbar(scale, ax=axes, orientation="horizontal", shrink=0.6, label=label)
