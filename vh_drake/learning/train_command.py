"""`vh-drake train`: from data sets to weights with a card, curves and a calibration picture."""

import dataclasses as dc
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vh_drake.atomic_files import write_bytes
from vh_drake.errors import BadInput
from vh_drake.geometry.meshes import Mask
from vh_drake.learning.calibration import (
    Calibration,
    Reliability,
    auc,
    fit_calibration,
    reliability,
)
from vh_drake.learning.generating import hand_model
from vh_drake.learning.metric import GraspMetric, save_metric
from vh_drake.learning.network import SUCCESS
from vh_drake.learning.pictures import training_picture
from vh_drake.learning.samples import SceneSamples, load_samples
from vh_drake.learning.training import Round, Trained, TrainingSettings, predict, train

WEIGHTS = "grasp_metric.safetensors"
_PICTURE = "curves.png"
_DIGITS = 4


@dc.dataclass(frozen=True, eq=False)
class HeldOut:
    """What the network says of held-out objects."""

    success: Mask  # (n,)
    calibration: Calibration
    blind_calibration: Calibration
    figures: dict[str, float]
    diagram: Reliability


def train_metric(
    datasets: Sequence[Path],
    out: Path,
    settings: TrainingSettings | None = None,
    *,
    workers: int = 1,
    tell: Callable[[Round], None] = lambda _: None,
) -> GraspMetric:
    """Train on data sets and write the result.

    Args:
        datasets: folders of `vh-drake dataset generate`.
        out: folder for grasp_metric.safetensors and .json, curves.csv, curves.png and the
            checkpoint from which a killed run goes on.
        settings: of the training.
        workers: processes that prepare the fields of scenes.
        tell: is told every round.

    Raises:
        BadInput: no data, too few objects, unusable settings, or another run's checkpoint.
        VhDrakeError: the folder can't be written.
    """
    if not datasets:
        raise BadInput("no data set; make one with `vh-drake dataset generate`")
    settings = settings or TrainingSettings()
    scenes = [
        scene
        for folder in datasets
        for scene in load_samples(folder, workers=workers, title="fields")
    ]
    trained = train(scenes, out, settings, tell)
    held = judge_held_out(trained, scenes)
    metric = GraspMetric(
        trained.network,
        held.calibration,
        held.blind_calibration,
        card(trained, scenes, settings, held),
    )
    save_metric(out / WEIGHTS, metric)
    write_bytes(out / _PICTURE, training_picture(trained.rounds, held.diagram))
    return metric


def judge_held_out(trained: Trained, scenes: Sequence[SceneSamples]) -> HeldOut:
    """Calibrate on objects that were held out, and tell how well it rates them.

    The error of calibration is that of one half of the objects after a fit to the other half.
    """
    own = [scene for scene in scenes if scene.object in trained.held_out]
    soft = np.concatenate([scene.success for scene in own])
    success = soft > 0.5
    logits = predict(trained.network, own)[:, SUCCESS]
    blind = predict(trained.network, own, blind=True)[:, SUCCESS]
    rate = np.concatenate([scene.estimate_rate for scene in own])
    half = np.isin(_objects(own), trained.held_out[::2])
    crossed = np.empty(len(soft))
    for part in (half, ~half):
        fitted = fit_calibration(logits[~part], soft[~part]) if (~part).any() else Calibration()
        crossed[part] = fitted.probability(logits[part])
    diagram = reliability(crossed, soft)
    figures = {
        "auc": auc(logits, success),
        "blind_auc": auc(blind, success),
        "estimate_rate_auc": auc(rate, success),
        "calibration_error": diagram.error,
    }
    return HeldOut(
        success,
        fit_calibration(logits, soft),
        fit_calibration(blind, soft),
        {name: round(value, _DIGITS) for name, value in figures.items()},
        diagram,
    )


def card(
    trained: Trained,
    scenes: Sequence[SceneSamples],
    settings: TrainingSettings,
    held: HeldOut,
) -> dict[str, Any]:
    """What people should know of the weights; the hash is added when they are written."""
    learnt = set(trained.learnt)
    return {
        "what": "success of a grasp from points, touches and estimate (thesis, section 4.3)",
        "hand": hand_model("").description.name,
        "samples": sum(map(len, scenes)),
        "scenes": len(scenes),
        "samples_learnt": sum(len(scene) for scene in scenes if scene.object in learnt),
        "objects_learnt": list(trained.learnt),
        "objects_held_out": list(trained.held_out),
        "settings": dc.asdict(settings),
        "rounds": [dc.asdict(r) for r in trained.rounds],
        "held_out": held.figures,
    }


def _objects(scenes: Sequence[SceneSamples]) -> list[str]:
    return [scene.object for scene in scenes for _ in range(len(scene))]
