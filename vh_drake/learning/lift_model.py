"""How probable it is that the hand lifts the object by a grasp, from few numbers.

Simulated lifts are dear, so the model is small: randomized trees (Geurts et al. 2006), whose
leaves hold shares of lifted grasps. They weigh what the metric, the closing on the estimate
and the geometry say of a grasp (`lift_inputs`).
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
from vh_drake.types import Array, IntArray

SHIPPED = "lift_model.safetensors"
_SURE = 1e-3  # mean shares nearer to 0 or 1 are all alike


@dc.dataclass(frozen=True, eq=False)
class Trees:
    """t binary trees with k nodes in all; a leaf is its own child."""

    root: IntArray  # (t,) node in which a tree starts
    feature: IntArray  # (k,) which input a node looks at
    threshold: Array  # (k,) at most this: to the left
    left: IntArray  # (k,)
    right: IntArray  # (k,)
    share: Array  # (k,) of the grasps in a node that lifted
    depth: int  # of the deepest leaf

    def shares(self, inputs: Array) -> Array:
        """The share of each tree's leaf (n, t) of inputs (n, INPUTS)."""
        x = np.asarray(inputs, np.float32)  # What trees are grown on
        node = np.tile(self.root, (len(x), 1))
        row = np.arange(len(x))[:, None]
        for _ in range(self.depth):
            smaller = x[row, self.feature[node]] <= self.threshold[node]
            node = np.where(smaller, self.left[node], self.right[node])
        shares: Array = self.share[node]
        return shares


@dc.dataclass(frozen=True, eq=False)
class LiftModel:
    """Trees, and what their mean means."""

    trees: Trees
    calibration: Calibration  # of the log odds of the trees' mean
    card: dict[str, Any]  # what is known of the model

    def rate(self, inputs: Array) -> tuple[Array, Array]:
        """Calibrated probability of a lift (n,), and the standard error of the trees' mean (n,).

        Args:
            inputs: (n, INPUTS), see `lift_inputs`.
        """
        shares = self.trees.shares(inputs)
        error = shares.std(axis=1) / np.sqrt(shares.shape[1])
        return self.calibration.probability(log_odds(shares)), error


def log_odds(shares: Array) -> Array:
    """Of the mean (n,) of shares (n, t)."""
    mean = np.clip(shares.mean(axis=1), _SURE, 1 - _SURE)
    odds: Array = np.log(mean / (1 - mean))
    return odds


def shipped_lift_model() -> Path:
    """Where the model lies that comes with the package."""
    return models_folder() / "weights" / SHIPPED


def save_lift_model(path: str | Path, model: LiftModel) -> None:
    """Write trees and card.

    Raises:
        BadInput: see `weights.save_weights`.
        VhDrakeError: the files can't be written.
    """
    arrays = {name: getattr(model.trees, name).astype(kind) for name, kind in _ARRAYS.items()}
    calibration = dc.asdict(model.calibration)
    golden = np.round(golden_rates(model), 6).tolist()
    more = {"calibration": calibration, "depth": model.trees.depth, "golden": golden}
    card = {**model.card, **more}
    save_weights(path, arrays, card)


def golden_rates(model: LiftModel) -> Array:
    """Probabilities (8,) of inputs drawn from a fixed seed; the card keeps them."""
    return model.rate(np.random.default_rng(0).normal(size=(8, INPUTS)))[0]


# How they are kept; thresholds are exact, as what lies on one is not to change sides.
_ARRAYS = {
    "root": np.int32,
    "feature": np.int32,
    "threshold": np.float64,
    "left": np.int32,
    "right": np.int32,
    "share": np.float32,
}
_LINKS = ("root", "feature", "left", "right")


def load_lift_model(path: str | Path | None = None) -> LiftModel:
    """Read a model that matches its card and these inputs; None takes the shipped one.

    Raises:
        BadInput: a file is missing, damaged, or of other inputs.
    """
    path = shipped_lift_model() if path is None else Path(path)
    arrays, card = load_weights(path)
    try:
        parts: dict[str, Any] = {
            name: arrays[name].astype(np.int64 if name in _LINKS else np.float64)
            for name in _ARRAYS
        }
        trees = Trees(**parts, depth=int(card["depth"]))
        calibration = Calibration(**card["calibration"])
    except (KeyError, ValueError, TypeError) as error:
        raise BadInput(f"{path}: this is no lift model; {_REMEDY}") from error
    if not _is_sound(trees):
        raise BadInput(f"{path}: its trees lead nowhere, or look at other inputs; {_REMEDY}")
    return LiftModel(trees, calibration, card)


def _is_sound(trees: Trees) -> bool:
    """Whether every index is within bounds."""
    nodes = trees.share.shape
    columns = (trees.feature, trees.threshold, trees.left, trees.right)
    if len(nodes) != 1 or any(column.shape != nodes for column in columns):
        return False
    links = np.concatenate([trees.root.ravel(), trees.left, trees.right])
    inside = (links >= 0) & (links < nodes[0])
    known = (trees.feature >= 0) & (trees.feature < INPUTS)
    return bool(inside.all() and known.all() and len(trees.root) and 0 < trees.depth < 1000)


_REMEDY = "train anew with `vh-drake train-lifts`, or take the shipped one"
