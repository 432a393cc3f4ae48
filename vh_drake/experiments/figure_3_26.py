"""`reproduce figure-3.26`: figures 3.26 to 3.28, strategies on a plane, a sphere and a cube.

On the plane every strategy chooses among the same places; the potential is what its contacts give.
Sphere and cube are explored by the fingertip until enough of their surface is explored, and the
candidates of all strategies lie anywhere on the estimate.
"""

import dataclasses as dc
import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vh_drake.catalog import Options
from vh_drake.experiments.exploration_pictures import draw_mesh, draw_way, set_view
from vh_drake.experiments.figure_files import save_figure
from vh_drake.experiments.reconstruction import Reconstruction, compare, with_normals
from vh_drake.experiments.touch_picture import CM, curve_points, rating_colors
from vh_drake.exploration.explorer import ExplorerSettings
from vh_drake.exploration.loop import Exploration, explore, make_body
from vh_drake.exploration.ratings import IgefSettings
from vh_drake.exploration.strategies import GpVariance, Igef, Random, Situation, Strategy
from vh_drake.exploration.trajectory import arc_length
from vh_drake.geometry.meshes import TriMesh
from vh_drake.gpis.contact_surface import ContactSurface
from vh_drake.objects import lathe
from vh_drake.reports import Report, Row
from vh_drake.types import Array, ContactSet

STRATEGIES: dict[str, Strategy] = {
    "GP-V": GpVariance(first=10_000),
    "IGEF": Igef(),
    "RND": Random(),
}
PLANE_IGEF = IgefSettings(sigma1_m=0.02, mu3_m=0.03, sigma3_m=0.005)  # a spiral, as figure 3.18
SIDE_M = 0.24  # of the plane's square
NODES = 81  # a side
TOUCHES = 20
SHOWN = (3, 8, 14, 20)
RADIUS_M, CUBE_M = 0.05, 0.08
SHAPES = {"sphere": lathe.sphere(RADIUS_M), "cube": lathe.box((CUBE_M,) * 3)}
EXPLORER = ExplorerSettings(candidate_radius_m=math.inf)
_UP = np.array([0.0, 0.0, 1.0])


@dc.dataclass(frozen=True, eq=False)
class PlaneRun:
    """Touches of a strategy on the plane."""

    p: Array  # (n, 3) [m]
    curves: Array  # (n - 1, 4, 3) control points between them [m]
    ratings: list[Array]  # of all places after each touch, (NODES²,)

    def length_m(self, count: int) -> float:
        """Of the way to the last of some touches [m]."""
        return float(arc_length(self.curves[: count - 1]).sum())


def run(options: Options) -> Report:
    """Explore all shapes by all strategies; writes figure-3.26.png to figure-3.28.png."""
    planes = {name: explore_plane(name, options.seed) for name in STRATEGIES}
    figure = Figure(figsize=(16.0, 9.0), layout="constrained")
    draw_planes(figure, planes)
    save_figure(options.out / "figure-3.26.png", figure)
    rows = [plane_row(name, plane) for name, plane in planes.items()]
    for number, (shape, mesh) in zip((27, 28), SHAPES.items(), strict=True):
        runs = {name: explore_shape(mesh, name, options.seed) for name in STRATEGIES}
        figure = Figure(figsize=(14.0, 10.0), layout="constrained")
        draw_shape(figure, mesh, runs)
        figure.suptitle(f"Figure 3.{number}: a {shape} until 80 % of its surface is explored")
        save_figure(options.out / f"figure-3.{number}.png", figure)
        rows += [shape_row(shape, name, one, mesh) for name, one in runs.items()]
    summary = {f"{row['shape']}_{row['strategy']}_path_cm": row["path_cm"] for row in rows}
    settings = {
        "seed": options.seed,
        "plane_side_m": SIDE_M,
        "plane_touches": TOUCHES,
        "sphere_radius_m": RADIUS_M,
        "cube_side_m": CUBE_M,
    }
    return Report("figure-3.26", settings, summary, {}, rows)


def plane_places() -> Array:
    """What may be touched of the plane (NODES², 3) [m]."""
    side = np.linspace(-SIDE_M / 2, SIDE_M / 2, NODES)
    x, y = np.meshgrid(side, side, indexing="ij")
    return np.column_stack([x.ravel(), y.ravel(), np.zeros(NODES**2)])


def explore_plane(name: str, seed: int) -> PlaneRun:
    """Touch the plane from its centre on."""
    strategy = Igef(PLANE_IGEF) if name == "IGEF" else STRATEGIES[name]
    places, p = plane_places(), np.zeros((1, 3))
    normals = np.tile(_UP, (len(places), 1))
    estimate = ContactSurface.of(p, np.tile(_UP, (1, 1)))
    curves: list[Array] = []
    ratings: list[Array] = []
    while True:
        situation = Situation(
            p=places,
            n=normals,
            contacts=ContactSet(p, np.tile(_UP, (len(p), 1))),
            posterior=estimate.posterior,
            p_WTip=p[-1],
            departure_W=_UP,
            approach_W=-_UP,
            tip_radius_m=0.0,
            explored_radius_m=0.02,
            seed=seed,
        )
        ratings.append(strategy.rate(situation))
        if len(p) == TOUCHES:
            return PlaneRun(p, np.array(curves), ratings)
        chosen = np.array([np.argmax(ratings[-1])])
        curves.append(situation.curves_to(chosen)[0])
        p = np.vstack([p, places[chosen]])
        estimate = estimate.append(p[-1], _UP)


