"""How probable it is that the hand lifts the object by a grasp, from few numbers.

Simulated lifts are dear, so the model is small: several networks of one hidden layer that
start from other random weights, of which the mean counts. They weigh what the metric, the
closing on the estimate and the geometry say of a grasp (`lift_inputs`).
"""

import dataclasses as dc
from pathlib import Path
from typing import Any

import numpy as np

from vh_drake.errors import BadInput
from vh_drake.geometry.model_files import models_folder
from vh_drake.learning.calibration import Calibration
from vh_drake.learning.lift_inputs import INPUTS
from vh_drake.learning.weights import load_weights, save_weights
from vh_drake.types import Array

SHIPPED = "lift_model.safetensors"
_FAR = 4.0  # standard deviations; inputs farther out are all alike


@dc.dataclass(frozen=True, eq=False)
class LiftModel:
    """k networks with h hidden units on standardized inputs."""

    mean: Array  # (INPUTS,) of the inputs
    scale: Array  # (INPUTS,) their standard deviations
    hidden: Array  # (k, INPUTS, h)
    hidden_offset: Array  # (k, h)
    out: Array  # (k, h)
    out_offset: Array  # (k,)
    calibration: Calibration
    card: dict[str, Any]  # what is known of the model

    def logits(self, inputs: Array) -> Array:
        """What each network says (k, n) of inputs (n, INPUTS)."""
        x = standardized(inputs, self.mean, self.scale)
        h = np.tanh(x @ self.hidden + self.hidden_offset[:, None])
        logits: Array = np.einsum("knh,kh->kn", h, self.out) + self.out_offset[:, None]
        return logits

    def probability(self, inputs: Array) -> Array:
        """Calibrated probability (n,) of a lift, of inputs (n, INPUTS)."""
        return self.calibration.probability(self.logits(inputs).mean(axis=0))

    def spread(self, inputs: Array) -> Array:
        """Standard deviation (n,) of the networks' probabilities: how little they agree."""
        spread: Array = np.std(self.calibration.probability(self.logits(inputs)), axis=0)
        return spread


def standardized(inputs: Array, mean: Array, scale: Array) -> Array:
    """Inputs (n, INPUTS) in standard deviations from their means, bounded."""
    return np.clip((inputs - mean) / scale, -_FAR, _FAR)


def shipped_lift_model() -> Path:
    """Where the model lies that comes with the package."""
    return models_folder() / "weights" / SHIPPED


def save_lift_model(path: str | Path, model: LiftModel) -> None:
    """Write the networks and their card.

    Raises:
        BadInput: see `weights.save_weights`.
        VhDrakeError: the files can't be written.
    """
    card = {**model.card, "calibration": dc.asdict(model.calibration)}
    save_weights(path, {name: getattr(model, name) for name in _ARRAYS}, card)


_ARRAYS = ("mean", "scale", "hidden", "hidden_offset", "out", "out_offset")


def load_lift_model(path: str | Path | None = None) -> LiftModel:
    """Read networks that match their card and these inputs; None takes the shipped ones.

    Raises:
        BadInput: a file is missing, damaged, or of other inputs.
    """
    path = shipped_lift_model() if path is None else Path(path)
    arrays, card = load_weights(path)
    try:
        parts = {name: np.asarray(arrays[name], float) for name in _ARRAYS}
        k, inputs, h = parts["hidden"].shape
        calibration = Calibration(**card["calibration"])
        shapes = [(inputs,), (inputs,), (k, inputs, h), (k, h), (k, h), (k,)]
    except (KeyError, ValueError, TypeError) as error:
        raise BadInput(f"{path}: this is no lift model; {_REMEDY}") from error
    if inputs != INPUTS or [parts[name].shape for name in _ARRAYS] != shapes:
        raise BadInput(f"{path}: a lift model of other inputs than {INPUTS}; {_REMEDY}")
    return LiftModel(**parts, calibration=calibration, card=card)


_REMEDY = "train anew with `vh-drake train-lifts`, or take the shipped one"
