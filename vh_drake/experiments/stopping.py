"""`reproduce stopping`: does an explorer that stops by itself reach the accuracy that is wanted?

Every object is explored once a run, in rounds that refine the estimate; the first touch after which
the explorer would stop is looked up for each wanted accuracy, and only then is the true error
measured. Weights and factor of the error's bound (`vh_drake.exploration.stopping.ErrorModel`) were
fitted on the train split; the summary's `fit_` metrics are what such a fit gives now.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vh_drake.batch import run_tasks
from vh_drake.catalog import Options
from vh_drake.experiments.contenders import subject
from vh_drake.experiments.estimate import symmetric_distance
from vh_drake.experiments.exploration_trials import RESULT_SPLIT, explored_objects
from vh_drake.experiments.figure_files import save_figure
from vh_drake.exploration.stopping import Refinement, refinements
from vh_drake.geometry.meshes import TriMesh
from vh_drake.reports import Report, Row
from vh_drake.types import Array

RUNS = 3
WANTED_MM = (2.0, 3.0, 5.0)
TARGET = 0.8  # share of objects whose accuracy shall be met
_ERRORS_MM = (0.2, 0.5, 1.0, 2.0, 5.0, 10.0)  # beside the figure's axis
_SAMPLED = 5  # every so many touches the error is measured for the fit


def run(options: Options) -> Report:
    """Explore every object some times; writes stopping.png.

    The summary is the test split's where there is one; the train split's begins with `train_`.

    Raises:
        BadInput: folder or options are unusable.
    """
    objects = explored_objects(options)
    runs = options.runs or RUNS
    settings: Row = {
        "objects": dict(objects),
        "runs": runs,
        "seed": options.seed,
        "wanted_mm": list(WANTED_MM),
    }
    folder = "" if options.objects is None else str(options.objects)
    tasks = {
        f"{name} {seed}": {"object": name, "folder": folder, "split": split, "seed": seed}
        for name, split in objects.items()
        for seed in range(options.seed, options.seed + runs)
    }
    found: list[dict[str, Any]] = run_tasks(
        stops,
        tasks,
        settings=settings,
        journal=options.out / "stopping.jsonl",
        workers=options.workers,
        title="stopping",
    )
    rows = [row for result in found for row in result["rows"]]
    splits = dict.fromkeys(row["split"] for row in rows)
    main = RESULT_SPLIT if RESULT_SPLIT in splits else next(iter(splits))
    summary = shares([row for row in rows if row["split"] == main])
    for split in splits:
        if split != main:
            other = shares([row for row in rows if row["split"] == split])
            summary |= {f"{split or 'other'}_{key}": value for key, value in other.items()}
    if "train" in splits:
        summary |= fitted([result["samples"] for result in found if result["split"] == "train"])
    figure = Figure(figsize=(6.5, 5.0), layout="constrained")
    draw(figure.subplots(), [row for row in rows if row["split"] == main])
    save_figure(options.out / "stopping.png", figure)
    return Report("stopping", settings | {"split": main}, summary, rows=rows)


def stops(task: Mapping[str, Any]) -> Row:
    """One exploration: a row for each wanted accuracy, and samples for the fit of the bound."""
    explored = subject(task["object"], task["folder"])
    waiting, rows, samples = list(reversed(sorted(WANTED_MM))), [], []
    last: Refinement | None = None
    for last in refinements(explored.body, seed=task["seed"]):
        while waiting and 1e3 * last.bound_m <= waiting[0]:
            rows.append(_row(task, waiting.pop(0), last, explored.model.mesh, stopped=True))
        if last.touches % _SAMPLED == 0 and last.round > 0:
            error = _error_mm(last, explored.model.mesh)
            samples.append([*np.round(last.features, 6).tolist(), round(error, 4)])
        if not waiting:
            break
    if last is not None:
        rows += [_row(task, w, last, explored.model.mesh, stopped=False) for w in waiting]
    return {"split": task["split"], "rows": rows, "samples": samples}


def _row(
    task: Mapping[str, Any], wanted_mm: float, at: Refinement, mesh: TriMesh, *, stopped: bool
) -> Row:
    """How an exploration to an accuracy ended."""
    error = _error_mm(at, mesh)
    return {
        "object": task["object"],
        "split": task["split"],
        "seed": task["seed"],
        "wanted_mm": wanted_mm,
        "stopped": stopped,  # else the explorer says that the accuracy can't be met
        "met": stopped and error <= wanted_mm,
        "error_mm": round(error, 4),
        "bound_mm": round(min(1e3 * at.bound_m, 1e3), 4),
        "touches": at.touches,
        "explored_share": round(at.coverage.share, 4),
    }


def _error_mm(at: Refinement, mesh: TriMesh) -> float:
    """Symmetric mean distance; an empty estimate is as far off as the object is long."""
    if len(at.sheet.faces) == 0:
        return 1e3 * float(np.linalg.norm(mesh.extents))
    return 1e3 * symmetric_distance(TriMesh(at.sheet.vertices, at.sheet.faces), mesh)


def shares(rows: Sequence[Row]) -> Row:
    """For each accuracy: how often the explorer stopped, was right, and said that it can't."""
    summary: Row = {}
    for wanted in WANTED_MM:
        own = [row for row in rows if row["wanted_mm"] == wanted]
        stopped = [row for row in own if row["stopped"]]
        objects = dict.fromkeys(row["object"] for row in own)
        met = {name: np.mean([r["met"] for r in own if r["object"] == name]) for name in objects}
        label = f"{wanted:g}_mm"
        summary[f"met_share_{label}"] = _mean([row["met"] for row in own])
        summary[f"objects_met_share_{label}"] = _mean([share > 0.5 for share in met.values()])
        summary[f"right_when_stopped_share_{label}"] = _mean([row["met"] for row in stopped])
        summary[f"said_it_cannot_share_{label}"] = _mean([not row["stopped"] for row in own])
        summary[f"touches_{label}"] = _mean([row["touches"] for row in own])
        summary[f"error_mm_{label}"] = _mean([row["error_mm"] for row in own])
    return summary


