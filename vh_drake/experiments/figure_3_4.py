"""`reproduce figure-3.4`: figures 3.4 and 3.20, what happens when a touch meets nothing.

Figure 3.4 is the principle: three contacts on the top of a block suggest that the top goes on; the
way to a target beyond the edge meets nothing, and the way back comes from below (eq. 3.86), so that
it has to meet the block's side. Figure 3.20 is such an event in an exploration of a box.
"""

import dataclasses as dc
from functools import cache

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D

from vh_drake.catalog import Options
from vh_drake.errors import VhDrakeError
from vh_drake.experiments.exploration_pictures import draw_mesh, set_view
from vh_drake.experiments.figure_files import save_figure
from vh_drake.experiments.plane_potential import draw_plane
from vh_drake.experiments.touch_picture import CM, curve_points, draw_contacts
from vh_drake.exploration.explorer import ExplorerSettings, Known
from vh_drake.exploration.kinematic_tip import TipMotion, move_along
from vh_drake.exploration.loop import Step, begin, make_body, touches
from vh_drake.exploration.trajectory import approach_curves, recovery_curve
from vh_drake.geometry.closest_points import triangle_tree
from vh_drake.geometry.meshes import TriMesh
from vh_drake.gpis.contact_surface import ContactSurface
from vh_drake.gpis.following import follow_surface
from vh_drake.objects import lathe
from vh_drake.reports import Report, Row
from vh_drake.types import Array

BLOCK_M = (0.08, 0.05, 0.4)  # long along z, so that what happens at z = 0 is plane
TOP_M, EDGE_M = 0.025, 0.04  # y of the block's top and x of its edge
CONTACTS = np.array([[-0.02, TOP_M, 0.0], [0.0, TOP_M, 0.0], [0.02, TOP_M, 0.0]])
TARGET = np.array([0.06, TOP_M, 0.0])
BEYOND_M = 0.005  # Δm, how far the tip goes on behind a target
TIP_M = 1e-4  # radius of the tip of figure 3.4: next to none
BOX_M = (0.10, 0.07, 0.05)
_UP = np.array([0.0, 1.0, 0.0])
_MOST_SEEDS, _MOST_TOUCHES = 20, 40
_LOW, _HIGH = np.array([-0.055, -0.055]), np.array([0.085, 0.06])  # of figure 3.4 [m]


@dc.dataclass(frozen=True, eq=False)
class Missed:
    """A touch that met nothing and came back."""

    planned: Array  # (4, 3) control points to the target [m]
    first: TipMotion  # along them
    back: Array  # (4, 3) control points of the way back [m]
    second: TipMotion


@dc.dataclass(frozen=True, eq=False)
class Event:
    """A missed touch within an exploration."""

    seed: int
    number: int  # of the touch
    before: Known
    step: Step


def run(options: Options) -> Report:
    """Miss and come back; writes figure-3.4.png and figure-3.20.png.

    Raises:
        VhDrakeError: no touch was missed in any exploration.
    """
    missed, event = miss_the_edge(), find_event(options.seed)
    figure = Figure(figsize=(8.0, 10.0), layout="constrained")
    draw_principle(figure, missed)
    save_figure(options.out / "figure-3.4.png", figure)
    figure = Figure(figsize=(16.0, 6.0), layout="constrained")
    draw_event(figure, event)
    save_figure(options.out / "figure-3.20.png", figure)
    touch = event.step.touch
    summary: Row = {
        "first_way_touches": missed.first.touched,
        "back_touches": missed.second.touched,
        "back_meets_side": bool(abs(missed.second.p_WC[0] - EDGE_M) < 1e-3),
        "event_contact_from_target_mm": 1e3 * float(np.linalg.norm(touch.p_WC - touch.p_WT)),
        "event_on_the_object_mm": 1e3 * distance_to_box(touch.p_WC),
    }
    rows = [
        motion_row("figure 3.4, to the target", missed.first),
        motion_row("figure 3.4, back from below", missed.second),
    ]
    settings = {"box_m": list(BOX_M), "event_seed": event.seed, "event_touch": event.number}
    return Report("figure-3.4", settings, summary, {}, rows)


def block() -> TriMesh:
    """The block of figure 3.4 about the origin [m]."""
    mesh = lathe.box(BLOCK_M)
    return TriMesh(mesh.vertices - mesh.bounds.mean(axis=0), mesh.faces)


def miss_the_edge() -> Missed:
    """The ways of figure 3.4."""
    tree = triangle_tree(block())
    start = CONTACTS[-1] + TIP_M * _UP
    planned = approach_curves(start, _UP, TARGET[None], _UP[None])[0]
    first = move_along(tree, planned, radius_m=TIP_M, beyond_m=BEYOND_M)
    back = recovery_curve(first.p_WTip, first.direction_W, CONTACTS[-1], _UP)
    return Missed(planned, first, back, move_along(tree, back, radius_m=TIP_M))


