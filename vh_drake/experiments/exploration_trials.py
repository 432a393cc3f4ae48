"""Many explorations of many objects as tasks of a batch."""

from collections.abc import Mapping, Sequence
from typing import Any

from vh_drake.batch import run_tasks
from vh_drake.catalog import Options
from vh_drake.errors import BadInput
from vh_drake.experiments.contenders import CONTENDERS, subject
from vh_drake.exploration.tuned import TUNED
from vh_drake.objects.folders import read_folder
from vh_drake.objects.library import library_names
from vh_drake.reports import Row

RUNS = 20
LEAST_SIDE_M = 0.05  # smaller objects are explored by a few touches
RESULT_SPLIT = "test"
_RUNS_PER_PROCESS = 2000


def explored_objects(options: Options) -> dict[str, str]:
    """Names with their splits: of a folder, all that are large enough, else of the library.

    Args:
        options: with a split, only its objects are taken.

    Raises:
        BadInput: the folder is unusable, or nothing is left.
    """
    if options.objects is None:
        names = dict.fromkeys(library_names(), "library")
    else:
        entries = read_folder(options.objects)
        split = options.split
        names = {n: e.split for n, e in sorted(entries.items()) if split in (None, e.split)}
    folder = _folder(options)
    large = {
        name: split
        for name, split in names.items()
        if subject(name, folder).model.mesh.extents.max() >= LEAST_SIDE_M
    }
    if not large:
        of = "" if options.split is None else f" of split {options.split!r}"
        raise BadInput(f"{options.objects}: no object{of} with a side of 5 cm or more")
    return large


def run_explorations(
    options: Options, objects: Mapping[str, str], contenders: Sequence[str], *, runs: int
) -> tuple[Row, list[Row]]:
    """Settings and one row a run; resumes from the journal in the out folder.

    Raises:
        BadInput: the journal is of other settings.
    """
    settings: Row = {
        "objects": dict(objects),
        "runs": runs,
        "seed": options.seed,
        "contenders": list(contenders),
        "goal": 0.8,
        "explored_radius_m": 0.02,
        "least_side_m": LEAST_SIDE_M,
        "strategies": {name: repr(TUNED[name]) for name in contenders if name in TUNED},
    }
    folder = _folder(options)
    tasks = {
        f"{name} {contender} {seed}": {
            "object": name,
            "folder": folder,
            "split": split,
            "contender": contender,
            "seed": seed,
        }
        for name, split in objects.items()
        for contender in contenders
        for seed in range(options.seed, options.seed + runs)
    }
    rows: list[Row] = run_tasks(
        exploration_row,
        tasks,
        settings=settings,
        journal=options.out / "explorations.jsonl",
        workers=options.workers,
        tasks_per_process=_RUNS_PER_PROCESS,
        title="explorations",
    )
    return settings, rows


def exploration_row(task: Mapping[str, Any]) -> Row:
    """One exploration: what was explored by whom, and its numbers."""
    explored = subject(task["object"], task["folder"])
    return {
        "object": task["object"],
        "split": task["split"],
        "contender": task["contender"],
        "seed": task["seed"],
        "area_cm2": round(1e4 * float(explored.model.mesh.areas.sum()), 2),
        **CONTENDERS[task["contender"]](explored, task["seed"]),
    }


def _folder(options: Options) -> str:
    return "" if options.objects is None else str(options.objects)
