"""How well metrics predict which grasps succeed (section 4.4.2).

Every metric rates the same candidates, the labels say what came of them. The learned metric is
taken with hints, which is how the robot uses it, and blind; beside it stand the thesis's baseline
(closed on the estimate), epsilon, and the force-closure rate on the estimate.
"""

import dataclasses as dc
import hashlib
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from vh_drake.batch import run_tasks
from vh_drake.geometry.meshes import Mask
from vh_drake.learning.calibration import auc, reliability, reliability_sums
from vh_drake.learning.dataset import shard_paths
from vh_drake.learning.generating import hand_model
from vh_drake.learning.knowledge import scene_knowledge
from vh_drake.learning.labels import SUCCESS_RATE, LabelSettings, nominal_epsilon
from vh_drake.learning.metric import GraspMetric, load_metric, shipped_weights
from vh_drake.learning.shards import LabelledScene, read_shard
from vh_drake.types import Array

THRESHOLD = 0.95  # of the learned probability and of the rate on the estimate
LEAST_SHARE = 0.02  # of a scene's candidates that a useful metric selects
GRASPABLE_SHARE = 0.05  # of a scene's candidates that succeed where it counts
METRICS = ("learned", "blind", "rate", "epsilon", "nominal")
_DIGITS = 4
_DRAWS = 2000  # of the bootstrap
_ENDS = (2.5, 97.5)  # of an interval, in percent


@dc.dataclass(frozen=True, eq=False)
class Judged:
    """One scene's n candidates: what each metric said, and what came of them."""

    object: str
    scene: int
    contacts: int  # touches that were felt
    touches: int  # touches that were tried
    success: Mask  # (n,)
    scores: Mapping[str, Array]  # (n,) of each metric

    def selected(self, name: str) -> Mask:
        """(n,) what a metric calls good at its threshold."""
        least = 0.0 if name in ("nominal", "epsilon") else THRESHOLD
        return np.asarray(self.scores[name] > least)

    @property
    def graspable(self) -> bool:
        """Whether enough candidates succeed for a metric to find some."""
        return bool(self.success.mean() >= GRASPABLE_SHARE)


def judge_dataset(
    folder: Path,
    weights: Path | None,
    *,
    journal: Path | None = None,
    workers: int = 0,
    touch_counts: Sequence[int] = (),
    title: str = "",
) -> list[Judged]:
    """Let every metric rate the candidates of a labelled data set.

    Args:
        folder: of the data set.
        weights: of the learned metric; None takes the shipped ones.
        journal: file of finished shards.
        workers: processes; 0 takes every core.
        touch_counts: the data set's, in turn; else touches that were felt stand for tried ones.
        title: of the progress bar.

    Raises:
        BadInput: data set or weights are missing or damaged.
    """
    load_metric(weights)  # Refuses bad weights before the work starts.
    tasks = {path.name: (str(path), weights) for path in shard_paths(folder)}
    data = (shipped_weights() if weights is None else weights).read_bytes()
    settings = {"weights": hashlib.sha256(data).hexdigest()}
    shards = run_tasks(
        _judge_shard, tasks, settings=settings, journal=journal, workers=workers, title=title
    )
    return [judged(row, touch_counts) for shard in shards for row in shard]


def judge_scene(scene: LabelledScene, weights: Path | None) -> dict[str, Any]:
    """All metrics on one scene, as JSON holds it."""
    metric, hand = _metric(weights), hand_model("")
    known = scene_knowledge(scene)
    scores = {
        "learned": metric.predict(scene.candidates, known.fields, known.hints).success,
        "blind": metric.predict(scene.candidates, known.fields).success,
        "rate": scene.estimate_rate,
        "epsilon": nominal_epsilon(scene.candidates, known.estimate, hand, LabelSettings()),
        "nominal": scene.nominal.astype(float),
    }
    return {
        "object": scene.object,
        "scene": scene.scene,
        "contacts": len(scene.contacts),
        "label": np.round(scene.label_rate, _DIGITS).tolist(),
        "scores": {name: np.round(values, _DIGITS).tolist() for name, values in scores.items()},
    }


