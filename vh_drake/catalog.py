"""What `vh-drake reproduce` and `vh-drake bench` can run, and with which options."""

import dataclasses as dc
import importlib
from collections.abc import Callable, Mapping
from pathlib import Path

from vh_drake.errors import BadInput, UnknownName
from vh_drake.reports import Report


@dc.dataclass(frozen=True, kw_only=True)
class Options:
    """What a user may choose; None leaves the choice to the command.

    Attributes:
        objects: folder of meshes with or without objects.csv.
        runs: repetitions of each object or condition.
        scenes: how many scenes in all.
        contact: "point" or "hydroelastic".
        split: of objects.csv, such as "test".
        weights: of the learned metric.
        strategies: of exploration, comma-separated, or "all".
        seed: of every random choice.
        workers: processes; 0 takes every core.
        out: folder for JSON, CSV, figures and the journal.
    """

    objects: Path | None = None
    runs: int | None = None
    scenes: int | None = None
    contact: str | None = None
    split: str | None = None
    weights: Path | None = None
    strategies: str | None = None
    seed: int = 0
    workers: int = 0
    out: Path


_EVERYWHERE = ("seed", "workers", "out")


@dc.dataclass(frozen=True)
class Entry:
    """One command.

    Attributes:
        module: has a function `run(options: Options) -> Report` that also writes figures;
            the caller saves the report.
        help: one line.
        options: names of what `Options` offers and this command takes, beside seed, workers
            and out.
    """

    module: str
    help: str
    options: tuple[str, ...] = ()


_METRICS = ("objects", "split", "scenes", "weights")
_LIFTS = ("objects", "split", "contact")
_EXPLORED = ("objects", "split", "runs", "strategies")

BENCHES: Mapping[str, Entry] = {
    "force-closure": Entry(
        "vh_drake.benches.force_closure",
        "Force-closure tests beside SciPy's linear program and Qhull.",
        ("runs",),
    ),
    "closing": Entry(
        "vh_drake.benches.closing",
        "Kinematic closings a second on one core; labels and contacts beside a finer grid.",
        ("objects", "split", "runs"),
    ),
    "planners": Entry(
        "vh_drake.benches.planners",
        "Both grasp planners on fused estimates: time, reach, diversity.",
        ("runs",),
    ),
    "soak": Entry(
        "vh_drake.benches.soak",
        "Whole trials in a row: crashes, finite numbers, growth of memory, repetition.",
        ("runs",),
    ),
    "pipeline": Entry(
        "vh_drake.benches.pipeline",
        "A whole trial's time and real-time factor by contact model, on a primitive and a mesh.",
        ("runs",),
    ),
    "contact": Entry(
        "vh_drake.benches.contact",
        "What the wrist feels of objects that the hand approaches at three speeds.",
        ("runs",),
    ),
    "tendon": Entry(
        "vh_drake.benches.tendon",
        "Equilibria of the tendon-driven finger beside NLopt on eq. 4.19.",
    ),
    "control": Entry(
        "vh_drake.benches.control",
        "Random reaches over the table beside Drake's differential inverse kinematics.",
        ("runs",),
    ),
    "gpis": Entry(
        "vh_drake.benches.gpis",
        "Surface estimation beside GPyTorch and scikit-learn: fit, append, grid, mesh, variance.",
    ),
}

