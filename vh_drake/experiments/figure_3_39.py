"""`reproduce figure-3.39`: measured over true tilt of plates of 0 to 50 degrees."""

import dataclasses as dc
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vh_drake.batch import run_tasks
from vh_drake.catalog import Options
from vh_drake.experiments.figure_files import save_figure
from vh_drake.experiments.tactile_runs import (
    REST_S,
    Motion,
    angle_deg,
    motion_of,
    read,
    simulate,
)
from vh_drake.reports import Report, Row
from vh_drake.sensing.imu import ImuSettings
from vh_drake.sensing.tactile import TactileSettings
from vh_drake.types import Array

TILTS_DEG = tuple(range(0, 51, 5))
REPEATS = 3  # plates of each tilt, with headings and frictions of their own
SEEDS = 10  # of noise and drift for each touch
DEPTH_MM = 7.0
UP = np.array([0.0, 0.0, 1.0])


def run(options: Options) -> Report:
    """Touches of tilted plates; writes figure-3.39.png.

    `runs` is the number of plates of each tilt.
    """
    tasks = plate_tasks(options.runs or REPEATS, options.seed)
    settings = {"plates": len(tasks), "seeds": SEEDS, "depth_mm": DEPTH_MM, "seed": options.seed}
    results = run_tasks(
        simulate,
        tasks,
        settings=settings,
        journal=options.out / "figure-3.39.journal",
        workers=options.workers,
        title="touching",
    )
    rows = []
    for i, (task, result) in enumerate(zip(tasks.values(), results, strict=True)):
        rows += touch_rows(task, motion_of(result), SEEDS * i)
    figure = Figure(figsize=(7.0, 6.0), layout="constrained")
    draw(figure.subplots(), rows)
    save_figure(options.out / "figure-3.39.png", figure)
    return Report("figure-3.39", settings, _summary(rows), {"mean_error_deg": 7.3}, rows)


def plate_tasks(repeats: int, seed: int) -> dict[str, dict[str, Any]]:
    """One touch each of plates that fall in random directions."""
    tasks = {}
    for tilt in TILTS_DEG:
        for i in range(repeats):
            rng = np.random.default_rng([seed, tilt, i])
            tasks[f"{tilt} degrees, {i}"] = {
                "tilt_deg": float(tilt),
                "heading_deg": float(rng.uniform(0.0, 360.0)),
                "friction": float(rng.uniform(0.6, 1.2)),
                "depths_mm": [DEPTH_MM],
                "rest_s": REST_S,
            }
    return tasks


def touch_rows(task: dict[str, Any], motion: Motion, first_seed: int) -> list[Row]:
    """Readings of one touch for several seeds, and by a unit that does not drift."""
    still = dc.replace(TactileSettings(), imu=ImuSettings(drift_deg=0.0))
    rows = []
    for seed in range(first_seed, first_seed + SEEDS):
        normal = read(motion, TactileSettings(), seed).normal_W[-1]
        plain = read(motion, still, seed).normal_W[-1]
        rows.append(
            {
                "tilt_deg": task["tilt_deg"],
                "heading_deg": round(task["heading_deg"], 3),
                "friction": round(task["friction"], 4),
                "seed": seed,
                "felt": bool(normal.any()),
                "measured_tilt_deg": _rounded(normal, UP),
                "error_deg": _rounded(normal, motion.n_WPlate),
                "error_no_drift_deg": _rounded(plain, motion.n_WPlate),
            }
        )
    return rows


def draw(axes: Axes, rows: list[Row]) -> None:
    """Measured over true tilt, with the root mean square error at each tilt."""
    felt = [row for row in rows if row["felt"]]
    axes.plot([0, 50], [0, 50], color="tab:blue", label="ideal")
    x = [row["tilt_deg"] for row in felt]
    y = [row["measured_tilt_deg"] for row in felt]
    axes.plot(x, y, "x", color="black", alpha=0.35, label="one touch")
    tilts = sorted(set(x))
    own = [np.array([r["measured_tilt_deg"] for r in felt if r["tilt_deg"] == t]) for t in tilts]
    rmse = [float(np.sqrt(np.mean((v - t) ** 2))) for t, v in zip(tilts, own, strict=True)]
    axes.errorbar(
        tilts, tilts, yerr=rmse, fmt="none", color="tab:red", capsize=4, label="root mean square"
    )
    axes.set(xlabel="true tilt of the plate [degrees]", ylabel="measured tilt [degrees]")
    axes.set(title="Normals by a drifting orientation sensor on a self-aligning mount")
    axes.set_aspect("equal")
    axes.grid(alpha=0.3)
    axes.legend(loc="upper left")


def _rounded(a: Array, b: Array) -> float | None:
    return round(angle_deg(a, b), 4) if a.any() else None


def _summary(rows: list[Row]) -> Row:
    felt = [row for row in rows if row["felt"]]
    plain = [row["error_no_drift_deg"] for row in rows if row["error_no_drift_deg"] is not None]
    return {
        "mean_error_deg": round(float(np.mean([row["error_deg"] for row in felt])), 3),
        "mean_error_no_drift_deg": round(float(np.mean(plain)), 3),
        "largest_error_no_drift_deg": round(float(np.max(plain)), 3),
        "felt_share": round(len(felt) / len(rows), 4),
    }