def judged(row: dict[str, Any], touch_counts: Sequence[int]) -> Judged:
    """What `judge_scene` told, with the touches that were tried."""
    rounds = len(touch_counts)
    tried = touch_counts[row["scene"] % rounds] if rounds else row["contacts"]
    return Judged(
        row["object"],
        row["scene"],
        row["contacts"],
        tried,
        np.array(row["label"]) > SUCCESS_RATE,
        {name: np.array(values) for name, values in row["scores"].items()},
    )


def summarize(scenes: Sequence[Judged], seed: int = 0) -> dict[str, Any]:
    """The metrics of figure 4.7; `..._interval` holds 95 % of a bootstrap over objects."""
    summary = _summary(scenes)
    facts = [_facts(own) for own in by(scenes, lambda scene: scene.object).values()]
    summary["gain_over_rate_at_equal_share"] = _rounded(_over_objects(facts)["gain"])
    drawn = np.random.default_rng([seed, 23]).integers(len(facts), size=(_DRAWS, len(facts)))
    draws = [_over_objects([facts[i] for i in own]) for own in drawn]
    for fact, name in _INTERVALS.items():
        values = [value for draw in draws if (value := draw[fact]) is not None]
        ends = np.percentile(values, _ENDS).tolist() if values else []
        summary[f"{name}_interval"] = [_rounded(end) for end in ends]
    return summary


_INTERVALS = {
    "learned": "learned_precision",
    "nominal": "nominal_precision",
    "error": "calibration_error",
    "top1": "top1_success",
    "gain": "gain_over_rate_at_equal_share",
}


def _facts(scenes: Sequence[Judged]) -> dict[str, Any]:
    """What the bootstrap needs to know of one object's scenes."""
    every = pooled(scenes)
    share = float(every.selected("learned").mean())
    learned, rate = (precision_at(every, name, share) for name in ("learned", "rate"))
    return {
        "learned": _precision(every, "learned"),
        "nominal": _precision(every, "nominal"),
        "gain": None if learned is None or rate is None else learned - rate,
        "top1": [top1([scene], "learned") for scene in scenes],
        "bins": reliability_sums(every.scores["learned"], every.success),
    }


def _over_objects(facts: Sequence[dict[str, Any]]) -> dict[str, float | None]:
    """Means over objects, over scenes, and the calibration of all candidates."""
    result = {
        name: _mean([fact[name] for fact in facts]) for name in ("learned", "nominal", "gain")
    }
    result["top1"] = _mean([value for fact in facts for value in fact["top1"]])
    predicted, observed, count = np.sum([fact["bins"] for fact in facts], axis=0)
    result["error"] = float(np.abs(predicted - observed).sum() / max(count.sum(), 1))
    return result


def _mean(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.mean(known)) if known else None


def _summary(scenes: Sequence[Judged]) -> dict[str, Any]:
    every = pooled(scenes)
    precision = {name: mean_precision(scenes, name) for name in METRICS}
    share = float(np.mean(every.selected("learned")))
    graspable = [scene for scene in scenes if scene.graspable]
    selecting = [s.selected("learned").mean() >= LEAST_SHARE for s in graspable]
    failures = {name: None if p is None else 1 - p for name, p in precision.items()}
    learned, nominal = failures["learned"], failures["nominal"]
    at_share = {name: precision_at(every, name, share) for name in METRICS}
    return {
        "learned_precision": _rounded(precision["learned"]),
        "nominal_precision": _rounded(precision["nominal"]),
        "epsilon_precision": _rounded(at_share["epsilon"]),
        "rate_precision": _rounded(precision["rate"]),
        "blind_precision": _rounded(precision["blind"]),
        "failure_ratio": None if not learned or nominal is None else _rounded(nominal / learned),
        "top1_success": _rounded(top1(scenes, "learned")),
        "top1_success_graspable": _rounded(top1(graspable, "learned")),
        "scenes_selecting_share": _rounded(float(np.mean(selecting)) if selecting else None),
        "calibration_error": _rounded(reliability(every.scores["learned"], every.success).error),
        "learned_share": _rounded(share),
        "rate_share": _rounded(float(np.mean(every.selected("rate")))),
        "learned_precision_pooled": _rounded(_precision(every, "learned")),
        "nominal_precision_pooled": _rounded(_precision(every, "nominal")),
        "learned_precision_at_equal_share": _rounded(at_share["learned"]),
        "rate_precision_at_equal_share": _rounded(at_share["rate"]),
        "blind_precision_at_equal_share": _rounded(at_share["blind"]),
        "nominal_precision_at_equal_share": _rounded(at_share["nominal"]),
        **{f"{name}_auc": _rounded(auc(every.scores[name], every.success)) for name in METRICS},
        **{
            f"{name}_top1_success": _rounded(top1(scenes, name))
            for name in ("blind", "rate", "epsilon", "nominal")
        },
        # What top-1 success can be at most: the other scenes offer no grasp that succeeds.
        "top1_possible": _rounded(_mean([bool(s.success.any()) for s in scenes])),
        "candidates_succeeding_share": _rounded(float(every.success.mean())),
    }


