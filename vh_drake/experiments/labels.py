"""`reproduce labels`: which label or score tells in advance that the hand will lift the object.

Grasps are planned on estimates as in the data set (one look, one touch), drawn so that their
scores spread evenly, and carried out in a simulator by the hand alone. Beside each outcome
stand what is known of the truth (force-closure rate and epsilon on the true mesh) and what the
robot can know (the same on the estimate, the learned metric, and what the scorer makes of it).
"""

from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vh_drake.batch import run_tasks
from vh_drake.catalog import Options
from vh_drake.errors import BadInput, NothingSeen
from vh_drake.experiments.figure_files import save_figure
from vh_drake.experiments.lift_trials import LiftObject, chosen_objects
from vh_drake.experiments.robustness import scenes
from vh_drake.grasping.in_hand import PlaceSettings, lie_in_hand
from vh_drake.grasping.planner_settings import PlannerSettings
from vh_drake.grasping.planners import plan_candidates
from vh_drake.learning.calibration import auc, reliability
from vh_drake.learning.generating import (
    GeneratorSettings,
    SeenScene,
    hand_model,
    seen_scene,
)
from vh_drake.learning.labels import LabelSettings, guarded_rates, nominal_epsilon
from vh_drake.learning.metric import GraspMetric, load_metric
from vh_drake.learning.pictures import draw_reliability
from vh_drake.learning.scene import SceneSettings
from vh_drake.objects.loading import load_object
from vh_drake.objects.model import ObjectModel
from vh_drake.reports import Report, Row
from vh_drake.scenes.hand_lift import HandLifter
from vh_drake.scenes.rating import LearnedRating, learned_rating
from vh_drake.scenes.scenario import Table
from vh_drake.types import Array, Candidates, IntArray

SCENES = 150
GRASPS = 20  # of each scene that are carried out
CANDIDATES = 160  # of each scene, of which they are drawn
TOUCHES = 1
_TRIES = 4  # poses of an object until one can be grasped at all
_SURE = LabelSettings(min_samples=48, max_samples=48)
_DRAWS = 1000  # of the bootstrap

# Scores by their name in the rows: what stands in the report.
SCORES: Mapping[str, str] = {
    "learned": "learned score of the robot",
    "metric": "learned metric alone",
    "sense": "physical sense alone",
    "rate": "force-closure rate, true shape",
    "rate_on_estimate": "force-closure rate, estimate",
    "epsilon": "epsilon, true shape",
    "epsilon_on_estimate": "epsilon, estimate",
    "nominal_on_estimate": "force closure, estimate",
}


def run(options: Options) -> Report:
    """Lifts of planned grasps by the hand alone; writes labels.png.

    Raises:
        BadInput: an option is unusable.
    """
    objects, left_out = chosen_objects(options)
    load_metric(options.weights)  # Refuses bad weights before the work starts.
    count = options.scenes or SCENES
    weights = None if options.weights is None else str(options.weights)
    tasks = {
        f"{item.name} {seed}": _task(item, seed, weights)
        for item, seed in scenes(objects, count, options.seed)
    }
    settings = {
        "objects": [item.name for item in objects],
        "left_out": left_out,
        "scenes": count,
        "grasps": GRASPS,
        "touches": TOUCHES,
        "weights": weights or "shipped",
        "seed": options.seed,
        "contact": "point",
    }
    found = run_tasks(
        lifts_of_scene,
        tasks,
        settings=settings,
        journal=options.out / "journal.jsonl",
        workers=options.workers,
        title="lifting",
    )
    rows = [row for scene in found for row in scene]
    save_figure(options.out / "labels.png", draw(rows))
    return Report("labels", settings, summarized(rows, options.seed), {}, [*by_object(rows), *rows])


def _task(item: LiftObject, seed: int, weights: str | None) -> Row:
    return {
        "object": item.name,
        "folder": item.folder,
        "mass_kg": item.mass_kg,
        "split": item.split,
        "kind": item.kind,
        "seed": seed,
        "weights": weights,
    }


