"""`bench soak`: many whole trials in one process, as a long evaluation has them.

No trial may crash or tell a number that is not finite, and the first trial, done once more at the
end, must come out the same. Memory grows by some 63 MB a trial, since Drake 1.51 does not free
diagrams that hold systems of Python; batches of trials therefore take new processes on the way.
"""

import gc
import math
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from vh_drake.catalog import Options
from vh_drake.errors import VhDrakeError
from vh_drake.experiments.grasp_trial import run_trial
from vh_drake.experiments.lift_trials import LiftObject, make_scenario, trial_settings
from vh_drake.objects.library import library_names
from vh_drake.reports import Report, Row

TRIALS = 200
_WARM = 5  # trials after which caches are full; half of them where there are few


def run(options: Options) -> Report:
    """Trials with point contact of the embedded objects in turn; `runs` is their number."""
    count, names = options.runs or TRIALS, library_names()
    rows, results = [], []
    for k in [*range(count), 0]:
        name, seed = names[k % len(names)], options.seed + k // len(names)
        result, crash = _trial(name, seed)
        results.append(result)
        rows.append(
            {
                "object": name,
                "seed": seed,
                "lifted": result.get("lifted"),
                "crash": crash,
                "not_finite": sorted(places_not_finite(result)),
                "memory_mb": resident_mb(),
            }
        )
    settings = {"trials": count, "seed": options.seed, "contact": "point"}
    return Report("soak", settings, summarized(rows, results[0] == results[-1]), {}, rows)


def _trial(name: str, seed: int) -> tuple[dict[str, Any], str]:
    """Its result.json, and why there is none."""
    task = trial_settings(LiftObject(name), seed, "point")
    try:
        result = run_trial(make_scenario(task["scenario"])).result
    except (VhDrakeError, RuntimeError, ArithmeticError, ValueError) as error:
        return {}, f"{type(error).__name__}: {error}"
    finally:
        gc.collect()  # Diagrams that hold systems of Python are rings of references.
    return result, ""


def summarized(rows: list[Row], same: bool) -> Row:
    """Crashes, numbers that are not finite, and how the memory grew once caches were full."""
    memory = [row["memory_mb"] for row in rows]
    warm = memory[min(_WARM, (len(memory) - 1) // 2) :]
    return {
        "trials": len(rows),
        "crashes": sum(bool(row["crash"]) for row in rows),
        "trials_with_non_finite_values": sum(bool(row["not_finite"]) for row in rows),
        "memory_growth_mb": round(max(warm) - warm[0], 1),
        "largest_memory_mb": max(memory),
        "same_again": same,
    }


def places_not_finite(value: Any, place: str = "") -> Iterator[str]:
    """Where in nested results a number is NaN or infinite."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from places_not_finite(inner, f"{place}/{key}")
    elif isinstance(value, list | tuple):
        for i, inner in enumerate(value):
            yield from places_not_finite(inner, f"{place}/{i}")
    elif isinstance(value, float) and not math.isfinite(value):
        yield place


def resident_mb() -> float:
    """Memory of this process that is in use now."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return round(pages * os.sysconf("SC_PAGE_SIZE") / 2**20, 1)