def pooled(scenes: Sequence[Judged]) -> Judged:
    """All candidates of several scenes as if of one."""
    return Judged(
        "all",
        -1,
        -1,
        -1,
        np.concatenate([scene.success for scene in scenes]),
        {name: np.concatenate([s.scores[name] for s in scenes]) for name in METRICS},
    )


def mean_precision(scenes: Sequence[Judged], name: str) -> float | None:
    """Mean over objects of the share of selected candidates that succeed (eq. 4.1).

    Objects of which a metric selects nothing do not count; None where none counts.
    """
    objects = by(scenes, lambda scene: scene.object).values()
    return _mean([_precision(pooled(own), name) for own in objects])


def precision_at(scene: Judged, name: str, share: float) -> float | None:
    """Precision of the best rated share of candidates; ties count by their mean."""
    count = round(share * len(scene.success))
    if count == 0:
        return None
    scores = scene.scores[name]
    least = np.sort(scores)[-count]
    above, tied = scores > least, scores == least
    taken = scene.success[above].sum() + (count - above.sum()) * scene.success[tied].mean()
    return float(taken / count)


def top1(scenes: Sequence[Judged], name: str) -> float | None:
    """Share of scenes whose best rated candidate succeeds; ties count by their mean."""
    best = [s.success[s.scores[name] == s.scores[name].max()].mean() for s in scenes]
    return float(np.mean(best)) if best else None


def by(scenes: Sequence[Judged], key: Callable[[Judged], Any]) -> dict[Any, list[Judged]]:
    """Scenes in groups, sorted by key."""
    groups: dict[Any, list[Judged]] = {}
    for scene in scenes:
        groups.setdefault(key(scene), []).append(scene)
    return dict(sorted(groups.items()))


def group_rows(scenes: Sequence[Judged], kind: str, key: Callable[[Judged], Any]) -> list[Any]:
    """A row of figures for each group."""
    rows = []
    for name, own in by(scenes, key).items():
        every = pooled(own)
        row = {kind: name, "scenes": len(own), "candidates": len(every.success)}
        row["succeeding"] = _rounded(float(every.success.mean()))
        for metric in METRICS:
            row[f"{metric}_precision"] = _rounded(_precision(every, metric))
            row[f"{metric}_selected"] = _rounded(float(every.selected(metric).mean()))
        row["top1_success"] = _rounded(top1(own, "learned"))
        rows.append(row)
    return rows


def _precision(scene: Judged, name: str) -> float | None:
    chosen = scene.selected(name)
    return float(scene.success[chosen].mean()) if chosen.any() else None


@lru_cache(maxsize=1)
def _metric(weights: Path | None) -> GraspMetric:
    return load_metric(weights)


def _judge_shard(task: tuple[str, Path | None]) -> list[dict[str, Any]]:
    path, weights = task
    return [judge_scene(s, weights) for s in read_shard(Path(path)) if len(s.candidates)]


def _rounded(value: float | None) -> float | None:
    return None if value is None or not np.isfinite(value) else round(value, _DIGITS)
