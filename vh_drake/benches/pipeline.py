"""`bench pipeline`: one whole trial's time by contact model, on a primitive and on a mesh.

Seconds by the clock on the wall count where nothing else runs on the machine; those of the
processor, beside them, hardly depend on what else does.
"""

from collections.abc import Callable, Iterable, Sequence

import numpy as np

from vh_drake.benches.timing import best_ms
from vh_drake.catalog import Options
from vh_drake.experiments.grasp_trial import run_trial
from vh_drake.experiments.lift_trials import LiftObject, make_scenario, trial_settings
from vh_drake.learning.generating import (
    GeneratorSettings,
    candidates_of,
    hand_model,
    seen_scene,
)
from vh_drake.learning.scene import SceneSettings
from vh_drake.objects.library import library_object
from vh_drake.reports import Report, Row
from vh_drake.scenes.rating import make_scorer

Best = Callable[[Iterable[float]], float]
OBJECTS = {"primitive": "fruit_drink", "mesh": "banana"}
CONTACTS = ("hydroelastic", "point")
CANDIDATES = 800


def run(options: Options) -> Report:
    """Trials of both objects with both contact models, and the rating of 800 candidates.

    `runs` is the number of trials of each; the first compiles what is not yet compiled.
    """
    runs = options.runs or 2
    rows = [
        trial_row(kind, contact, options.seed + k)
        for kind in OBJECTS
        for contact in CONTACTS
        for k in range(runs)
    ]
    settings = {"objects": OBJECTS, "runs": runs, "seed": options.seed, "candidates": CANDIDATES}
    return Report("pipeline", settings, summarized(rows) | rating_time(options.seed), {}, rows)


def trial_row(kind: str, contact: str, seed: int) -> Row:
    """One trial with one attempt."""
    task = trial_settings(LiftObject(OBJECTS[kind]), seed, contact, attempts=1, scorer="learned")
    done = run_trial(make_scenario(task["scenario"]))
    stages = done.timing["stages"]
    assert isinstance(stages, dict)
    return {
        "kind": kind,
        "contact": contact,
        "object": OBJECTS[kind],
        "seed": seed,
        "lifted": done.lifted,
        **{name: value for name, value in done.timing.items() if name != "stages"},
        **{f"{name}_processor_s": stage["processor_s"] for name, stage in stages.items()},
    }


def summarized(rows: Sequence[Row]) -> Row:
    """Of each contact model the slower kind of object; the best run of each counts."""
    summary: Row = {}
    for contact in CONTACTS:
        own = [row for row in rows if row["contact"] == contact]
        prefix = "" if contact == CONTACTS[0] else f"{contact}_"
        summary[f"{prefix}wall_s"] = max(_best(own, kind, "wall_s", min) for kind in OBJECTS)
        for kind in OBJECTS:
            for name in ("real_time_factor", "real_time_factor_processor"):
                summary[f"{prefix}{name}_{kind}"] = _best(own, kind, name, max)
        factors = [summary[f"{prefix}real_time_factor_{kind}"] for kind in OBJECTS]
        summary[f"{prefix}real_time_factor"] = min(factors)
    return summary


def _best(
    rows: Sequence[Row], kind: str, name: str, best: Callable[[Iterable[float]], float]
) -> float:
    return float(best(row[name] for row in rows if row["kind"] == kind))


def rating_time(seed: int) -> Row:
    """Processor time in which the learned scorer rates 800 candidates on one estimate."""
    hand, mesh = hand_model(""), library_object(OBJECTS["primitive"]).mesh
    plain = GeneratorSettings(scene=SceneSettings(scale=[1.0, 1.0], stretch=[1.0, 1.0]))
    seen = seen_scene(mesh, plain, np.random.default_rng(seed), touches=1)
    candidates = candidates_of(seen, hand, CANDIDATES, seed)
    score = make_scorer("learned", hand, seed)
    spent = best_ms(lambda: score(candidates, seen.surface, seen.view, seen.contacts), repeats=3)
    return {"rate_800_s": round(spent / 1e3 * CANDIDATES / len(candidates), 3)}
