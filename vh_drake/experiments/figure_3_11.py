"""`reproduce figure-3.11`: figures 3.11 and 3.12, surfaces with and without normals.

A flat surface, a corner and a stair in the plane, and a cube in space, each estimated from the
same contacts twice: by positions with one point inside and others around (section 3.2.1), and by
positions with normals (section 3.2.2).
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.spatial import cKDTree
from skimage.measure import find_contours

from vh_drake.catalog import Options
from vh_drake.experiments.edge_picture import box_edges, draw_edges, edge_rmse
from vh_drake.experiments.figure_files import save_figure
from vh_drake.experiments.plane_potential import draw_plane, in_plane, potential_in_plane
from vh_drake.experiments.reconstruction import (
    Reconstruction,
    compare,
    with_normals,
    without_normals,
)
from vh_drake.geometry.meshes import TriMesh
from vh_drake.gpis.inside_outside import inside_outside_observations, ring
from vh_drake.gpis.observations import surface_observations
from vh_drake.gpis.posterior import Posterior, fit
from vh_drake.objects import lathe
from vh_drake.reports import Report, Row
from vh_drake.types import Array

SETTINGS = Reconstruction()
LOW, HIGH = np.array([-0.07, -0.06]), np.array([0.07, 0.05])  # of the drawings [m]
CUBE_M = 0.08
_STEP_M = 0.0002  # between points of an outline


@dataclass(frozen=True, eq=False)
class PlaneExample:
    """A surface in the plane and where it is touched."""

    name: str
    corners: Array  # (c, 2) of the true outline [m]
    p: Array  # (k, 2) contacts [m]
    n: Array  # (k, 2) outward unit normals
    p_inside: Array  # (2,) for the formulation without normals [m]


FLAT = PlaneExample(
    "flat",
    np.array([[-0.05, 0.0], [0.05, 0.0]]),
    np.array([[-0.04, 0.0], [0.0, 0.0], [0.04, 0.0]]),
    np.array([[0.0, 1.0]] * 3),
    np.array([0.0, -0.03]),
)
CORNER = PlaneExample(
    "corner",
    np.array([[-0.05, 0.02], [0.03, 0.02], [0.03, -0.04]]),
    np.array([[-0.04, 0.02], [-0.015, 0.02], [0.01, 0.02], [0.03, -0.01]]),
    np.array([[0.0, 1.0], [0.0, 1.0], [0.0, 1.0], [1.0, 0.0]]),
    np.array([-0.01, -0.01]),
)
STAIR = PlaneExample(
    "stair",
    np.array([[-0.055, 0.03], [-0.02, 0.03], [-0.02, 0.0], [0.02, 0.0], [0.02, -0.03]]),
    np.array([[-0.05, 0.03], [-0.035, 0.03], [-0.02, 0.015], [0.0, 0.0], [0.02, -0.015]]),
    np.array([[0.0, 1.0], [0.0, 1.0], [1.0, 0.0], [0.0, 1.0], [1.0, 0.0]]),
    np.array([-0.03, -0.02]),
)
EXAMPLES = (FLAT, CORNER, STAIR)


def run(options: Options) -> Report:
    """Estimate all examples; writes figure-3.11.png and figure-3.12.png."""
    figure = Figure(figsize=(10.0, 12.0), layout="constrained")
    for row, example in zip(figure.subplots(3, 2), EXAMPLES, strict=True):
        draw_example(row, example)
    figure.suptitle("Figure 3.11: the same contacts without (left) and with normals (right)")
    save_figure(options.out / "figure-3.11.png", figure)
    estimates = cube_estimates()
    save_figure(options.out / "figure-3.12.png", draw_cube(estimates))
    rows = [plane_row(example) for example in EXAMPLES] + [cube_row(estimates)]
    summary = {}
    for row in rows:
        summary[f"{row['name']}_mm"] = row["mm"]
        summary[f"{row['name']}_mm_without_normals"] = row["mm_without_normals"]
    settings = {"cube_side_m": CUBE_M, "cube_contacts": len(cube_contacts()[0])}
    return Report("figure-3.11", settings, summary, {}, rows)


def estimate(example: PlaneExample, *, normals: bool) -> Posterior:
    """The potential in the plane from an example's contacts."""
    p = in_plane(example.p)
    if not normals:
        inside = np.array([*example.p_inside, 0.0])
        seen = inside_outside_observations(
            p, SETTINGS.inside_outside, directions=ring(12), p_inside=inside
        )
        return fit(SETTINGS.kernel, seen)
    noise = SETTINGS.noise
    seen = surface_observations(
        p, in_plane(example.n), value_std_m=noise.position_std_m, gradient_std=noise.normal_std
    )
    return fit(SETTINGS.kernel, seen)


