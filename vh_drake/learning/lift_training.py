"""Fits the lift model to grasps that were carried out, and tells how well it foretells others."""

import dataclasses as dc
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch.nn.functional import binary_cross_entropy_with_logits

from vh_drake.batch import run_tasks
from vh_drake.errors import BadInput
from vh_drake.geometry.meshes import Mask
from vh_drake.learning.calibration import auc, fit_calibration, reliability
from vh_drake.learning.dataset import shard_paths
from vh_drake.learning.features import Float32
from vh_drake.learning.forest import grow_forest
from vh_drake.learning.generating import hand_model
from vh_drake.learning.knowledge import scene_knowledge
from vh_drake.learning.lift_inputs import lift_inputs
from vh_drake.learning.lift_model import FILE, Judge, LiftModel, fingerprint, save_lift_model
from vh_drake.learning.lift_network import LiftNetwork
from vh_drake.learning.lift_records import Lifted, read_lifts
from vh_drake.learning.metric import GraspMetric, load_metric
from vh_drake.learning.shards import LabelledScene, read_shard
from vh_drake.learning.training import learning_rate_factor
from vh_drake.types import Array, IntArray

_DIGITS = 4


@dc.dataclass(frozen=True)
class LiftTrainingSettings:
    """How the judges learn."""

    judges: int = 4  # each learns without its part of the objects, and is tried on these
    trees: int = 15  # of each
    leaf: int = 5  # grasps at least
    numbers_share: float = 0.4  # of the numbers, among which a node chooses
    epochs: int = 16
    batch: int = 128
    learning_rate: float = 1e-3  # at most; it rises over the first tenth and falls to zero
    weight_decay: float = 1e-3
    seed: int = 0


