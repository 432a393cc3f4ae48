"""`bench soak`: many whole trials in a row in one process, as a long evaluation has them.

No trial may crash or tell a number that is not finite. Each worker process computes its share of
the trials one after the other and must not grow once its caches are full. Some trials are done
once more at the end, by whichever process is free, and must come out the same to the last byte.
"""

import gc
import hashlib
import json
import math
import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from vh_drake.batch import run_tasks
from vh_drake.catalog import Options
from vh_drake.errors import VhDrakeError
from vh_drake.experiments.grasp_trial import run_trial
from vh_drake.experiments.lift_trials import LiftObject, make_scenario, trial_settings
from vh_drake.objects.library import library_names
from vh_drake.reports import Report, Row

TRIALS = 200
REPEATED = 10  # trials that are done once more
_WARM = 5  # trials of a process after which its caches are full; half of them where there are few


def run(options: Options) -> Report:
    """Trials with point contact of the embedded objects in turn; `runs` is their number.

    Goes on where it was interrupted, in processes that are new then.
    """
    count, names = options.runs or TRIALS, library_names()
    numbers = [*range(count), *range(min(REPEATED, count))]
    tasks = {
        f"{i}": trial_settings(
            LiftObject(names[k % len(names)]), options.seed + k // len(names), "point"
        )
        for i, k in enumerate(numbers)
    }
    settings = {"trials": count, "repeated": REPEATED, "seed": options.seed, "contact": "point"}
    rows = run_tasks(
        soak_row,
        tasks,
        settings=settings,
        journal=options.out / "soak.jsonl",
        workers=options.workers,
        tasks_per_process=len(tasks),
        title="trials",
    )
    return Report("soak", settings, soak_summary(rows, count), {}, rows)


def soak_row(task: Mapping[str, Any]) -> Row:
    """One trial, and the memory of this process after it."""
    scenario = make_scenario(task["scenario"])
    result: Mapping[str, object] = {}
    crash = ""
    try:
        result = run_trial(scenario).result
    except (VhDrakeError, RuntimeError, ArithmeticError, ValueError) as error:
        crash = f"{type(error).__name__}: {error}"
    gc.collect()  # The diagram is a ring of references, and its size is unknown to Python.
    return {
        "object": scenario.object,
        "seed": scenario.seed,
        "lifted": result.get("lifted"),
        "crash": crash,
        "not_finite": sorted(places_not_finite(result)),
        "digest": digest(result),
        "process": os.getpid(),
        "memory_mb": resident_mb(),
    }


def soak_summary(rows: Sequence[Row], count: int) -> Row:
    """Crashes, numbers that are not finite, growth of memory, and whether repetition agrees.

    Args:
        rows: of `count` trials, and then of the first of them once more.
        count: of different trials.
    """
    first, again = rows[:count], rows[count:]
    processes: dict[int, list[float]] = {}
    for row in rows:
        processes.setdefault(row["process"], []).append(row["memory_mb"])
    return {
        "trials": len(rows),
        "most_trials_in_a_process": max(len(memory) for memory in processes.values()),
        "crashes": sum(bool(row["crash"]) for row in rows),
        "trials_with_non_finite_values": sum(bool(row["not_finite"]) for row in rows),
        "memory_growth_mb": round(max(growth_mb(memory) for memory in processes.values()), 1),
        "largest_memory_mb": max(row["memory_mb"] for row in rows),
        "same_again": all(
            a["digest"] == b["digest"] for a, b in zip(first[: len(again)], again, strict=True)
        ),
    }


def growth_mb(memory_mb: Sequence[float]) -> float:
    """By how much a process grew, once its caches were full, over its trials in their order."""
    warm = memory_mb[min(_WARM, (len(memory_mb) - 1) // 2) :]
    return max(warm) - warm[0]


def digest(result: Mapping[str, object]) -> str:
    """Equal where results are equal to the last digit."""
    return hashlib.sha256(json.dumps(result).encode()).hexdigest()


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