def outline(corners: Array) -> Array:
    """Points (m, 2) along a line through corners (c, 2), evenly spread [m]."""
    pieces = []
    for a, b in pairwise(corners):
        share = np.arange(0.0, 1.0, _STEP_M / np.linalg.norm(b - a))[:, None]
        pieces.append(a + share * (b - a))
    return np.vstack([*pieces, corners[-1:]])


def error_in_plane(posterior: Posterior, truth: Array) -> float:
    """Mean distance of true points (m, 2) to the estimated outline; infinite without one [m]."""
    x, y, f = potential_in_plane(posterior, LOW, HIGH)
    lines = find_contours(f, 0.0)
    if not lines:
        return float("inf")
    step = np.array([y[1] - y[0], x[1] - x[0]])
    start = np.array([y[0], x[0]])
    places = np.vstack([outline(line * step + start) for line in lines])[:, ::-1]
    return float(cKDTree(places).query(truth)[0].mean())


def plane_row(example: PlaneExample) -> Row:
    """Errors of an example [mm]."""
    truth = outline(example.corners)
    return {
        "name": example.name,
        "contacts": len(example.p),
        "mm": 1e3 * error_in_plane(estimate(example, normals=True), truth),
        "mm_without_normals": 1e3 * error_in_plane(estimate(example, normals=False), truth),
    }


def draw_example(axes: tuple[Axes, Axes], example: PlaneExample) -> None:
    """A row of figure 3.11."""
    truth = outline(example.corners)
    for one, normals in zip(axes, (False, True), strict=True):
        posterior = estimate(example, normals=normals)
        shown = in_plane(example.n) if normals else None
        draw_plane(one, posterior, in_plane(example.p), n=shown, truth=truth, low=LOW, high=HIGH)
        error = 1e3 * error_in_plane(posterior, truth)
        one.set_title(f"{example.name}, {'with' if normals else 'without'} normals: {error:.1f} mm")
    axes[0].legend(loc="lower left", fontsize=8)


def cube_contacts() -> tuple[Array, Array]:
    """Five contacts (30, 3) [m] and normals (30, 3) on each face of the cube."""
    spots = 0.25 * CUBE_M * np.array([[0, 0], [1, 1], [1, -1], [-1, 1], [-1, -1]])
    p, n = [], []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            face = np.insert(spots, axis, sign * CUBE_M / 2, axis=1)
            p.append(face + np.array([0.0, 0.0, CUBE_M / 2]))
            n.append(np.tile(sign * np.eye(3)[axis], (len(spots), 1)))
    return np.vstack(p), np.vstack(n)


def cube_estimates() -> dict[str, TriMesh]:
    """Estimates of the cube by formulation."""
    p, n = cube_contacts()
    return {"without": without_normals(p, SETTINGS), "with": with_normals(p, n, SETTINGS)}


def cube_row(estimates: dict[str, TriMesh]) -> Row:
    """Errors of the cube [mm, degrees]; at its edges too."""
    truth, edges = lathe.box((CUBE_M,) * 3), box_edges((CUBE_M,) * 3)
    row: Row = {"name": "cube", "contacts": len(cube_contacts()[0])}
    for name, suffix in (("with", ""), ("without", "_without_normals")):
        errors = compare(estimates[name], truth)
        row[f"mm{suffix}"] = 1e3 * errors.distance_m
        row[f"deg{suffix}"] = float(np.degrees(errors.angle_rad))
        row[f"edge_mm{suffix}"] = 1e3 * edge_rmse(estimates[name], edges)
    return row


def draw_cube(estimates: dict[str, TriMesh]) -> Figure:
    """Figure 3.12."""
    figure = Figure(figsize=(11.0, 5.5), layout="constrained")
    edges, (p, _) = box_edges((CUBE_M,) * 3), cube_contacts()
    for i, (name, mesh) in enumerate(estimates.items()):
        axes = figure.add_subplot(1, 2, i + 1, projection="3d", computed_zorder=False)
        draw_edges(axes, mesh, edges, p)
        error = 1e3 * edge_rmse(mesh, edges)
        axes.set_title(f"{name} normals: {error:.1f} mm at the edges")
    figure.suptitle("Figure 3.12: a cube; lines lead from its edges to the estimate, red: far")
    return figure