def fitted(samples: Sequence[Sequence[Sequence[float]]]) -> Row:
    """Weights of the bound by least squares, and its 90 % factor where an object is left out.

    Args:
        samples: of each exploration, rows of the three features and the true error [mm].
    """
    groups = [np.array(own, float) for own in samples if len(own)]
    if len(groups) < 2:
        return {}
    every = np.vstack(groups)
    residuals = []
    for i, own in enumerate(groups):
        others = np.vstack([group for j, group in enumerate(groups) if j != i])
        residuals.append(np.log(own[:, 3]) - own[:, :3] @ _least_squares(others))
    return {
        "fit_weights": np.round(_least_squares(every), 3).tolist(),
        "fit_factor_90": round(float(np.exp(np.quantile(np.concatenate(residuals), 0.9))), 3),
    }


def _least_squares(samples: Array) -> Array:
    return np.asarray(np.linalg.lstsq(samples[:, :3], np.log(samples[:, 3]), rcond=None)[0])


def _mean(values: Sequence[Any]) -> float | None:
    return round(float(np.mean(values)), 4) if len(values) else None


def draw(axes: Axes, rows: Sequence[Row]) -> None:
    """True error over what was wanted; a dot a run, crosses where the explorer gave up."""
    for stopped, marker, label in ((True, "o", "stopped by itself"), (False, "x", "can't be met")):
        own = [row for row in rows if row["stopped"] == stopped]
        spread = 1.0 + 0.04 * (np.arange(len(own)) % 7 - 3) / 3.0  # dots side by side
        axes.plot(
            [row["wanted_mm"] * s for row, s in zip(own, spread, strict=True)],
            [row["error_mm"] for row in own],
            marker,
            alpha=0.6,
            label=label,
        )
    ends = np.array([0.9 * min(WANTED_MM), 1.1 * max(WANTED_MM)])
    axes.plot(ends, ends, "k-", lw=0.8, label="error = wanted")
    axes.set(xscale="log", yscale="log")
    axes.set_xticks(WANTED_MM, [f"{wanted:g}" for wanted in WANTED_MM])
    axes.set_yticks(_ERRORS_MM, [f"{error:g}" for error in _ERRORS_MM])
    axes.minorticks_off()
    axes.set(xlabel="wanted accuracy [mm]", ylabel="true error when it stopped [mm]")
    axes.set_title("Below the line the wanted accuracy is met")
    axes.legend()
    axes.grid(alpha=0.3)
