"""`reproduce labels`: which label or score tells in advance that the hand will lift the object.

Grasps are planned on estimates as in the data set (one look, one touch), and some of them, drawn
by lot, are carried out in a simulator by the hand alone. (Drawn by one of the scores, they would
not be fair to it: where a calibrated score is spread evenly from 0 to 1, the area under its ROC
curve is 5/6 and no more.) Beside each outcome stand what is known of the truth (force-closure rate
and epsilon on the true mesh) and what the robot can know (the same on the estimate, the learned
metric, and what the scorer makes of it).
"""

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vh_drake.catalog import Options
from vh_drake.experiments.figure_files import save_figure
from vh_drake.experiments.hand_scenes import drawn_scene, lifter_of, model_of, rows_of_scenes
from vh_drake.grasping.planner_settings import PlannerSettings
from vh_drake.grasping.planners import plan_candidates
from vh_drake.grasping.scoring import ScoringSettings, score_candidates
from vh_drake.learning.calibration import auc, reliability
from vh_drake.learning.generating import (
    SeenScene,
    hand_model,
)
from vh_drake.learning.labels import LabelSettings, guarded_rates, nominal_epsilon
from vh_drake.learning.lift_model import LiftModel, check_metric, lift_model_beside, load_lift_model
from vh_drake.learning.metric import GraspMetric, load_metric
from vh_drake.learning.pictures import draw_reliability
from vh_drake.reports import Report, Row
from vh_drake.scenes.rating import LearnedRating, learned_rating
from vh_drake.types import Array, Candidates, IntArray

SCENES = 160  # in a few of them nothing is seen, or no grasp is found
GRASPS = 20  # of each scene that are carried out
CANDIDATES = 160  # of each scene, of which they are drawn
TOUCHES = 1
_SURE = LabelSettings(min_samples=48, max_samples=48)
_DRAWS = 1000  # of the bootstrap

# Scores by their name in the rows: what stands in the report.
SCORES: Mapping[str, str] = {
    "learned": "learned score of the robot",
    "metric": "learned metric alone",
    "conventional": "conventional score",
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
    lift_model = load_lift_model(lift_model_beside(options.weights))
    check_metric(lift_model, load_metric(options.weights))  # before the work starts
    weights = None if options.weights is None else str(options.weights)
    own = {
        "scenes": options.scenes or SCENES,
        "grasps": GRASPS,
        "touches": TOUCHES,
        "weights": weights or "shipped",
    }
    rows, settings = rows_of_scenes(lifts_of_scene, options, own, weights=weights)
    save_figure(options.out / "labels.png", draw(rows))
    return Report("labels", settings, summarized(rows, options.seed), {}, [*by_object(rows), *rows])


def lifts_of_scene(task: Mapping[str, Any]) -> list[Row]:
    """One scene: rows of grasps with their scores and what came of them; none without grasps."""
    hand, own = hand_model(""), (task["object"], task["folder"], task["mass_kg"])
    seen = drawn_scene(model_of(*own), task["object"], task["seed"], TOUCHES)
    if seen is None:
        return []
    settings = PlannerSettings(candidates=CANDIDATES)
    planned = plan_candidates(seen.surface, seen.view.table, hand, settings, task["seed"])
    if len(planned) == 0:
        return []
    candidates = planned.taken(drawn_by_lot(len(planned), GRASPS, task["seed"]))
    scene = (candidates, seen.surface, seen.view, seen.contacts)
    rating = learned_rating(
        _metric(task["weights"]), _lift_model(task["weights"]), hand, task["seed"], scene
    )
    scores = _scores(seen, candidates, rating, task["seed"])
    lifter = lifter_of(*own)
    rows = []
    for i in range(len(candidates)):
        lift = lifter.lift(seen.truth.X_WO, candidates.X_WH[i], candidates.motion[i])
        rows.append(
            {
                **{name: task[name] for name in ("object", "split", "kind", "seed")},
                "motion": candidates.motion[i],
                "planner": candidates.planner[i],
                "lifted": lift.lifted,
                "height_m": round(lift.height_m, 4),
                **{name: round(float(values[i]), 5) for name, values in scores.items()},
            }
        )
    return rows


def drawn_by_lot(count: int, most: int, seed: int) -> IntArray:
    """Indices of some of `count` candidates, at most so many, all equally likely; sorted."""
    rng = np.random.default_rng([seed, 59])
    return np.sort(rng.choice(count, min(count, most), replace=False))


def _scores(
    seen: SeenScene, grasps: Candidates, rating: LearnedRating, seed: int
) -> dict[str, Array]:
    """Of the grasps, by the names of SCORES."""
    hand, plane, settings = hand_model(""), seen.view.table, ScoringSettings()
    return {
        "learned": rating.lift,
        "metric": rating.told.success,
        "conventional": score_candidates(grasps, seen.surface, plane, hand, settings, seed).score,
        "rate": guarded_rates(grasps, seen.field, hand, _SURE, seed).rate,
        "rate_on_estimate": guarded_rates(grasps, seen.estimate, hand, _SURE, seed + 1).rate,
        "epsilon": nominal_epsilon(grasps, seen.field, hand, _SURE),
        "epsilon_on_estimate": nominal_epsilon(grasps, seen.estimate, hand, _SURE),
        "nominal_on_estimate": rating.hints.nominal.astype(float),
    }


@lru_cache(maxsize=1)
def _lift_model(weights: str | None) -> LiftModel:
    return load_lift_model(lift_model_beside(weights))


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
