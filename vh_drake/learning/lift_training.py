"""Fits the lift model to grasps that were carried out, and tells how well it foretells others."""

import dataclasses as dc
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from sklearn.ensemble import ExtraTreesClassifier

from vh_drake.batch import run_tasks
from vh_drake.errors import BadInput
from vh_drake.geometry.meshes import Mask
from vh_drake.learning.calibration import auc, fit_calibration, reliability
from vh_drake.learning.dataset import shard_paths
from vh_drake.learning.generating import hand_model
from vh_drake.learning.knowledge import scene_knowledge
from vh_drake.learning.lift_inputs import lift_inputs
from vh_drake.learning.lift_model import LiftModel, Trees, log_odds, save_lift_model
from vh_drake.learning.lift_records import Lifted, read_lifts
from vh_drake.learning.metric import GraspMetric, load_metric
from vh_drake.learning.shards import LabelledScene, read_shard
from vh_drake.types import Array, IntArray

WEIGHTS = "lift_model.safetensors"
_DIGITS = 4


@dc.dataclass(frozen=True)
class LiftTrainingSettings:
    """How the trees are grown."""

    trees: int = 100
    leaf: int = 5  # grasps at least
    inputs_share: float = 0.4  # of the inputs, among which a node chooses
    folds: int = 8  # of the objects, to tell how well unknown ones are judged
    seed: int = 0


@dc.dataclass(frozen=True, eq=False)
class LiftSamples:
    """n grasps that were carried out."""

    objects: tuple[str, ...]  # (n,)
    inputs: Array  # (n, INPUTS)
    lifted: Mask  # (n,)


def train_lift_model(
    datasets: Sequence[Path],
    out: Path,
    *,
    weights: Path | None = None,
    settings: LiftTrainingSettings | None = None,
    workers: int = 0,
    title: str = "",
) -> LiftModel:
    """Fit a model to data sets whose grasps were carried out, and write it.

    Args:
        datasets: folders, made by `vh-drake dataset lift`.
        out: folder for lift_model.safetensors and .json.
        weights: of the metric, whose word is an input; None takes the shipped ones.
        settings: of the fit.
        workers: processes; 0 takes every core.
        title: of the progress bar.

    Raises:
        BadInput: no grasp was carried out, or of too few objects; unusable weights.
        VhDrakeError: the folder can't be written.
    """
    settings = settings or LiftTrainingSettings()
    samples = lift_samples(datasets, weights, workers=workers, title=title)
    model = fitted(samples, settings)
    save_lift_model(out / WEIGHTS, model)
    return model


def fitted(samples: LiftSamples, settings: LiftTrainingSettings) -> LiftModel:
    """A model of all samples, calibrated on objects that it had not seen.

    Raises:
        BadInput: fewer objects than folds, or all grasps came out alike.
    """
    if samples.lifted.all() or not samples.lifted.any():
        raise BadInput("all grasps came out alike; carry out more with `vh-drake dataset lift`")
    odds = np.zeros(len(samples.lifted))
    for unknown in folds(samples.objects, settings.folds, settings.seed):
        trees = grown(samples.inputs[~unknown], samples.lifted[~unknown], settings)
        odds[unknown] = log_odds(trees.shares(samples.inputs[unknown]))
    calibration = fit_calibration(odds, samples.lifted)
    told = calibration.probability(odds)
    card = {
        "what": "lift of the object by the hand (of the metric's word, closing and geometry)",
        "hand": hand_model("").description.name,
        "lifts": len(samples.lifted),
        "lifted_share": round(float(samples.lifted.mean()), _DIGITS),
        "objects": sorted(set(samples.objects)),
        "settings": dc.asdict(settings),
        "unknown_objects": {
            "auc": round(auc(odds, samples.lifted), _DIGITS),
            "calibration_error": round(reliability(told, samples.lifted).error, _DIGITS),
        },
    }
    return LiftModel(grown(samples.inputs, samples.lifted, settings), calibration, card)


