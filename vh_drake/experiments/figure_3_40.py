"""`reproduce figure-3.40`: figures 3.40 and 3.41, with and without normals on noisy contacts.

Two objects, the coffee can and the cracker box, are explored by IGEF, nearly whole, and felt with
the noise of the tactile sensor. With --objects they are YCB's scanned meshes, else a cylinder and
a box of their size. Figure 3.40 colours both estimates by their distance from the true object;
figure 3.41 leads from the edges of a box of the cracker box's size to its estimates.
"""

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D

from vh_drake.catalog import Options
from vh_drake.experiments.edge_picture import box_edges, draw_edges, edge_rmse
from vh_drake.experiments.exploration_pictures import set_view
from vh_drake.experiments.figure_files import save_figure
from vh_drake.experiments.reconstruction import (
    Errors,
    compare,
    with_normals,
    without_normals,
)
from vh_drake.experiments.table_3_6 import (
    EXPLORER,
    NOISY,
    NOISY_WITHOUT,
    THESIS_WITH,
    THESIS_WITHOUT,
    sensed,
    shape,
)
from vh_drake.experiments.touch_picture import draw_colored
from vh_drake.exploration.loop import EndSettings, explore, make_body
from vh_drake.geometry.closest_points import closest_points, triangle_tree
from vh_drake.geometry.inertia import mass_properties
from vh_drake.geometry.meshes import TriMesh
from vh_drake.objects.loading import load_object
from vh_drake.reports import Report, Row
from vh_drake.types import Array

OBJECTS = {"ground_coffee": "002_master_chef_can", "cheez_it": "003_cracker_box"}
CRACKER_M = (0.06, 0.158, 0.21)  # as in table 3.6
FORMULATIONS = ("without normals", "with normals")
END = EndSettings(goal=0.98, most_touches=199, most_without_gain=30)
WORST_M = 0.01  # drawn red
THESIS_EDGE_MM = {"edge_rmse_mm": 9.5, "edge_rmse_mm_without_normals": 20.7}  # figure 3.41

Estimates = dict[str, TriMesh]  # by formulation


def run(options: Options) -> Report:
    """Explore and estimate; writes figure-3.40.png and figure-3.41.png.

    Raises:
        VhDrakeError: a mesh is missing or unusable.
    """
    truths = {name: true_mesh(name, options) for name in OBJECTS}
    felt = {name: estimate_both(truth, options.seed) for name, truth in truths.items()}
    estimates = {name: both for name, (_, both) in felt.items()}
    figure = Figure(figsize=(11.0, 11.0), layout="constrained")
    draw_errors(figure, truths, estimates)
    save_figure(options.out / "figure-3.40.png", figure)
    p, edged = estimate_both(shape("cheez_it"), options.seed)
    figure = Figure(figsize=(11.0, 7.0), layout="constrained")
    draw_edge_errors(figure, edged, p)
    save_figure(options.out / "figure-3.41.png", figure)
    rows = [
        {"object": name, "contacts": len(felt[name][0])} | object_row(truths[name], estimates[name])
        for name in OBJECTS
    ]
    summary = {
        f"{row['object']}_{metric}": row[metric]
        for row in rows
        for metric in row
        if metric != "object"
    }
    edges = box_edges(CRACKER_M)
    for name, suffix in zip(FORMULATIONS, ("_without_normals", ""), strict=True):
        summary[f"edge_rmse_mm{suffix}"] = 1e3 * edge_rmse(edged[name], edges)
    settings = {
        "seed": options.seed,
        "objects": list(OBJECTS.values()) if options.objects else list(OBJECTS),
        "edge_contacts": len(p),
    }
    return Report("figure-3.40", settings, summary, thesis(), rows)


def true_mesh(name: str, options: Options) -> TriMesh:
    """YCB's mesh where a folder is given, else a shape of its size."""
    if options.objects is None:
        return shape(name)
    return load_object(OBJECTS[name], folder=options.objects).mesh


def estimate_both(truth: TriMesh, seed: int) -> tuple[Array, Estimates]:
    """Noisy contacts (k, 3) of an exploration [m], and both estimates from them."""
    body = make_body(truth, mass_properties(truth, 1.0).com)
    contacts = explore(body, EXPLORER, END, seed=seed).known.contacts
    p, n = sensed(contacts.p_WC, contacts.n_WC, seed)
    without, with_ = FORMULATIONS
    return p, {without: without_normals(p, NOISY_WITHOUT), with_: with_normals(p, n, NOISY)}


def object_row(truth: TriMesh, estimates: Estimates) -> Row:
    """Errors of an object as in table 3.6 [mm, degrees]."""
    row: Row = {}
    for formulation, suffix in zip(FORMULATIONS, ("_without_normals", ""), strict=True):
        errors: Errors = compare(estimates[formulation], truth)
        row[f"mm{suffix}"] = 1e3 * errors.distance_m
        row[f"deg{suffix}"] = float(np.degrees(errors.angle_rad))
    return row


def thesis() -> dict[str, float]:
    """The same metrics of table 3.6 and figure 3.41."""
    figures = dict(THESIS_EDGE_MM)
    for table, suffix in ((THESIS_WITH, ""), (THESIS_WITHOUT, "_without_normals")):
        for name in OBJECTS:
            figures[f"{name}_mm{suffix}"], figures[f"{name}_deg{suffix}"] = table[name]
    return figures


def draw_errors(
    figure: Figure, truths: dict[str, TriMesh], estimates: dict[str, Estimates]
) -> None:
    """Figure 3.40: a row an object."""
    for line, (name, truth) in enumerate(truths.items()):
        tree = triangle_tree(truth)
        for column, formulation in enumerate(FORMULATIONS):
            mesh = estimates[name][formulation]
            axes: Axes3D = figure.add_subplot(2, 2, 2 * line + column + 1, projection="3d")
            off = np.linalg.norm(closest_points(tree, mesh.vertices) - mesh.vertices, axis=1)
            draw_colored(axes, mesh.vertices, mesh.faces, off, WORST_M)
            set_view(axes, truth)
            error = 1e3 * compare(mesh, truth).distance_m
            axes.set_title(f"{name}, {formulation}: {error:.1f} mm RMSE", y=0.98)
    scale = ScalarMappable(Normalize(0.0, 1e3 * WORST_M), "RdYlGn_r")
    figure.colorbar(scale, ax=figure.axes, shrink=0.6, label="distance from the true surface [mm]")
    figure.suptitle("Figure 3.40: estimates from the same noisy contacts")


def draw_edge_errors(figure: Figure, estimates: Estimates, p: Array) -> None:
    """Figure 3.41."""
    edges = box_edges(CRACKER_M)
    for i, name in enumerate(FORMULATIONS):
        axes = figure.add_subplot(1, 2, i + 1, projection="3d", computed_zorder=False)
        draw_edges(axes, estimates[name], edges, p)
        error = 1e3 * edge_rmse(estimates[name], edges)
        axes.set_title(f"{name}: {error:.1f} mm RMSE at the edges")
    figure.suptitle("Figure 3.41: lines lead from a box's edges to the estimate; red: far")
