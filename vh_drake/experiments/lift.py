"""`reproduce lift`: how often the whole robot lifts the objects of a folder."""

from vh_drake.catalog import Options
from vh_drake.experiments.lift_trials import (
    CLASSES,
    LiftObject,
    chosen_objects,
    run_trials,
    share,
    trial_settings,
    wilson_interval,
)
from vh_drake.reports import Report, Row

ATTEMPTS = 3


def run(options: Options) -> Report:
    """Trials of every object in several poses, one touch each, up to three attempts.

    Raises:
        BadInput: folder or options are unusable.
    """
    objects, left_out = chosen_objects(options)
    runs, contact = options.runs or 5, options.contact or "hydroelastic"
    tasks = {
        f"{item.name} {seed}": trial_settings(item, seed, contact, attempts=ATTEMPTS)
        for item in objects
        for seed in range(options.seed, options.seed + runs)
    }
    settings = {
        "objects": [item.name for item in objects],
        "left_out": left_out,
        "runs": runs,
        "seed": options.seed,
        "contact": contact,
        "attempts": ATTEMPTS,
        "touches": 1,
    }
    rows = run_trials(tasks, options, settings, "lifting")
    return Report("lift", settings, lift_summary(rows), {}, [*object_rows(objects, rows), *rows])


def lift_summary(rows: list[Row]) -> Row:
    """Success at the first attempt and at all, in all and by class, with 95 % intervals."""
    summary = _success("", rows)
    for kind in CLASSES:
        of_kind = [row for row in rows if row["kind"] == kind]
        if of_kind and len(of_kind) < len(rows):
            summary |= _success(f"{kind}_", of_kind)
    return summary


def _success(prefix: str, rows: list[Row]) -> Row:
    summary: Row = {}
    for name, key in (("first_attempt", "lifted_first"), ("overall", "lifted")):
        summary[f"{prefix}{name}_success"] = round(share(rows, key), 4)
        count = sum(bool(row[key]) for row in rows)
        summary[f"{prefix}{name}_interval"] = wilson_interval(count, len(rows))
    return summary | {f"{prefix}trials": len(rows)}


def object_rows(objects: list[LiftObject], rows: list[Row]) -> list[Row]:
    """Success of each object."""
    return [
        {
            "object": item.name,
            "split": item.split,
            "kind": item.kind,
            "trials": len(own),
            "first_attempt_success": round(share(own, "lifted_first"), 4),
            "overall_success": round(share(own, "lifted"), 4),
        }
        for item in objects
        if (own := [row for row in rows if row["object"] == item.name])
    ]
