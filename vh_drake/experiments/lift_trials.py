"""Whole trials as tasks of a batch: settings that JSON holds in, a row of numbers out."""

import dataclasses as dc
import gc
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vh_drake.batch import run_tasks
from vh_drake.catalog import Options
from vh_drake.errors import BadInput, VhDrakeError
from vh_drake.experiments.grasp_trial import run_trial
from vh_drake.objects.folders import FolderEntry, read_folder
from vh_drake.objects.library import library_names
from vh_drake.reports import Row
from vh_drake.scenes.scenario import POINT_STEP_S, Scenario, check_scenario

CLASSES = ("core", "hard")  # of objects that the hand is asked to lift; "no" is left out


@dc.dataclass(frozen=True)
class LiftObject:
    """What is to be lifted."""

    name: str
    folder: str = ""  # empty: the embedded library
    mass_kg: float | None = None  # None takes the known mass
    split: str = "embedded"
    kind: str = "core"  # of CLASSES


def chosen_objects(options: Options) -> tuple[list[LiftObject], dict[str, str]]:
    """Objects of a run, and those left out with the reason.

    Without a folder it is the embedded library. Of a folder with objects.csv it is the split
    of the options ("test" unless given) without those whose column `lift` says "no".

    Raises:
        BadInput: the folder is unusable, or nothing is left.
    """
    if options.objects is None:
        return [LiftObject(name) for name in library_names()], {}
    entries = read_folder(options.objects)
    split = options.split or "test"
    if not any(entry.split for entry in entries.values()):
        split = ""
    left_out: dict[str, str] = {}
    chosen = []
    for name, entry in sorted(entries.items()):
        if split and entry.split != split:
            continue
        if entry.lift == "no":
            left_out[name] = "objects.csv: too large, too flat or too small for the hand"
            continue
        chosen.append(_object_of(options.objects, name, entry))
    if not chosen:
        raise BadInput(f"{options.objects}: no object of split {split!r} to lift")
    return chosen, left_out


def _object_of(folder: Path, name: str, entry: FolderEntry) -> LiftObject:
    kind = entry.lift if entry.lift in CLASSES else "core"
    return LiftObject(name, str(folder), entry.mass_kg, entry.split, kind)


def trial_settings(item: LiftObject, seed: int, contact: str, **changes: Any) -> Row:
    """The task of one trial; `changes` are fields of the Scenario, nested ones as dicts."""
    step = POINT_STEP_S if contact == "point" else Scenario().time_step_s
    scenario = {
        "object": item.name,
        "objects": item.folder,
        "mass_kg": item.mass_kg,
        "seed": seed,
        "contact": contact,
        "time_step_s": step,
        **changes,
    }
    return {"scenario": scenario, "split": item.split, "kind": item.kind}


def run_trials(
    tasks: Mapping[str, Row], options: Options, settings: Mapping[str, Any], title: str
) -> list[Row]:
    """Rows of trials, in the order of the tasks; resumes from the journal in the out folder."""
    return run_tasks(
        lift_row,
        tasks,
        settings=settings,
        journal=options.out / "journal.jsonl",
        workers=options.workers,
        title=title,
    )


def lift_row(task: Mapping[str, Any]) -> Row:
    """One trial: what came of it. A trial that can't be run is a failed one and says why."""
    scenario = make_scenario(task["scenario"])
    row: Row = {
        "object": scenario.object,
        "split": task["split"],
        "kind": task["kind"],
        "seed": scenario.seed,
    }
    try:
        result = run_trial(scenario).result
    except (VhDrakeError, RuntimeError) as error:  # Drake's are RuntimeErrors.
        return {**row, **_NOTHING, "failure": str(error)}
    finally:
        gc.collect()  # The diagram is a ring of references, and its size is unknown to Python.
    return {**row, **_outcome(result)}


def make_scenario(values: Mapping[str, Any]) -> Scenario:
    """A checked scenario of plain values.

    Raises:
        BadInput: a value is out of range.
    """
    scenario: Scenario = _changed(Scenario(), values)
    check_scenario(scenario)
    return scenario


def _changed(old: Any, values: Mapping[str, Any]) -> Any:
    """A dataclass with other values; nested ones are changed likewise."""
    new = {
        name: _changed(getattr(old, name), value) if isinstance(value, Mapping) else value
        for name, value in values.items()
    }
    return dc.replace(old, **new)


_NOTHING: Row = {
    "lifted": False,
    "lifted_first": False,
    "attempts": 0,
    "robot_was_right": None,
    "touched_hidden": None,
    "surface_error_mm": None,
    "score": None,
    "motion": None,
    "slip_mm": None,
    "height_m": 0.0,
    "failure": "",
}


def _outcome(result: Mapping[str, Any]) -> Row:
    attempts = result["attempts"]
    last: Mapping[str, Any] = attempts[-1] if attempts else {"grasp": {}, "lift": {}}
    felt = last["grasp"].get("robot_feels_it_held")
    return {
        "lifted": result["lifted"],
        "lifted_first": bool(attempts) and attempts[0]["lift"]["lifted"],
        "attempts": len(attempts),
        "robot_was_right": None if felt is None else felt == result["lifted"],
        "touched_hidden": _hidden(result["touches"]),
        "surface_error_mm": result["surface_error_mm"],
        "score": last["grasp"].get("score"),
        "motion": last["grasp"].get("motion"),
        "slip_mm": result["slip_mm"],
        "height_m": result["height_m"],
        "failure": result["failure"],
    }


def _hidden(touches: Sequence[Mapping[str, Any]]) -> bool | None:
    """Whether every felt touch was of a hidden place; None without one."""
    felt = [touch.get("faces_away_from_camera") for touch in touches if touch["felt"]]
    return all(felt) if felt else None


def share(rows: Sequence[Row], key: str) -> float:
    """Of rows in which a value is true; NaN where there are none."""
    return float(np.mean([bool(row[key]) for row in rows])) if rows else float("nan")


def wilson_interval(successes: int, trials: int, z: float = 1.96) -> list[float]:
    """95 % interval of a success probability (Wilson 1927)."""
    if trials == 0:
        return [0.0, 1.0]
    p, n = successes / trials, trials
    middle = (p + z * z / (2 * n)) / (1 + z * z / n)
    half = z * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n)) / (1 + z * z / n)
    return [round(max(0.0, middle - half), 4), round(min(1.0, middle + half), 4)]


def attempts_counted(row: Row, limit: int) -> int:
    """Attempts of a trial; a failed one counts the limit."""
    return int(row["attempts"]) if row["lifted"] else limit
