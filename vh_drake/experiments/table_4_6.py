"""`reproduce table-4.6`: the validation set of section 4.5.6, in ten poses each."""

from collections.abc import Sequence

import numpy as np

from vh_drake.catalog import Options
from vh_drake.experiments.lift import object_rows
from vh_drake.experiments.lift_trials import (
    LiftObject,
    attempts_counted,
    run_trials,
    trial_settings,
)
from vh_drake.reports import Report, Row

ATTEMPTS = 3
MASSES_KG = {
    "aluminum_profile": 1.2,
    "hammer": 0.8,
    "multimeter": 0.4,
    "screw_box": 0.4,
    "power_drill": 0.9,
    "cutter": 0.3,
    "pliers": 0.3,
    "spray_bottle": 0.2,
}
THESIS_ATTEMPTS = dict(zip(MASSES_KG, (2, 2, 1, 2, 2, 2, 1, 1), strict=True))
LIFTED_SHARE = 0.8  # of the poses in which an object that counts as lifted was lifted


def run(options: Options) -> Report:
    """Trials of the eight objects with the masses of table 4.6.

    Raises:
        BadInput: an option is unusable.
    """
    runs, contact = options.runs or 10, options.contact or "hydroelastic"
    objects = [LiftObject(name, mass_kg=mass) for name, mass in MASSES_KG.items()]
    tasks = {
        f"{item.name} {seed}": trial_settings(item, seed, contact, attempts=ATTEMPTS)
        for seed in range(options.seed, options.seed + runs)  # First, so that any part tells of all
        for item in objects
    }
    settings = {
        "masses_kg": MASSES_KG,
        "runs": runs,
        "seed": options.seed,
        "contact": contact,
        "attempts": ATTEMPTS,
        "touches": 1,
    }
    rows = run_trials(tasks, options, settings, "lifting")
    by_object = [_with_thesis(row, rows) for row in object_rows(objects, rows)]
    summary = {
        "objects": len(objects),
        "lifted": sum(row["overall_success"] >= LIFTED_SHARE for row in by_object),
        "mean_attempts": round(float(np.mean([attempts_counted(r, ATTEMPTS) for r in rows])), 3),
        "mean_slip_mm": _mean([row["slip_mm"] for row in rows if row["lifted"]]),
    }
    thesis = {"objects": 8, "lifted": 8, "mean_attempts": _mean([*THESIS_ATTEMPTS.values()])}
    return Report("table-4.6", settings, summary, thesis, [*by_object, *rows])


def _with_thesis(row: Row, rows: list[Row]) -> Row:
    """A row of an object with its attempts, ours and the dissertation's."""
    own = [attempts_counted(r, ATTEMPTS) for r in rows if r["object"] == row["object"]]
    return {
        **row,
        "mean_attempts": _mean(own),
        "thesis_attempts": THESIS_ATTEMPTS[row["object"]],
    }


def _mean(values: Sequence[float]) -> float | None:
    return round(float(np.mean(values)), 3) if values else None