def folds(objects: Sequence[str], count: int, seed: int) -> list[Mask]:
    """Which samples (n,) belong to each part of the objects.

    Raises:
        BadInput: fewer objects than parts.
    """
    names = np.unique(np.array(objects))
    if len(names) < count:
        raise BadInput(f"grasps of {len(names)} objects; {count} are needed at least")
    part = np.random.default_rng([seed, 31]).permutation(len(names)) % count
    of = dict(zip(names.tolist(), part.tolist(), strict=True))
    own = np.array([of[name] for name in objects])
    return [own == k for k in range(count)]


def lift_samples(
    datasets: Sequence[Path], weights: Path | None, *, workers: int = 0, title: str = ""
) -> LiftSamples:
    """All grasps of data sets that were carried out, with what the robot knew of them.

    Raises:
        BadInput: no grasp was carried out; a damaged file; unusable weights.
    """
    load_metric(weights)  # Refuses bad weights before the work starts.
    lifts = {folder: read_lifts(folder) for folder in datasets}
    tasks = {
        f"{folder} {path.stem}": (path, weights, lifts[folder])
        for folder in datasets
        for path in shard_paths(folder)
    }
    found = run_tasks(_shard_rows, tasks, settings={}, workers=workers, title=title)
    rows = [row for shard in found for row in shard]
    if not rows:
        raise BadInput("no grasp was carried out; do so with `vh-drake dataset lift`")
    names, inputs, lifted = zip(*rows, strict=True)
    return LiftSamples(tuple(names), np.array(inputs, float), np.array(lifted, bool))


def _shard_rows(
    task: tuple[Path, Path | None, dict[int, Lifted]],
) -> list[tuple[str, list[float], bool]]:
    path, weights, lifts = task
    rows = []
    for scene in read_shard(path):
        if scene.scene in lifts and len(scene.candidates):
            done = lifts[scene.scene]
            inputs = scene_inputs(scene, np.array(done.grasps, np.int64), weights)
            own = zip(inputs.tolist(), done.lifted, strict=True)
            rows += [(scene.object, row, lifted) for row, lifted in own]
    return rows


def scene_inputs(scene: LabelledScene, grasps: IntArray, weights: Path | None) -> Array:
    """What the robot knew (n, INPUTS) of some of a scene's candidates."""
    known = scene_knowledge(scene, scene.candidates.taken(grasps))
    told = _metric(weights).predict(known.candidates, known.fields, known.hints)
    return lift_inputs(known, hand_model(""), told)


@lru_cache(maxsize=1)
def _metric(weights: Path | None) -> GraspMetric:
    return load_metric(weights)


def grown(inputs: Array, lifted: Mask, settings: LiftTrainingSettings) -> Trees:
    """Trees of inputs (n, INPUTS) and outcomes (n,)."""
    forest = ExtraTreesClassifier(
        settings.trees,
        min_samples_leaf=settings.leaf,
        max_features=settings.inputs_share,
        random_state=settings.seed,
    ).fit(inputs.astype(np.float32), lifted)
    own = [estimator.tree_ for estimator in forest.estimators_]
    root = np.cumsum([0, *(tree.node_count for tree in own[:-1])])
    return Trees(
        root=root,
        feature=np.concatenate([np.maximum(tree.feature, 0) for tree in own]),
        threshold=np.concatenate([tree.threshold for tree in own]),
        left=_linked([tree.children_left for tree in own], root),
        right=_linked([tree.children_right for tree in own], root),
        share=np.concatenate([tree.value[:, 0, 1] for tree in own]),
        depth=max(tree.max_depth for tree in own),
    )


def _linked(children: list[IntArray], root: IntArray) -> IntArray:
    """Children by their place among the nodes of all trees; a leaf is its own."""
    linked = [
        first + np.where(own < 0, np.arange(len(own)), own)
        for own, first in zip(children, root, strict=True)
    ]
    return np.concatenate(linked)


def figures(model: LiftModel) -> dict[str, Any]:
    """What a person wants to know of a model that was just fitted."""
    return {
        "lifts": model.card["lifts"],
        "objects": len(model.card["objects"]),
        "lifted_share": model.card["lifted_share"],
        **model.card["unknown_objects"],
    }