def lifts_of_scene(task: Mapping[str, Any]) -> list[Row]:
    """One scene: rows of grasps with their scores and what came of them; none without grasps."""
    hand, model = hand_model(""), _model(task["object"], task["folder"], task["mass_kg"])
    drawn = _drawn_scene(model, task["object"], task["seed"])
    if drawn is None:
        return []
    seen, candidates = drawn
    scene = (candidates, seen.surface, seen.view, seen.contacts)
    rating = learned_rating(_metric(task["weights"]), hand, task["seed"], scene)
    chosen = spread_over(rating.scores().score, GRASPS)
    scores = _scores(seen, candidates, rating, chosen, task["seed"])
    lifter = _lifter(task["object"], task["folder"], task["mass_kg"])
    rows = []
    for k, i in enumerate(chosen):
        lift = lifter.lift(seen.truth.X_WO, candidates.X_WH[i], candidates.motion[i])
        rows.append(
            {
                **{name: task[name] for name in ("object", "split", "kind", "seed")},
                "motion": candidates.motion[i],
                "planner": candidates.planner[i],
                "lifted": lift.lifted,
                "height_m": round(lift.height_m, 4),
                **{name: round(float(values[k]), 5) for name, values in scores.items()},
            }
        )
    return rows


def _drawn_scene(model: ObjectModel, name: str, seed: int) -> tuple[SeenScene, Candidates] | None:
    """A scene as in the data set, drawn anew where nothing is seen or no hand finds a place."""
    plain = SceneSettings(scale=[1.0, 1.0], stretch=[1.0, 1.0])
    settings = GeneratorSettings(scene=plain)
    for attempt in range(_TRIES):
        rng = np.random.default_rng([seed, attempt, *name.encode()])
        try:
            seen = seen_scene(model.mesh, settings, rng, touches=TOUCHES)
            candidates = plan_candidates(
                seen.surface,
                seen.view.table,
                hand_model(""),
                PlannerSettings(candidates=CANDIDATES),
                seed,
            )
        except (NothingSeen, BadInput):
            continue
        if len(candidates):
            return seen, candidates
    return None


def spread_over(score: Array, count: int) -> IntArray:
    """Indices of candidates whose scores are next to evenly spaced values, low to high."""
    left = list(np.argsort(score, kind="stable"))
    chosen = []
    for value in np.linspace(score.min(), score.max(), min(count, len(score))):
        best = min(left, key=lambda i: abs(score[i] - value))
        left.remove(best)
        chosen.append(best)
    return np.array(chosen, np.int64)


def _scores(
    seen: SeenScene, candidates: Candidates, rating: LearnedRating, chosen: IntArray, seed: int
) -> dict[str, Array]:
    """Of the chosen candidates, by the names of SCORES and of the parts of physical sense."""
    hand, own = hand_model(""), candidates.taken(chosen)
    sense, hints = rating.sense, rating.hints
    return {
        "learned": rating.scores().score[chosen],
        "metric": rating.told.success[chosen],
        "sense": (sense.centered * sense.held * sense.placed)[chosen],
        "rate": guarded_rates(own, seen.field, hand, _SURE, seed).rate,
        "rate_on_estimate": guarded_rates(own, seen.estimate, hand, _SURE, seed + 1).rate,
        "epsilon": nominal_epsilon(own, seen.field, hand, _SURE),
        "epsilon_on_estimate": nominal_epsilon(own, seen.estimate, hand, _SURE),
        "nominal_on_estimate": hints.nominal[chosen].astype(float),
        "centered": sense.centered[chosen],
        "held": sense.held[chosen],
        "certain": sense.certain[chosen],
        "placed": sense.placed[chosen],
        "expected_rate": rating.told.rate[chosen],
        **_places(seen, own),
    }


def _places(seen: SeenScene, candidates: Candidates) -> dict[str, Array]:
    """How the estimate lies in the open hand, in mm, for fits of what makes a lift succeed."""
    names = np.array(candidates.motion)
    table = np.zeros((3, len(candidates)))
    for motion in set(candidates.motion):
        own = names == motion
        X_WH, surface = candidates.X_WH[own], seen.surface.vertices
        hand, place = hand_model(""), PlaceSettings()
        lie = lie_in_hand(X_WH, motion, surface, seen.estimate, hand, place)
        table[:, own] = 1e3 * np.stack([lie.middle, lie.excess, lie.beside])
    return dict(zip(("along_mm", "excess_mm", "beside_mm"), table, strict=True))


@lru_cache(maxsize=2)
def _model(name: str, folder: str, mass_kg: float | None) -> ObjectModel:
    return load_object(name, mass_kg=mass_kg, folder=Path(folder) if folder else None)