@cache
def find_event(seed: int) -> Event:
    """The first missed touch of an exploration of the box, from a seed on.

    Raises:
        VhDrakeError: none in many explorations.
    """
    settings = ExplorerSettings()
    mesh = lathe.box(BOX_M)
    body = make_body(mesh, mesh.bounds.mean(axis=0))
    for one in range(seed, seed + _MOST_SEEDS):
        known, coverage = begin(body, settings, seed=one)
        going = touches(body, known, coverage, settings, seed=one)
        for number, step in zip(range(1, _MOST_TOUCHES + 1), going, strict=False):
            if step.touch.missed and len(step.touch.curves) == 2:
                return Event(one, number, known, step)
            known = step.known
    raise VhDrakeError(f"no touch was missed in {_MOST_SEEDS} explorations; choose another --seed")


def distance_to_box(p: Array) -> float:
    """Of a point (3,) to the surface of the box [m]."""
    half = np.array(BOX_M) / 2
    q = np.abs(p - [0.0, 0.0, half[2]]) - half
    outside = float(np.linalg.norm(np.maximum(q, 0.0)))
    return abs(outside + min(float(q.max()), 0.0))


def motion_row(name: str, motion: TipMotion) -> Row:
    """How a way ended."""
    return {
        "way": name,
        "touched": motion.touched,
        "length_mm": 1e3 * motion.length_m,
        **{f"{axis}_mm": 1e3 * float(motion.p_WTip[i]) for i, axis in enumerate("xyz")},
    }


def draw_principle(figure: Figure, missed: Missed) -> None:
    """Figure 3.4."""
    top, bottom = figure.subplots(2, 1, sharex=True)
    normals = np.tile(_UP, (len(CONTACTS), 1))
    x, y = BLOCK_M[0] / 2, BLOCK_M[1] / 2
    outline = np.array([[-x, -y], [x, -y], [x, y], [-x, y], [-x, -y]])
    for axes, contacts in (
        (top, CONTACTS),
        (bottom, np.vstack([CONTACTS, missed.second.p_WC])),
    ):
        n = np.vstack([normals, missed.second.n_WC])[: len(contacts)]
        posterior = ContactSurface.of(contacts, n).posterior
        draw_plane(axes, posterior, contacts, n=n, truth=outline, low=_LOW, high=_HIGH)
        _draw_line(axes, missed.planned, missed.first.tau, "tab:red", "way to the target")
        axes.plot(*(CM * TARGET[:2]), "k*", ms=12, label="target on the estimate")
    _draw_line(bottom, missed.back, missed.second.tau, "tab:blue", "way back from below")
    top.set_title("the target lies beyond the edge, where nothing is")
    bottom.set_title("the way back meets the side; the estimate follows")
    bottom.legend(loc="lower left", fontsize=8)
    figure.suptitle("Figure 3.4: a touch that meets nothing")


def _draw_line(axes: Axes, curve: Array, tau: float, color: str, label: str) -> None:
    points = CM * curve_points(curve, tau)
    axes.plot(points[:, 0], points[:, 1], color=color, lw=2.5, label=label)


def draw_event(figure: Figure, event: Event) -> None:
    """Figure 3.20."""
    mesh, touch = lathe.box(BOX_M), event.step.touch
    planned, back = curve_points(touch.curves[0]), curve_points(touch.curves[1], touch.tau)
    titles = (
        "a) target (star) on the estimate, off the box",
        "b) red: the way misses; blue: on and back",
        "c) the estimate with the new contact",
    )
    for i, known in enumerate((event.before, event.before, event.step.known)):
        axes: Axes3D = figure.add_subplot(1, 3, i + 1, projection="3d", computed_zorder=False)
        _draw_known(axes, known, mesh)
        axes.plot(*(CM * touch.p_WT[:, None]), "k*", ms=12)
        if i == 1:
            axes.plot(*(CM * planned).T, color="tab:red", lw=1.5)
            axes.plot(*(CM * back).T, color="tab:blue", lw=1.5)
        axes.set_title(titles[i], y=0.98)
    figure.suptitle("Figure 3.20: yellow: the box; grey: estimate; blue: contacts and normals")


def _draw_known(axes: Axes3D, known: Known, mesh: TriMesh) -> None:
    sheet = follow_surface(known.posterior, known.contacts.p_WC, margin_m=0.04)
    draw_mesh(axes, mesh, "gold", alpha=0.5)
    draw_mesh(axes, TriMesh(sheet.vertices, sheet.faces), "0.6", alpha=0.35)
    draw_contacts(axes, known.contacts.p_WC, known.contacts.n_WC)
    set_view(axes, mesh)