REPRODUCTIONS: Mapping[str, Entry] = {
    "figure-3.17": Entry(
        "vh_drake.experiments.figure_3_17",
        "Figures 3.17 to 3.19: what rates a touch, and a plane explored by it.",
    ),
    "figure-3.23": Entry(
        "vh_drake.experiments.figure_3_23",
        "Grasps of the surface-based planner on an object known from touches alone.",
    ),
    "figure-3.24": Entry(
        "vh_drake.experiments.figure_3_24",
        "Grasps of the skeleton-based planner on an object known from touches alone.",
    ),
    "figure-3.25": Entry(
        "vh_drake.experiments.figure_3_25",
        "Two touched objects, the hands of ARMAR-III and ARMAR-6, both planners.",
    ),
    "figure-3.38": Entry(
        "vh_drake.experiments.figure_3_38",
        "Seven touches felt by the tactile sensor's pressure, over many seeds.",
        ("runs",),
    ),
    "figure-3.39": Entry(
        "vh_drake.experiments.figure_3_39",
        "Normals of tilted plates by the tactile sensor, with and without drift.",
        ("runs",),
    ),
    "table-3.5": Entry(
        "vh_drake.experiments.table_3_5",
        "Distance, rotation, errors and contacts of exploration strategies on all objects.",
        _EXPLORED,
    ),
    "appendix-a": Entry(
        "vh_drake.experiments.appendix_a",
        "The distances of table 3.5 by object, beside the thesis's.",
        _EXPLORED,
    ),
    "stopping": Entry(
        "vh_drake.experiments.stopping",
        "Whether an explorer that stops by itself reaches the accuracy that is wanted.",
        ("objects", "split", "runs"),
    ),
    "exploration-tuning": Entry(
        "vh_drake.experiments.exploration_tuning",
        "Which settings suit each exploration strategy best, on the train split.",
        ("objects", "split", "runs"),
    ),
    "figure-3.30": Entry(
        "vh_drake.experiments.figure_3_30",
        "Figures 3.30 to 3.35: ways around three objects, explored share over distance.",
        ("objects", "runs"),
    ),
    "figure-3.36": Entry(
        "vh_drake.experiments.figure_3_36",
        "Distance of predicted and actual contacts on the same three objects.",
        ("objects", "runs"),
    ),
    "figure-3.37": Entry(
        "vh_drake.experiments.figure_3_37",
        "Surface area over the distance that exploring it takes, with regressions.",
        ("objects", "split", "runs"),
    ),
    "table-3.6": Entry(
        "vh_drake.experiments.table_3_6",
        "Surfaces from at most 50 contacts with and without normals, with and without noise.",
        ("runs",),
    ),
    "figure-3.1": Entry(
        "vh_drake.experiments.figure_3_1",
        "Figures 3.1 to 3.3: a plane explored greedily and with balance.",
    ),
    "figure-3.4": Entry(
        "vh_drake.experiments.figure_3_4",
        "Figures 3.4 and 3.20: a touch that meets nothing, and the way back from below.",
    ),
    "figure-3.5": Entry(
        "vh_drake.experiments.figure_3_5",
        "Figures 3.5 to 3.10 and table 3.3: Gaussian processes and surfaces by example.",
    ),
    "figure-3.11": Entry(
        "vh_drake.experiments.figure_3_11",
        "Figures 3.11 and 3.12: flat, corner, stair and cube with and without normals.",
    ),
    "figure-3.13": Entry(
        "vh_drake.experiments.figure_3_13",
        "Figures 3.13 to 3.16: a function of one variable explored by variance.",
    ),
    "figure-4.16": Entry(
        "vh_drake.experiments.figure_4_16",
        "Joint angles of a finger over the shortening of its tendon.",
    ),
    "figure-4.17": Entry(
        "vh_drake.experiments.figure_4_17",
        "Shapes of a finger for several shortenings of its tendon.",
    ),
    "figure-4.18": Entry(
        "vh_drake.experiments.figure_4_18",
        "How a finger closes with friction, glove and weight.",
    ),
    "figure-4.20": Entry(
        "vh_drake.experiments.figure_4_20",
        "The coordinated grasp trajectory, played on the simulated hand with a flashlight.",
    ),
    "figure-4.7": Entry(
        "vh_drake.experiments.figure_4_7",
        "Precision of the learned metric and its baselines on unknown objects.",
        _METRICS,
    ),
    "figure-4.8": Entry(
        "vh_drake.experiments.figure_4_8",
        "Which grasps each metric selects on one object, right and wrong ones.",
        ("objects", "split", "weights"),
    ),
    "table-4.5": Entry(
        "vh_drake.experiments.table_4_5",
        "Success of selected grasps by the number of touches.",
        _METRICS,
    ),
    "estimate": Entry(
        "vh_drake.experiments.estimate",
        "Distance of the estimated surface from the true one, for 0 to 5 touches.",
        ("objects", "split", "runs"),
    ),
    "lift": Entry(
        "vh_drake.experiments.lift",
        "Lift success of the whole robot on the objects of a folder.",
        (*_LIFTS, "runs"),
    ),
    "table-4.6": Entry(
        "vh_drake.experiments.table_4_6",
        "The validation set of eight objects, in ten poses each.",
        ("runs", "contact"),
    ),
    "labels": Entry(
        "vh_drake.experiments.labels",
        "Which label or score predicts that the hand alone lifts the object.",
        ("objects", "split", "scenes", "weights"),
    ),
    "figure-3.26": Entry(
        "vh_drake.experiments.figure_3_26",
        "Figures 3.26 to 3.28: strategies on a plane, a sphere and a cube.",
    ),
    "figure-3.40": Entry(
        "vh_drake.experiments.figure_3_40",
        "Figures 3.40 and 3.41: noisy contacts with and without normals, errors in colour.",
        ("objects",),
    ),
    "closed-loop": Entry(
        "vh_drake.experiments.closed_loop",
        "Closing by motor positions and wrist force beside a tape, on the same scenes.",
        (*_LIFTS, "scenes"),
    ),
    "stages": Entry(
        "vh_drake.experiments.stages",
        "What touch, metric, planners and approaches are worth, in paired trials.",
        (*_LIFTS, "scenes"),
    ),
    "stages-by-hand": Entry(
        "vh_drake.experiments.stages_by_hand",
        "The same with very many lifts by the hand alone.",
        ("objects", "split", "scenes"),
    ),
    "hand-eye": Entry(
        "vh_drake.experiments.hand_eye",
        "One touch against none where the camera's pose is known badly, on the same scenes.",
        (*_LIFTS, "scenes"),
    ),
    "robustness": Entry(
        "vh_drake.experiments.robustness",
        "Lift success under friction, mass, noise and calibration errors, one at a time.",
        (*_LIFTS, "scenes"),
    ),
}