@lru_cache(maxsize=2)
def _lifter(name: str, folder: str, mass_kg: float | None) -> HandLifter:
    plain = SceneSettings()
    table = Table(height_m=plain.table_height_m, center=list(plain.center))
    return HandLifter(hand_model(""), _model(name, folder, mass_kg), table)


@lru_cache(maxsize=1)
def _metric(weights: str | None) -> GraspMetric:
    return load_metric(weights)


def summarized(rows: Sequence[Row], seed: int) -> Row:
    """Areas under the ROC curves, pooled and within objects, and calibration."""
    lifted = np.array([row["lifted"] for row in rows], bool)
    summary: Row = {
        "lifts": len(rows),
        "scenes": len({(row["object"], row["seed"]) for row in rows}),
        "lifted_share": round(float(lifted.mean()), 4) if len(rows) else None,
    }
    if not rows:
        return summary
    for name in SCORES:
        values = np.array([row[name] for row in rows])
        summary[f"auc_{name}"] = round(auc(values, lifted), 4)
    summary["auc_learned_interval"] = _interval(rows, "learned", seed)
    summary["auc_rate_interval"] = _interval(rows, "rate", seed)
    for name in ("learned", "metric", "rate"):
        values = np.array([row[name] for row in rows])
        summary[f"calibration_error_{name}"] = round(reliability(values, lifted).error, 4)
    return summary


def _interval(rows: Sequence[Row], name: str, seed: int) -> list[float]:
    """95 % interval of an area, by drawing objects with replacement."""
    groups: dict[str, list[Row]] = {}
    for row in rows:
        groups.setdefault(row["object"], []).append(row)
    own = [
        (np.array([r[name] for r in group]), np.array([r["lifted"] for r in group], bool))
        for group in groups.values()
    ]
    rng, areas = np.random.default_rng(seed), []
    for _ in range(_DRAWS):
        drawn = rng.integers(len(own), size=len(own))
        scores = np.concatenate([own[i][0] for i in drawn])
        areas.append(auc(scores, np.concatenate([own[i][1] for i in drawn])))
    return [round(float(x), 4) for x in np.percentile(areas, (2.5, 97.5))]


def by_object(rows: Sequence[Row]) -> list[Row]:
    """Lifted share and areas of each object."""
    result = []
    for name in sorted({row["object"] for row in rows}):
        own = [row for row in rows if row["object"] == name]
        lifted = np.array([row["lifted"] for row in own], bool)
        areas = {
            f"auc_{score}": round(auc(np.array([row[score] for row in own]), lifted), 4)
            for score in ("learned", "metric", "rate", "epsilon")
        }
        share = round(float(lifted.mean()), 4)
        kind = {"split": own[0]["split"], "kind": own[0]["kind"]}
        result.append({"object": name, **kind, "lifts": len(own), "lifted_share": share, **areas})
    return result


def draw(rows: Sequence[Row]) -> Figure:
    """ROC curves and reliability."""
    figure = Figure(figsize=(12.0, 5.5), layout="constrained")
    left, right = figure.subplots(1, 2)
    draw_roc(left, rows)
    lifted = np.array([row["lifted"] for row in rows], bool)
    diagrams = {
        SCORES[name]: reliability(np.array([row[name] for row in rows]), lifted)
        for name in ("learned", "metric", "rate")
    }
    draw_reliability(right, diagrams)
    right.set(xlabel="score", ylabel="share that was lifted", title="Reliability of the scores")
    return figure


def draw_roc(axes: Axes, rows: Sequence[Row]) -> None:
    """True over false alarms for every threshold of each score."""
    lifted = np.array([row["lifted"] for row in rows], bool)
    for name, label in SCORES.items():
        score = np.array([row[name] for row in rows])
        steps = np.unique(score)[::-1]
        hits = [0.0, *((score >= t)[lifted].mean() for t in steps), 1.0]
        alarms = [0.0, *((score >= t)[~lifted].mean() for t in steps), 1.0]
        width = 2.5 if name == "learned" else 1.2
        axes.plot(alarms, hits, lw=width, label=f"{label}: {auc(score, lifted):.3f}")
    axes.plot([0, 1], [0, 1], color="black", lw=0.8, ls=":", label="by lot: 0.5")
    axes.set(
        xlabel="share of failing grasps that are accepted",
        ylabel="share of lifting grasps that are accepted",
        xlim=(0, 1),
        ylim=(0, 1),
        title="Area under the curve by score",
    )
    axes.legend(loc="lower right", fontsize="small")