def explore_shape(mesh: TriMesh, name: str, seed: int) -> Exploration:
    """Touch a shape until enough is explored."""
    settings = dc.replace(EXPLORER, strategy=STRATEGIES[name])
    return explore(make_body(mesh, mesh.bounds.mean(axis=0)), settings, seed=seed)


def plane_row(name: str, plane: PlaneRun) -> Row:
    """What a strategy did on the plane."""
    return {
        "shape": "plane",
        "strategy": name,
        "contacts": len(plane.p),
        "path_cm": round(CM * plane.length_m(TOUCHES), 2),
        "step_cm": round(CM * plane.length_m(TOUCHES) / (TOUCHES - 1), 3),
    }


def shape_row(shape: str, name: str, exploration: Exploration, mesh: TriMesh) -> Row:
    """What a strategy did on a solid, and how far its estimate is off."""
    contacts = exploration.known.contacts
    errors = compare(estimate_of(exploration), mesh)
    path = CM * float(exploration.lengths_m[-1])
    return {
        "shape": shape,
        "strategy": name,
        "contacts": len(contacts),
        "path_cm": round(path, 2),
        "step_cm": round(path / max(len(contacts) - 1, 1), 3),
        "end": exploration.end,
        "explored_share": round(float(exploration.shares[-1]), 4),
        "rmse_mm": round(1e3 * errors.distance_m, 3),
    }


def estimate_of(exploration: Exploration) -> TriMesh:
    """The surface in the end."""
    contacts = exploration.known.contacts
    return with_normals(contacts.p_WC, contacts.n_WC, Reconstruction(margin_m=0.03))


def draw_planes(figure: Figure, planes: dict[str, PlaneRun]) -> None:
    """Figure 3.26."""
    grid = figure.subplots(len(planes), len(SHOWN) + 1, sharex=True, sharey=True, squeeze=False)
    for line, (name, plane) in zip(grid, planes.items(), strict=True):
        for axes, count in zip(line, SHOWN, strict=False):
            draw_rating(axes, plane, count)
            axes.set_title(f"{name}, {count} contacts", fontsize=10)
        draw_path(line[-1], plane, TOUCHES)
        line[-1].set_title(f"whole way: {CM * plane.length_m(TOUCHES):.0f} cm", fontsize=10)
        line[0].set_ylabel("y [cm]")
    for axes in grid[-1]:
        axes.set_xlabel("x [cm]")
    figure.suptitle("Figure 3.26: a plane, coloured by rating; green is touched next")


def draw_rating(axes: Axes, plane: PlaneRun, count: int) -> None:
    """The plane's rating after some touches, and the touches."""
    half = CM * SIDE_M / 2
    colors = rating_colors(plane.ratings[count - 1]).reshape(NODES, NODES, 4)
    axes.imshow(colors.transpose(1, 0, 2), origin="lower", extent=(-half, half, -half, half))
    axes.plot(CM * plane.p[:count, 0], CM * plane.p[:count, 1], "s", color="tab:blue", ms=4)


def draw_path(axes: Axes, plane: PlaneRun, count: int) -> None:
    """The way from touch to touch, seen from above."""
    for curve in plane.curves[: count - 1]:
        way = CM * curve_points(curve)
        axes.plot(way[:, 0], way[:, 1], color="tab:blue", lw=1.0)
    axes.plot(CM * plane.p[:, 0], CM * plane.p[:, 1], "s", color="tab:blue", ms=4)
    axes.plot(0.0, 0.0, "ko", ms=6)
    axes.set_aspect("equal")


def draw_shape(figure: Figure, mesh: TriMesh, runs: dict[str, Exploration]) -> None:
    """Truth, contacts and way above; the estimates below."""
    for i, (name, exploration) in enumerate(runs.items()):
        top = figure.add_subplot(2, len(runs), i + 1, projection="3d")
        count, length = len(exploration.known.contacts), CM * exploration.lengths_m[-1]
        draw_way(top, exploration, mesh, f"{name}: {count} contacts, {length:.0f} cm of way")
        bottom = figure.add_subplot(2, len(runs), len(runs) + i + 1, projection="3d")
        estimate = estimate_of(exploration)
        draw_mesh(bottom, estimate, "silver", alpha=1.0)
        set_view(bottom, mesh)
        error = 1e3 * compare(estimate, mesh).distance_m
        bottom.set_title(f"estimate, {error:.1f} mm off (RMSE)", fontsize=10)
