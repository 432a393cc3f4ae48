"""`reproduce robustness`: lift success under what a lab has, one disturbance at a time."""

from typing import Any

import numpy as np

from vh_drake.catalog import Options
from vh_drake.experiments.lift_trials import (
    LiftObject,
    chosen_objects,
    run_trials,
    share,
    trial_settings,
    wilson_interval,
)
from vh_drake.reports import Report, Row
from vh_drake.sensing.depth_noise import DepthNoiseSettings

SCENES = 40
BASE = "as it is"


def conditions() -> dict[str, dict[str, Any]]:
    """Changes of the scenario by the name of the disturbance."""
    return {
        BASE: {},
        **{f"friction {mu:g}": {"friction": mu} for mu in (0.4, 0.6, 1.0)},
        **{f"mass {kg:g} kg": {"mass_kg": kg} for kg in (0.1, 0.4, 0.8, 1.2)},
        **{f"camera noise x {times}": {"camera": _noisier(times)} for times in (2, 3)},
        **{name: {"camera": error} for name, error in hand_eye((0.005, 1.5), (0.01, 3.0)).items()},
        **{
            f"force drift {newton:g} N": {"wrist": {"force_drift_n": newton}}
            for newton in (0.05, 0.2)
        },
    }


def hand_eye(*errors: tuple[float, float]) -> dict[str, dict[str, float]]:
    """Cameras whose calibration is wrong by a shift [m] and a turn [deg], by name."""
    return {
        f"hand-eye error {1000 * m:g} mm, {deg:g} degrees": {
            "calibration_shift_m": m,
            "calibration_turn_deg": deg,
        }
        for m, deg in errors
    }


def _noisier(times: float) -> dict[str, Any]:
    """Settings of a camera whose every error is larger."""
    plain = DepthNoiseSettings()
    noise = DepthNoiseSettings(
        axial_m=times * plain.axial_m,
        axial_per_m=times * plain.axial_per_m,
        grazing=times * plain.grazing,
        disparity_step_px=times * plain.disparity_step_px,
        lateral_px=times * plain.lateral_px,
        edge_dropout=min(1.0, times * plain.edge_dropout),
    )
    return {"noise": vars(noise)}


def scenes(objects: list[LiftObject], count: int, seed: int) -> list[tuple[LiftObject, int]]:
    """Objects in turn, each in poses of its own."""
    return [(objects[i % len(objects)], seed + i // len(objects)) for i in range(count)]


def run(options: Options) -> Report:
    """The same scenes under every condition, first attempts, point contact unless asked.

    Raises:
        BadInput: folder or options are unusable.
    """
    objects, left_out = chosen_objects(options)
    count, contact = options.scenes or SCENES, options.contact or "point"
    tasks, names = {}, []
    for name, changes in conditions().items():
        for item, seed in scenes(objects, count, options.seed):
            tasks[f"{name}: {item.name} {seed}"] = trial_settings(
                item, seed, contact, **{"attempts": 1, **changes}
            )
            names.append(name)
    settings = {
        "objects": [item.name for item in objects],
        "left_out": left_out,
        "scenes": count,
        "seed": options.seed,
        "contact": contact,
        "attempts": 1,
    }
    rows = run_trials(tasks, options, settings, "disturbing")
    named = [{"condition": name, **row} for name, row in zip(names, rows, strict=True)]
    return Report("robustness", settings, robustness_summary(named), {}, named)


def robustness_summary(rows: list[Row]) -> Row:
    """Success and its 95 % interval by condition, and the largest loss in points."""
    summary: Row = {}
    success: dict[str, float] = {}
    for name in dict.fromkeys(row["condition"] for row in rows):
        own = [row for row in rows if row["condition"] == name]
        success[name] = share(own, "lifted")
        summary[name] = round(success[name], 4)
        summary[f"{name} interval"] = wilson_interval(sum(r["lifted"] for r in own), len(own))
    losses = [success[BASE] - value for name, value in success.items() if name != BASE]
    return summary | {"largest_loss_points": round(100.0 * float(np.max(losses)), 2)}
