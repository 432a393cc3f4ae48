"""Fits the lift model to grasps that were carried out, and tells how well it foretells others."""

import dataclasses as dc
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch.nn.functional import binary_cross_entropy_with_logits

from vh_drake.batch import run_tasks
from vh_drake.errors import BadInput
from vh_drake.geometry.meshes import Mask
from vh_drake.gpis.surface import estimate_surface
from vh_drake.grasping.field import object_field
from vh_drake.learning.calibration import Calibration, auc, fit_calibration, reliability
from vh_drake.learning.dataset import shard_paths
from vh_drake.learning.features import fused_points, scene_fields
from vh_drake.learning.generating import hand_model
from vh_drake.learning.hints import hints_on_estimate
from vh_drake.learning.lift_inputs import INPUTS, lift_inputs
from vh_drake.learning.lift_model import LiftModel, save_lift_model, standardized
from vh_drake.learning.lifts import Lifted, read_lifts
from vh_drake.learning.metric import load_metric
from vh_drake.learning.shards import LabelledScene, read_shard
from vh_drake.types import Array, IntArray

WEIGHTS = "lift_model.safetensors"
_LEAST_SCALE = 1e-3  # of an input that hardly varies
_DIGITS = 4


@dc.dataclass(frozen=True)
class LiftTrainingSettings:
    """How the networks are fitted."""

    networks: int = 8
    hidden: int = 16
    steps: int = 400
    learning_rate: float = 0.01
    weight_decay: float = 0.1
    folds: int = 5  # of the objects, to tell how well unknown ones are judged
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
        datasets: folders, see `lifts.lift_grasps`.
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
    logits = np.zeros(len(samples.lifted))
    for unknown in folds(samples.objects, settings.folds, settings.seed):
        part = _fit(samples.inputs[~unknown], samples.lifted[~unknown], settings)
        logits[unknown] = part.logits(samples.inputs[unknown]).mean(axis=0)
    calibration = fit_calibration(logits, samples.lifted)
    told = calibration.probability(logits)
    card = {
        "what": "lift of the object by the hand (of the metric's word, closing and geometry)",
        "hand": hand_model("").description.name,
        "lifts": len(samples.lifted),
        "lifted_share": round(float(samples.lifted.mean()), _DIGITS),
        "objects": sorted(set(samples.objects)),
        "settings": dc.asdict(settings),
        "unknown_objects": {
            "auc": round(auc(logits, samples.lifted), _DIGITS),
            "calibration_error": round(reliability(told, samples.lifted).error, _DIGITS),
        },
    }
    model = _fit(samples.inputs, samples.lifted, settings)
    return dc.replace(model, calibration=calibration, card=card)


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
    hand, metric, own = hand_model(""), load_metric(weights), scene.candidates.taken(grasps)
    surface = estimate_surface(scene.view, scene.contacts)
    fields = scene_fields(scene.view, scene.contacts, surface)
    estimate = object_field(surface, scene.view.table)
    fused = fused_points(scene.view, scene.contacts)
    hints = hints_on_estimate(own, estimate, fused, hand, scene.scene)
    told = metric.predict(own, fields, hints)
    return lift_inputs(own, surface, estimate, hand, told, hints)


def _fit(inputs: Array, lifted: Mask, settings: LiftTrainingSettings) -> LiftModel:
    """All networks at once, each on samples drawn with replacement."""
    mean, scale = inputs.mean(axis=0), np.maximum(inputs.std(axis=0), _LEAST_SCALE)
    x = torch.from_numpy(standardized(inputs, mean, scale))
    y = torch.from_numpy(lifted.astype(float))
    parameters = _start(settings)
    optimizer = torch.optim.AdamW(
        parameters, lr=settings.learning_rate, weight_decay=settings.weight_decay
    )
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, settings.steps)
    drawn = np.random.default_rng([settings.seed, 37])
    counts = drawn.poisson(1.0, (settings.networks, len(lifted))).astype(float)
    weight = torch.from_numpy(counts)
    hidden, hidden_offset, out, out_offset = parameters
    for _ in range(settings.steps):
        h = torch.tanh(x @ hidden + hidden_offset[:, None])
        logits = torch.einsum("knh,kh->kn", h, out) + out_offset[:, None]
        cost = binary_cross_entropy_with_logits(logits, y.expand_as(logits), weight)
        optimizer.zero_grad(set_to_none=True)
        cost.backward()  # type: ignore[no-untyped-call]  # torch
        optimizer.step()
        schedule.step()
    w, b, v, c = (value.detach().numpy() for value in parameters)
    return LiftModel(mean, scale, w, b, v, c, Calibration(), {})


def _start(settings: LiftTrainingSettings) -> list[torch.Tensor]:
    """Random first weights: hidden, its offset, out, its offset."""
    rng = np.random.default_rng([settings.seed, 29])
    k, h = settings.networks, settings.hidden
    shapes: list[tuple[tuple[int, ...], float]] = [
        ((k, INPUTS, h), INPUTS**-0.5),
        ((k, h), 0.0),
        ((k, h), h**-0.5),
        ((k,), 0.0),
    ]
    return [
        torch.from_numpy(std * rng.normal(size=shape)).requires_grad_() for shape, std in shapes
    ]


def figures(model: LiftModel) -> dict[str, Any]:
    """What a person wants to know of a model that was just fitted."""
    return {
        "lifts": model.card["lifts"],
        "objects": len(model.card["objects"]),
        "lifted_share": model.card["lifted_share"],
        **model.card["unknown_objects"],
    }