@dc.dataclass(frozen=True, eq=False)
class LiftSamples:
    """n grasps that were carried out."""

    objects: tuple[str, ...]  # (n,)
    seen: NDArray[np.float16]  # (n, SEEN) output of the metric's convolutions
    numbers: Array  # (n, LIFT_NUMBERS)
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
        title: of the progress bars.

    Raises:
        BadInput: no grasp was carried out, or of too few objects; unusable weights.
        VhDrakeError: the folder can't be written.
    """
    metric = load_metric(weights)  # Refuses bad weights before the work starts.
    samples = lift_samples(datasets, weights, workers=workers, title=title)
    model = fitted(samples, metric, settings or LiftTrainingSettings(), title=title)
    save_lift_model(out / FILE, model)
    return model


def fitted(
    samples: LiftSamples, metric: GraspMetric, settings: LiftTrainingSettings, *, title: str = ""
) -> LiftModel:
    """Judges that each left out a part of the objects, calibrated on these parts.

    Raises:
        BadInput: fewer objects than judges, or all grasps came out alike.
    """
    if samples.lifted.all() or not samples.lifted.any():
        raise BadInput("all grasps came out alike; carry out more with `vh-drake dataset lift`")
    parts = folds(samples.objects, settings.judges, settings.seed)
    judges = run_tasks(
        lambda i: learnt(samples, ~parts[i], metric, settings, settings.seed + i),
        {f"judge {i}": i for i in range(settings.judges)},
        settings={},
        workers=1,
        title=title,
    )
    odds = np.zeros(len(samples.lifted))
    for unknown, judge in zip(parts, judges, strict=True):
        odds[unknown] = logits_of(judge, samples, unknown)
    calibration = fit_calibration(odds, samples.lifted)
    told = calibration.probability(odds)
    card = {
        "what": "lift of the object by the hand (of what the metric sees, closing and geometry)",
        "hand": hand_model("").description.name,
        "metric": fingerprint(metric),
        "lifts": len(samples.lifted),
        "lifted_share": round(float(samples.lifted.mean()), _DIGITS),
        "objects": sorted(set(samples.objects)),
        "settings": dc.asdict(settings),
        "unknown_objects": {
            "auc": round(auc(odds, samples.lifted), _DIGITS),
            "calibration_error": round(reliability(told, samples.lifted).error, _DIGITS),
        },
    }
    return LiftModel(tuple(judges), calibration, card)


def learnt(
    samples: LiftSamples,
    own: Mask,
    metric: GraspMetric,
    settings: LiftTrainingSettings,
    seed: int,
) -> Judge:
    """A judge that learns from some samples (n,)."""
    forest = grow_forest(
        samples.numbers[own],
        samples.lifted[own],
        trees=settings.trees,
        leaf=settings.leaf,
        numbers_share=settings.numbers_share,
        seed=seed,
    )
    return Judge(_trained(samples, own, metric, settings, seed), forest)


def _trained(
    samples: LiftSamples,
    chosen: Mask,
    metric: GraspMetric,
    settings: LiftTrainingSettings,
    seed: int,
) -> LiftNetwork:
    """A network that learns from some samples (n,), rounded as it will be kept."""
    torch.manual_seed(seed)
    numbers = torch.from_numpy(samples.numbers.astype(np.float32))
    lifted = torch.from_numpy(samples.lifted.astype(np.float32))
    own = torch.from_numpy(np.flatnonzero(chosen))
    network = LiftNetwork()
    network.begin(metric.network, numbers[own])
    optimizer = torch.optim.AdamW(network.parameters(), weight_decay=settings.weight_decay)
    steps = settings.epochs * -(-len(own) // settings.batch)
    step = 0
    for _ in range(settings.epochs):
        for batch in torch.split(own[torch.randperm(len(own))], settings.batch):
            for group in optimizer.param_groups:
                group["lr"] = settings.learning_rate * learning_rate_factor(step / steps)
            seen = torch.from_numpy(samples.seen[batch.numpy()]).float()
            value = binary_cross_entropy_with_logits(network(seen, numbers[batch]), lifted[batch])
            optimizer.zero_grad(set_to_none=True)
            value.backward()  # type: ignore[no-untyped-call]  # torch
            optimizer.step()
            step += 1
    rounded = {name: value.half().float() for name, value in network.state_dict().items()}
    network.load_state_dict(rounded)
    return network.eval()


def logits_of(judge: Judge, samples: LiftSamples, chosen: Mask) -> Array:
    """What a judge says of some samples (k,)."""
    with torch.inference_mode():
        hidden = judge.network.hidden(torch.from_numpy(samples.seen[chosen]).float())
    return judge.logits(hidden, samples.numbers[chosen])


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
    lifts = {folder: read_lifts(folder) for folder in datasets}
    tasks = {
        f"{folder} {path.stem}": (path, weights, lifts[folder])
        for folder in datasets
        for path in shard_paths(folder)
    }
    shards = run_tasks(_shard_samples, tasks, settings={}, workers=workers, title=title)
    scenes = [scene for shard in shards for scene in shard]
    if not scenes:
        raise BadInput("no grasp was carried out; do so with `vh-drake dataset lift`")
    names, seen, numbers, lifted = zip(*scenes, strict=True)
    return LiftSamples(
        tuple(name for name, own in zip(names, lifted, strict=True) for _ in own),
        np.concatenate(seen),
        np.concatenate(numbers),
        np.concatenate(lifted),
    )


def _shard_samples(
    task: tuple[Path, Path | None, dict[int, Lifted]],
) -> list[tuple[str, NDArray[np.float16], Array, Mask]]:
    path, weights, lifts = task
    found = []
    for scene in read_shard(path):
        if scene.scene in lifts and len(scene.candidates):
            done = lifts[scene.scene]
            seen, numbers = scene_inputs(scene, np.array(done.grasps, np.int64), weights)
            found.append((scene.object, seen.astype(np.float16), numbers, np.array(done.lifted)))
    return found


def scene_inputs(
    scene: LabelledScene, grasps: IntArray, weights: Path | None
) -> tuple[Float32, Array]:
    """Of some candidates of a scene: what the metric sees (n, SEEN), and numbers, n rows each."""
    known = scene_knowledge(scene, scene.candidates.taken(grasps))
    told = _metric(weights).predict(known.candidates, known.fields, known.hints)
    return told.seen, lift_inputs(known, hand_model(""), told)


@lru_cache(maxsize=1)
def _metric(weights: Path | None) -> GraspMetric:
    return load_metric(weights)


def figures(model: LiftModel) -> dict[str, Any]:
    """What a person wants to know of a model that was just fitted."""
    return {
        "lifts": model.card["lifts"],
        "objects": len(model.card["objects"]),
        "lifted_share": model.card["lifted_share"],
        **model.card["unknown_objects"],
    }
