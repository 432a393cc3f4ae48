"""`reproduce estimate`: how far the estimated surface is from the true one, over touches.

An object stands before the robot in a stable pose; one noisy look and up to five touches by
next best touch make the estimate. The error is the symmetric mean distance: the mean over both
surfaces of the distance to the other one.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vh_drake.batch import run_tasks
from vh_drake.catalog import Options
from vh_drake.errors import BadInput, NothingSeen
from vh_drake.experiments.figure_files import save_figure
from vh_drake.geometry.closest_points import closest_points, triangle_tree
from vh_drake.geometry.meshes import TriMesh
from vh_drake.geometry.sampling import sample_surface
from vh_drake.gpis.surface import estimate_surface
from vh_drake.grasping.field import object_field
from vh_drake.learning.scene import SceneSettings, look, place
from vh_drake.learning.touches import explore
from vh_drake.objects.folders import read_folder
from vh_drake.objects.library import library_names
from vh_drake.objects.loading import load_object
from vh_drake.reports import Report, Row
from vh_drake.types import ContactSet, Surface

TOUCHES = 5
RUNS = 10  # poses of each object; a touch changes the median by 1 %, less than 3 poses tell
TARGETS = {"median_mm": 8.0, "max_mm": 25.0}  # with one touch
_TRIES = 8  # touches that are tried until so many are felt
_POINTS = 4000  # on either surface


def run(options: Options) -> Report:
    """Errors of every object of the split, or of the embedded library.

    Raises:
        BadInput: an option is unusable, or the folder has no object of the split.
    """
    objects = evaluated_objects(options)
    runs = options.runs or RUNS
    tasks = {
        f"{name} {seed}": {
            "object": name,
            "folder": None if options.objects is None else str(options.objects),
            "seed": seed,
            "split": split,
        }
        for name, split in objects.items()
        for seed in range(options.seed, options.seed + runs)
    }
    settings: Row = {
        "objects": list(objects),
        "runs": runs,
        "seed": options.seed,
        "points": _POINTS,
    }
    rows = run_tasks(
        estimate_row,
        tasks,
        settings=settings,
        journal=options.out / "journal.jsonl",
        workers=options.workers,
        title="estimates",
    )
    seen = [row for row in rows if row["felt"] is not None]
    if not seen:
        raise BadInput("no object was seen in any pose; nothing can be estimated")
    figure = Figure(figsize=(9.0, 4.5), layout="constrained")
    draw_errors(figure.subplots(), seen)
    save_figure(options.out / "estimate.png", figure)
    return Report("estimate", settings, summarized(rows), {}, rows)


def evaluated_objects(options: Options) -> dict[str, str]:
    """Names with their split: those of a folder's split, else of the embedded library.

    Raises:
        BadInput: the folder has no object of the split.
    """
    if options.objects is None:
        return dict.fromkeys(library_names(), "library")
    split = options.split or "test"
    entries = read_folder(options.objects)
    objects = {name: e.split for name, e in sorted(entries.items()) if e.split in (split, "")}
    if not objects:
        raise BadInput(f"{options.objects}: objects.csv has no object of the split {split!r}")
    return objects


def estimate_row(task: Mapping[str, str | int | None]) -> Row:
    """Errors of one scene after each touch [mm]; None for all where nothing was seen."""
    folder, seed = task["folder"], int(task["seed"] or 0)
    model = load_object(str(task["object"]), folder=None if folder is None else Path(str(folder)))
    rng = np.random.default_rng([seed, 31])
    settings = SceneSettings()
    truth = place(model.mesh, settings, rng)
    row: Row = {"object": task["object"], "split": task["split"], "seed": seed, "felt": None}
    try:
        view = look(truth, settings, rng)
    except NothingSeen:
        return row
    field = object_field(Surface(truth.mesh.vertices, truth.mesh.faces), truth.table)
    contacts = explore(view, field, _TRIES, rng)
    row["felt"] = min(len(contacts), TOUCHES)
    for count in range(TOUCHES + 1):
        known = ContactSet(contacts.p_WC[:count], contacts.n_WC[:count])
        surface = estimate_surface(view, known)
        error = symmetric_distance(TriMesh(surface.vertices, surface.faces), truth.mesh)
        row[f"error_{count}_mm"] = round(1e3 * error, 3)
    return row


def symmetric_distance(one: TriMesh, other: TriMesh, *, seed: int = 0) -> float:
    """Mean distance [m] of points of either surface to the other one, both counting alike.

    A surface without triangles is as far off as the other's diagonal is long.
    """
    if min(len(one.faces), len(other.faces)) == 0:
        return max((mesh.diagonal for mesh in (one, other) if len(mesh.faces)), default=0.0)
    means = []
    for a, b in ((one, other), (other, one)):
        p = sample_surface(a, _POINTS, seed=seed)[0]
        means.append(np.linalg.norm(closest_points(triangle_tree(b), p) - p, axis=1).mean())
    return float(np.mean(means))


def summarized(rows: Sequence[Row]) -> Row:
    """Median, mean and largest error over all scenes, those with one touch first."""
    seen = [row for row in rows if row["felt"] is not None]
    errors = {
        count: np.array([row[f"error_{count}_mm"] for row in seen]) for count in range(TOUCHES + 1)
    }
    medians = {count: round(float(np.median(values)), 3) for count, values in errors.items()}
    by_object = [
        np.mean([row["error_1_mm"] for row in seen if row["object"] == name])
        for name in dict.fromkeys(row["object"] for row in seen)
    ]
    return {
        "surface_error_median_mm": medians[1],
        "surface_error_max_mm": round(float(errors[1].max()), 3),
        "surface_error_max_object_mm": round(float(np.max(by_object)), 3),
        **{f"surface_error_median_{count}_touches_mm": value for count, value in medians.items()},
        **{
            f"surface_error_mean_{count}_touches_mm": round(float(np.mean(values)), 3)
            for count, values in errors.items()
        },
        "falls_with_each_touch": all(medians[i + 1] < medians[i] for i in range(TOUCHES)),
        "scenes": len(rows),
        "scenes_not_seen": len(rows) - len(seen),
        "scenes_with_fewer_touches": sum(row["felt"] < TOUCHES for row in seen),
    }


def draw_errors(axes: Axes, rows: Sequence[Row]) -> None:
    """Errors over touches: one thin line an object, the median thick."""
    counts = np.arange(TOUCHES + 1)
    names = list(dict.fromkeys(row["object"] for row in rows))
    errors = np.array([[row[f"error_{count}_mm"] for count in counts] for row in rows])
    owners = np.array([row["object"] for row in rows])
    for i, name in enumerate(names):
        label = name if len(names) <= 16 else None
        mean = errors[owners == name].mean(axis=0)
        axes.plot(counts, mean, color=f"C{i % 10}", lw=1, alpha=0.7, label=label)
    axes.plot(counts, np.median(errors, axis=0), "ko-", lw=3, label="median of all scenes")
    axes.axhline(TARGETS["median_mm"], color="0.6", ls="--", label="wanted of the median")
    axes.set(xlabel="touches", ylabel="symmetric mean distance to the true surface [mm]")
    axes.set_ylim(bottom=0)
    axes.legend(fontsize=7, loc="center left", bbox_to_anchor=(1.01, 0.5))