def run_entry(kind: str, entries: Mapping[str, Entry], name: str, options: Options) -> Report:
    """Run a command and save its report.

    Args:
        kind: "benchmark" or "reproduction", for messages.
        entries: by name.
        name: of the command.
        options: what the user chose.

    Raises:
        UnknownName: no such command.
        BadInput: an option that this command does not take, or an unusable value.
        VhDrakeError: the results can't be written.
    """
    if name not in entries:
        raise UnknownName(kind, name, list(entries))
    entry = entries[name]
    _check(name, entry, options)
    run: Callable[[Options], Report] = importlib.import_module(entry.module).run
    report = run(options)
    report.save(options.out)
    return report


def _check(name: str, entry: Entry, options: Options) -> None:
    for field in dc.fields(options):
        value = getattr(options, field.name)
        if field.name in _EVERYWHERE or value is None:
            continue
        if field.name not in entry.options:
            takes = ", ".join(f"--{option}" for option in entry.options) or "none of its own"
            raise BadInput(f"{name} has no option --{field.name}; it takes: {takes}")
        if isinstance(value, int) and value < 1:
            raise BadInput(f"--{field.name} is {value}; choose a positive number")
    if options.seed < 0 or options.workers < 0:
        raise BadInput(f"--seed {options.seed} and --workers {options.workers} can't be negative")
    if options.objects is not None and not options.objects.is_dir():
        raise BadInput(f"--objects {options.objects}: no such folder")
