"""`reproduce figure-3.30`: figures 3.30 to 3.35, exploring three objects, step by step.

The pictures of ways show one exploration by GP variance and one by IGEF; the curves show the
explored share of the surface over the distance, of many runs by three strategies.
"""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from vh_drake.catalog import Options
from vh_drake.experiments.contenders import subject
from vh_drake.experiments.example_objects import (
    STRATEGIES,
    Task,
    example_objects,
    example_runs,
    explored_rows,
)
from vh_drake.experiments.exploration_pictures import draw_progress, draw_way, label
from vh_drake.experiments.figure_files import save_figure
from vh_drake.reports import Report, Row
from vh_drake.types import Array

HALF = 0.4  # of the surface: how far the goal's half is


def run(options: Options) -> Report:
    """Explore and draw; writes figure-3.30.png to figure-3.35.png.

    Raises:
        BadInput: the folder of objects is unusable.
    """
    settings, rows = explored_rows(
        progress_row, options, journal="progress.jsonl", title="figures 3.30 to 3.35"
    )
    for i, (name, folder) in enumerate(example_objects(options).items()):
        own = [row for row in rows if row["object"] == name]
        _save_ways(options, 30 + 2 * i, name, folder)
        _save_progress(options, 31 + 2 * i, name, own)
    return Report("figure-3.30", settings, summary(rows), {}, rows)


def progress_row(task: Task) -> Row:
    """Distance and explored share after each touch of one exploration."""
    name, folder, strategy, seed = task
    (result,) = example_runs(name, folder, strategy, [seed])
    return {
        "object": name,
        "strategy": strategy,
        "seed": seed,
        "end": result.end,
        "distance_cm": np.round(100.0 * result.lengths_m, 3).tolist(),
        "explored_share": np.round(result.shares, 4).tolist(),
    }


def summary(rows: list[Row]) -> dict[str, float]:
    """Median distances to 40 % and to the end of each object by each strategy [cm]."""
    figures: dict[str, float] = {}
    for name in dict.fromkeys(row["object"] for row in rows):
        for strategy in STRATEGIES:
            own = [r for r in rows if r["object"] == name and r["strategy"] == strategy]
            ends = [row["distance_cm"][-1] for row in own]
            figures[f"{name}_{strategy}_half_cm"] = round(float(np.median(_halves(own))), 2)
            figures[f"{name}_{strategy}_cm"] = round(float(np.median(ends)), 2)
    return figures


def _halves(rows: list[Row]) -> list[float]:
    """Distances at which half of the goal was reached; where it wasn't, the whole [cm]."""
    halves = []
    for row in rows:
        reached = np.flatnonzero(np.array(row["explored_share"]) >= HALF)
        halves.append(row["distance_cm"][reached[0] if len(reached) else -1])
    return halves


def _save_ways(options: Options, number: int, name: str, folder: str) -> None:
    figure = Figure(figsize=(12.0, 6.0), layout="constrained")
    grid: Any = figure.subplots(1, 2, subplot_kw={"projection": "3d"})
    for axes, strategy in zip(grid, ("gp_variance", "igef"), strict=True):
        (result,) = example_runs(name, folder, strategy, [options.seed])
        distance, contacts = 100.0 * result.lengths_m[-1], len(result.known.contacts)
        title = f"{label(strategy)}: {contacts} contacts, {distance:.0f} cm"
        draw_way(axes, result, subject(name, folder).model.mesh, title)
    figure.suptitle(
        f"Figure 3.{number}: exploring {name}; the fingertip's way (blue line), contacts with "
        "normals (dark), the object (yellow)"
    )
    save_figure(options.out / f"figure-3.{number}.png", figure)


def _save_progress(options: Options, number: int, name: str, rows: list[Row]) -> None:
    figure = Figure(figsize=(7.5, 5.0), layout="constrained")
    axes = figure.subplots()
    curves: dict[str, list[tuple[Array, Array]]] = {
        strategy: [
            (np.array(row["distance_cm"]), np.array(row["explored_share"]))
            for row in rows
            if row["strategy"] == strategy
        ]
        for strategy in STRATEGIES
    }
    draw_progress(axes, curves)
    axes.set_title(f"Figure 3.{number}: explored surface of {name} over the distance")
    save_figure(options.out / f"figure-3.{number}.png", figure)
