"""`reproduce figure-3.38`: seven touches in pressure, orientation and acceleration."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vh_drake.batch import run_tasks
from vh_drake.catalog import Options
from vh_drake.experiments.figure_files import save_figure
from vh_drake.experiments.tactile_runs import (
    CONTACT_N,
    REST_S,
    Motion,
    Readings,
    angle_deg,
    intervals,
    motion_of,
    read,
    simulate,
)
from vh_drake.reports import Report, Row
from vh_drake.sensing.tactile import N_SPAD, TactileSettings

TOUCHES = 7
SEEDS = 100
MOTIONS = 10  # Ten seeds of noise share the physics of one motion.
DEPTHS_MM = (2.0, 6.0)


def run(options: Options) -> Report:
    """Seeds of noise and drift on simulated touches; writes figure-3.38.png.

    `runs` is the number of seeds.
    """
    seeds = options.runs or SEEDS
    tasks = motion_tasks(min(MOTIONS, seeds), options.seed)
    settings = {"seeds": seeds, "touches": TOUCHES, "motions": len(tasks), "seed": options.seed}
    results = run_tasks(
        simulate,
        tasks,
        settings=settings,
        journal=options.out / "figure-3.38.journal",
        workers=options.workers,
        title="touching",
    )
    motions = [motion_of(result) for result in results]
    rows = []
    for k in range(seeds):
        motion = motions[k % len(motions)]
        rows.append({"seed": k, **counts(motion, read(motion, TactileSettings(), k))})
    figure = Figure(figsize=(10.0, 8.0), layout="constrained")
    draw(figure, motions[0], read(motions[0], TactileSettings(), 0))
    save_figure(options.out / "figure-3.38.png", figure)
    touches = sum(row["touches"] for row in rows)
    summary = {
        "touches_found_share": round(sum(row["found"] for row in rows) / touches, 6),
        "false_touches": sum(row["false"] for row in rows),
        "largest_drift_pa": round(max(row["drift_pa"] for row in rows), 1),
        "threshold_pa": TactileSettings().detection.threshold_pa,
    }
    thesis = {"touches_found_share": 1.0, "false_touches": 0}
    return Report("figure-3.38", settings, summary, thesis, rows)


def motion_tasks(count: int, seed: int) -> dict[str, dict[str, Any]]:
    """Seven presses of random depth on plates of random small tilt."""
    tasks = {}
    for i in range(count):
        rng = np.random.default_rng([seed, i])
        tasks[f"motion {i}"] = {
            "tilt_deg": float(rng.uniform(0.0, 15.0)),
            "heading_deg": float(rng.uniform(0.0, 360.0)),
            "friction": float(rng.uniform(0.8, 1.2)),
            "depths_mm": rng.uniform(*DEPTHS_MM, TOUCHES).tolist(),
            "rest_s": REST_S + float(rng.uniform(0.0, 0.4)),
        }
    return tasks


def counts(motion: Motion, readings: Readings) -> Row:
    """Touches, those of them that were found, and contacts that were none or doubled."""
    true = intervals(motion.force_n > CONTACT_N)
    felt = intervals(readings.contact)
    found = sum(any(a < d and c < b for c, d in felt) for a, b in true)
    false = len(felt) - found
    resting = motion.force_n <= 0.0
    drift = float(np.abs(readings.pressure_pa[resting]).max())
    return {"touches": len(true), "found": found, "false": false, "drift_pa": round(drift, 1)}


def draw(figure: Figure, motion: Motion, readings: Readings) -> None:
    """Acceleration, angle and pressures over time; the true contacts are shaded."""
    axes = figure.subplots(4, 1, sharex=True)
    start = readings.R_WS[0] @ N_SPAD
    angles = [angle_deg(R @ N_SPAD, start) for R in readings.R_WS]
    for ax, values, label in (
        (axes[0], motion.acceleration_m_s2, "linear\nacceleration [m/s²]"),
        (axes[1], angles, "angle to first\norientation [°]"),
        (axes[2], readings.pressure_pa / 1e3, "pressure [kPa]"),
        (axes[3], readings.filtered_pa / 1e3, "filtered\npressure [kPa]"),
    ):
        ax.plot(motion.time_s, values, lw=1.2)
        ax.set_ylabel(label)
        ax.grid(alpha=0.3)
        _shade(ax, motion)
    limit = TactileSettings().detection.threshold_pa / 1e3
    axes[3].axhline(limit, color="tab:red", ls="--", lw=1, label="threshold of contact")
    axes[3].fill_between(
        motion.time_s,
        -0.4,
        -0.2,
        where=readings.contact.tolist(),
        color="tab:green",
        label="contact, as told",
    )
    axes[3].legend(loc="upper right", fontsize="small")
    axes[3].set_xlabel("time [s]")
    axes[0].set_title("Seven touches of a plate; grey: the pad truly touches")


def _shade(axes: Axes, motion: Motion) -> None:
    for a, b in intervals(motion.force_n > CONTACT_N):
        axes.axvspan(motion.time_s[a], motion.time_s[b - 1], color="grey", alpha=0.2, lw=0)
