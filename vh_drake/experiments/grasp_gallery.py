"""Pictures of grasps on touched surfaces: all candidates as arrows, and single hands closed."""

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize, to_rgb
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D

from vh_drake.experiments.hand_picture import draw_solids, hand_mesh
from vh_drake.experiments.touched_grasps import Planned, shown
from vh_drake.geometry.colors import score_colors
from vh_drake.geometry.glyphs import ColorMesh, arrows, balls, joined, tube
from vh_drake.types import Array

_HANDS = 4
_ARROW_M, _SHAFT_M, _BALL_M, _SPOT_M = 0.05, 0.001, 0.002, 0.004
_OBJECT, _CONTACT, _NONE = to_rgb("goldenrod"), to_rgb("red"), to_rgb("0.6")
_CM = 100.0


def draw_planner(figure: Figure, plan: Planned) -> None:
    """All candidates of a planner on the left, the hand closed in four of them on the right."""
    grid = figure.add_gridspec(2, 4)
    overview: Axes3D = figure.add_subplot(grid[:, :2], projection="3d")
    top = _top_epsilon(plan)
    draw_candidates(overview, plan, top)
    figure.colorbar(
        ScalarMappable(Normalize(0.0, top), "RdYlGn"),
        ax=overview,
        orientation="horizontal",
        shrink=0.6,
        extend="max",
        label="ε on the estimate; grey: not stable",
    )
    for place, i in enumerate(shown(plan, _HANDS)):
        axes = figure.add_subplot(grid[place // 2, 2 + place % 2], projection="3d")
        draw_grasp(axes, plan, int(i))
        axes.set_title(grasp_title(plan, int(i)), fontsize=10)


def _top_epsilon(plan: Planned) -> float:
    """The end of the colours: few candidates are better."""
    stable = plan.epsilon[plan.stable]
    return float(np.quantile(stable, 0.9)) if len(stable) else 1.0


def draw_candidates(axes: Axes3D, plan: Planned, top: float) -> None:
    """The estimate, what was felt, and an arrow to the power TCP of each candidate."""
    description = plan.hand.description
    X, contacts = plan.candidates.X_WH, plan.touched.contacts.p_WC
    approach = np.asarray(description.approach) / np.linalg.norm(description.approach)
    direction = X[:, :3, :3] @ approach
    tcp = X[:, :3, :3] @ np.asarray(description.tcps["power"]) + X[:, :3, 3]
    colors = np.where(plan.epsilon[:, None] > 0, score_colors(plan.epsilon / top), _NONE)
    start = tcp - _ARROW_M * direction
    pointers = arrows(start, direction, colors, length=_ARROW_M, radius=_SHAFT_M)
    felt = balls(contacts, np.tile(to_rgb("tab:blue"), (len(contacts), 1)), radius=_BALL_M)
    mesh = joined([_estimate(plan), felt, pointers])
    draw_solids(axes, in_cm(mesh))
    frame(axes, mesh.vertices)
    axes.set(xlabel="x [cm]", ylabel="y [cm]", zlabel="z [cm]")
    axes.set_title(
        f"{len(X)} candidates, {len(plan.stable)} stable; blue: {len(contacts)} contacts felt"
    )


def draw_grasp(axes: Axes3D, plan: Planned, i: int) -> None:
    """The hand closed around the estimate, where it touches, and a bar of 5 cm."""
    closure = plan.closures[i]
    hand = hand_mesh(plan.hand, closure.angles, closure.X_WH)
    spots = balls(closure.p_WC, np.tile(_CONTACT, (len(closure.p_WC), 1)), radius=_SPOT_M)
    mesh = joined([_estimate(plan), hand, spots])
    elevation, azimuth = _view_across(plan, i)
    bar = scale_bar(mesh.vertices, elevation, azimuth)
    draw_solids(axes, in_cm(joined([mesh, bar])))
    frame(axes, mesh.vertices, zoom=1.3)
    axes.set_axis_off()
    axes.view_init(elev=np.degrees(elevation), azim=np.degrees(azimuth))


def _view_across(plan: Planned, i: int) -> tuple[float, float]:
    """Elevation and azimuth [rad] past the fingers' side, so that both sides of the grip show."""
    description = plan.hand.description
    along, palm = np.asarray(description.along), np.asarray(description.palm)
    view = plan.closures[i].X_WH[:3, :3] @ (np.cross(along, palm) + 0.5 * along + 0.3 * palm)
    level = float(np.hypot(view[0], view[1]))
    return float(np.arctan2(view[2], level)), float(np.arctan2(view[1], view[0]))


def scale_bar(p: Array, elevation: float, azimuth: float) -> ColorMesh:
    """A black bar of 5 cm that lies level in the picture, below points (n, 3) [m]."""
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    up = -np.sin(elevation) * np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    up[2] = np.cos(elevation)
    middle = (p.min(axis=0) + p.max(axis=0)) / 2
    low = middle + (float(((p - middle) @ up).min()) - 0.01) * up
    ends = low + np.array([[-0.025], [0.025]]) * right
    return tube(ends, np.zeros(3), radius=0.0015)


def grasp_title(plan: Planned, i: int) -> str:
    """What the estimate and the true object say of a candidate."""
    return f"ε {plan.epsilon[i]:.3f}; holds the object\nin {100 * plan.rate[i]:.0f} % of trials"


def in_cm(mesh: ColorMesh) -> ColorMesh:
    """The mesh in centimetres."""
    return mesh._replace(vertices=_CM * mesh.vertices)


def frame(axes: Axes3D, p: Array, *, zoom: float = 1.0) -> None:
    """Equal axes around points (n, 3) [m], with few ticks."""
    low, high = _CM * p.min(axis=0), _CM * p.max(axis=0)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.locator_params(nbins=4)
    axes.set_box_aspect(high - low, zoom=zoom)


def _estimate(plan: Planned) -> ColorMesh:
    surface = plan.touched.surface
    return ColorMesh(surface.vertices, surface.faces, np.tile(_OBJECT, (len(surface.vertices), 1)))
