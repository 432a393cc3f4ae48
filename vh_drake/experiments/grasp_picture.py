"""A picture of planned grasps: what was seen and estimated, and how the hand would take it."""

import io

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

from vh_drake.experiments.plan_grasps import GraspPlan
from vh_drake.geometry.colors import TOP_STD_M, score_colors, variance_colors
from vh_drake.hand.model import HandModel
from vh_drake.types import Array, Cloud, Plane, Surface

MOST_HANDS = 5
_MOST_POINTS = 1500
_AROUND_M = 0.08  # of the object, that is shown of cloud and table
_TABLE, _SURFACE, _POINTS, _HANDS = range(4)  # What is drawn over what


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
    colors = variance_colors(plan.surface.variance[plan.surface.faces].mean(axis=1))
    _draw_surface(axes, plan.surface, colors)
    near = cloud.p_WC[((cloud.p_WC > low) & (cloud.p_WC < high)).all(axis=1)]
    near = near[:: max(1, len(near) // _MOST_POINTS)]
    axes.scatter(*near.T, s=1.5, color="black", zorder=_POINTS, label="points of the camera")
    if len(plan.contacts):
        p = plan.contacts.p_WC.T
        axes.scatter(*p, s=60, color="red", zorder=_POINTS, label="touched places")
    axes.legend(loc="upper left")
    axes.set_title(f"Estimate from {len(plan.view.p_WO)} points, {len(plan.contacts)} touches")
    _finish(axes, plan, np.vstack([low, high]))


def draw_hands(axes: Axes3D, plan: GraspPlan) -> None:
    """The open hand where the best rated grasps start to close; thick is the best."""
    shown = plan.ranking[:MOST_HANDS]
    shapes = [_hand_lines(plan.hand, plan.candidates.X_WH[index]) for index in shown]
    spread = np.vstack([plan.surface.vertices, *(line for lines in shapes for line in lines)])
    low, high = spread.min(axis=0), spread.max(axis=0)
    _draw_table(axes, plan.view.table, low, high)
    _draw_surface(axes, plan.surface, np.tile([0.7, 0.75, 0.85], (len(plan.surface.faces), 1)))
    colors = score_colors(plan.scores.score[list(shown)])
    for rank, (lines, color) in reversed(list(enumerate(zip(shapes, colors, strict=True), 1))):
        width = 4.0 if rank == 1 else 1.5
        edge = Line3DCollection(lines, colors="black", linewidths=width + 1.0, zorder=_HANDS)
        axes.add_collection3d(edge)
        axes.add_collection3d(
            Line3DCollection(lines, colors=[color], linewidths=width, zorder=_HANDS)
        )
        axes.text(*lines[0][0], f" {rank}", fontsize=12, zorder=_HANDS)
    axes.set_title(f"Best {len(shown)} of {len(plan.candidates)} grasps, numbered at the wrist")
    _finish(axes, plan, np.vstack([low, high]))


def _hand_lines(hand: HandModel, X_WH: Array) -> list[Array]:
    """Polylines (k, 3) of the open hand in W, one a finger: base, joints, tip [m]."""
    origins = hand.link_poses(hand.lower)[:, :3, 3]
    tips = hand.tips(hand.lower)
    lines = []
    for finger, tip in enumerate(tips):
        first, last = hand.arrays.first_joint[finger : finger + 2]
        p_H = np.vstack([origins[0], origins[first + 1 : last + 1], tip])
        lines.append(p_H @ X_WH[:3, :3].T + X_WH[:3, 3])
    return lines


def _draw_surface(axes: Axes3D, surface: Surface, colors: Array) -> None:
    """Shaded triangles with a colour each."""
    triangles = surface.vertices[surface.faces]
    axes.add_collection3d(
        Poly3DCollection(triangles, facecolors=colors, shade=True, zorder=_SURFACE)
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
    """Equal axes with units, seen from the camera's side."""
    low, high = box.min(axis=0), box.max(axis=0)
    axes.set(xlabel="x [m]", ylabel="y [m]", zlabel="z [m]")
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_box_aspect(high - low)
    axes.locator_params(nbins=5)
    away = plan.view.p_WCamera - plan.view.p_WO.mean(axis=0)
    axes.view_init(elev=25.0, azim=float(np.degrees(np.arctan2(away[1], away[0]))) + 35.0)


def _colorbar(figure: Figure, axes: Axes3D, name: str, highest: float, label: str) -> None:
    scale = ScalarMappable(Normalize(0.0, highest), name)
    figure.colorbar(scale, ax=axes, orientation="horizontal", shrink=0.6, label=label)
