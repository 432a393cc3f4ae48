"""How probable it is that the hand lifts the object by a grasp.

A few judges give their mean. Each has learnt from other objects, so that their disagreement
tells how sure they are, and each can be asked about objects that it has never met, which is how
they were calibrated. A judge is a network, which sees the shape around the hand, and a forest,
which does not carry trends beyond what it has met: of hundreds of candidates the best rated is
taken, and a network alone rates those highest that are like nothing it knows.
"""

import dataclasses as dc
import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from vh_drake.errors import BadInput
from vh_drake.geometry.model_files import models_folder
from vh_drake.learning.calibration import Calibration
from vh_drake.learning.features import Float32
from vh_drake.learning.forest import Forest, read_forest
from vh_drake.learning.lift_inputs import LIFT_NUMBERS
from vh_drake.learning.lift_network import LiftNetwork
from vh_drake.learning.metric import GraspMetric, read_calibration
from vh_drake.learning.network import SEEN
from vh_drake.learning.weights import load_weights, save_weights
from vh_drake.types import Array

FILE = "lift_model.safetensors"
_MOST = 64  # judges


@dc.dataclass(frozen=True, eq=False)
class Judge:
    """A network and a forest that learnt from the same grasps."""

    network: LiftNetwork  # in evaluation mode
    forest: Forest

    def logits(self, hidden: torch.Tensor, numbers: Array) -> Array:
        """Their mean (n,), from the network's units and from numbers (n, LIFT_NUMBERS)."""
        with torch.inference_mode():
            told = self.network.decide(hidden, torch.from_numpy(numbers.astype(np.float32)))
        mean: Array = (told.numpy().astype(float) + self.forest.logits(numbers)) / 2
        return mean


@dc.dataclass(frozen=True, eq=False)
class LiftModel:
    """k judges, and what the mean of their logits means."""

    judges: tuple[Judge, ...]
    calibration: Calibration
    card: dict[str, Any]  # what is known of the model

    def hidden(self, seen: Float32) -> list[torch.Tensor]:
        """What each judge's network makes of the metric's convolutions (n, SEEN)."""
        with torch.inference_mode():
            return [judge.network.hidden(torch.from_numpy(seen)) for judge in self.judges]

    def rate(self, hidden: list[torch.Tensor], numbers: Array) -> tuple[Array, Array]:
        """Calibrated probability of a lift (n,), and the standard error of the judges' mean.

        Args:
            hidden: of the grasps, as `hidden` gives it.
            numbers: (n, LIFT_NUMBERS), see `lift_inputs`.
        """
        logits = np.array(
            [judge.logits(own, numbers) for judge, own in zip(self.judges, hidden, strict=True)]
        )
        told = self.calibration.probability(logits)
        error = told.std(axis=0) / np.sqrt(len(told))
        return self.calibration.probability(logits.mean(axis=0)), error


def fingerprint(metric: GraspMetric) -> str:
    """Of the convolutions, on whose output a lift model depends."""
    weights = [value.numpy().tobytes() for value in metric.network.grid.state_dict().values()]
    return hashlib.sha256(b"".join(weights)).hexdigest()


def check_metric(model: LiftModel, metric: GraspMetric) -> None:
    """Refuse a metric other than that which the model was fitted with.

    Raises:
        BadInput: it is another one; the message names the remedy.
    """
    if model.card.get("metric") != fingerprint(metric):
        raise BadInput(
            "the lift model belongs to other weights of the metric; fit one to these with "
            "`vh-drake train-lifts --weights`, or take the shipped weights"
        )


def lift_model_beside(weights: str | Path | None) -> Path:
    """Where the lift model of a metric lies: in the folder of its weights; None: the shipped."""
    folder = models_folder() / "weights" if weights is None else Path(weights).parent
    return folder / FILE


def save_lift_model(path: str | Path, model: LiftModel) -> None:
    """Write judges, their networks in half precision, and card.

    Raises:
        BadInput: see `weights.save_weights`.
        VhDrakeError: the files can't be written.
    """
    arrays: dict[str, NDArray[Any]] = {}
    for i, judge in enumerate(model.judges):
        weights = judge.network.state_dict()
        arrays |= {
            f"{i}/{name}": value.numpy().astype(np.float16) for name, value in weights.items()
        }
        arrays |= {f"{i}/forest/{name}": value for name, value in judge.forest.arrays().items()}
    more = {
        "judges": len(model.judges),
        "depths": [judge.forest.depth for judge in model.judges],
        "calibration": dc.asdict(model.calibration),
        "golden": np.round(golden_rates(model), 6).tolist(),
    }
    save_weights(path, arrays, {**model.card, **more})


def golden_rates(model: LiftModel) -> Array:
    """Probabilities (8,) of inputs drawn from a fixed seed; the card keeps them."""
    rng = np.random.default_rng(0)
    seen = rng.random((8, SEEN)).astype(np.float32)
    return model.rate(model.hidden(seen), rng.normal(size=(8, LIFT_NUMBERS)))[0]


def load_lift_model(path: str | Path | None = None) -> LiftModel:
    """Read a model that matches its card and this network; None takes the shipped one.

    Raises:
        BadInput: a file is missing, damaged, or of another network.
    """
    path = lift_model_beside(None) if path is None else Path(path)
    arrays, card = load_weights(path)
    count = card.get("judges")
    if type(count) is not int or not 0 < count <= _MOST:
        raise BadInput(f"{path}: this is no lift model; {_REMEDY}")
    try:
        judges = [_read_judge(arrays, card, i) for i in range(count)]
    except BadInput as error:
        raise BadInput(f"{path}: {error}; {_REMEDY}") from error
    return LiftModel(tuple(judges), read_calibration(path, card, "calibration"), card)


def _read_judge(arrays: Mapping[str, NDArray[Any]], card: dict[str, Any], i: int) -> Judge:
    start = f"{i}/forest/"
    forest = {k.removeprefix(start): v for k, v in arrays.items() if k.startswith(start)}
    network = LiftNetwork()
    wanted = {name: tuple(value.shape) for name, value in network.state_dict().items()}
    found = {name: arrays[f"{i}/{name}"] for name in wanted if f"{i}/{name}" in arrays}
    if wanted != {name: array.shape for name, array in found.items()}:
        raise BadInput("these are weights of another network")
    state = {name: torch.from_numpy(array.astype(np.float32)) for name, array in found.items()}
    network.load_state_dict(state)
    depths = card.get("depths")
    if not isinstance(depths, list) or len(depths) <= i:
        raise BadInput("its card does not tell how deep the trees are")
    return Judge(network.eval(), read_forest(forest, depths[i], LIFT_NUMBERS))


_REMEDY = "train anew with `vh-drake train-lifts`, or take the shipped one"
