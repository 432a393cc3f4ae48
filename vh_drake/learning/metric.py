"""The trained metric: weights and their card in, success probabilities of candidates out."""

import dataclasses as dc
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from vh_drake.errors import BadInput
from vh_drake.geometry.model_files import models_folder
from vh_drake.learning.calibration import Calibration
from vh_drake.learning.features import (
    CHANNELS,
    NUMBERS,
    VOXELS,
    Float32,
    SceneFields,
    pose_inputs,
    sample_grids,
)
from vh_drake.learning.hints import Hints
from vh_drake.learning.network import RATE, SEEN, SUCCESS, GraspNetwork
from vh_drake.learning.weights import load_weights, save_weights
from vh_drake.types import Array, Candidates

SHIPPED = "grasp_metric.safetensors"
_CHUNK = 128  # candidates whose grids are in memory at once


@dc.dataclass(frozen=True, eq=False)
class Prediction:
    """Of n candidates."""

    success: Array  # (n,) calibrated probability that the force-closure rate is over 0.8
    rate: Array  # (n,) expected force-closure rate
    spread: Array  # (n,) standard deviation of `success` under dropout; 0 if not asked for
    seen: Float32  # (n, SEEN) output of the convolutions


@dc.dataclass(frozen=True, eq=False)
class GraspMetric:
    """A network ready for use.

    Attributes:
        network: in evaluation mode.
        calibration: of its logits where hints are given.
        blind_calibration: of its logits without hints.
        card: what is known of the weights.
    """

    network: GraspNetwork
    calibration: Calibration
    blind_calibration: Calibration
    card: dict[str, Any]

    def predict(
        self,
        candidates: Candidates,
        fields: SceneFields,
        hints: Hints | None = None,
        *,
        passes: int = 0,
        seed: int = 0,
    ) -> Prediction:
        """Rate candidates of one scene.

        Args:
            candidates: n grasps.
            fields: of the scene, see `features.scene_fields`.
            hints: what closing on the estimate tells; None rates without.
            passes: how often dropout is drawn for `spread`; the convolutions run once.
            seed: of these draws.
        """
        numbers = torch.from_numpy(pose_inputs(fields, candidates, hints))
        drawn = torch.Generator().manual_seed(seed)
        rows, seen = [np.zeros((0, 3))], [np.zeros((0, SEEN), np.float32)]
        for first in range(0, len(candidates), _CHUNK):
            own = slice(first, first + _CHUNK)
            with torch.inference_mode():
                output = self.network.seen(sample_grids(fields, candidates.X_WH[own]))
            seen.append(output.numpy())
            rows.append(self._rows(output, numbers[own], hints is not None, passes, drawn))
        success, rate, spread = np.concatenate(rows).T
        return Prediction(success, rate, spread, np.concatenate(seen))

    def _rows(
        self,
        seen: torch.Tensor,
        numbers: torch.Tensor,
        hinted: bool,
        passes: int,
        drawn: torch.Generator,
    ) -> Array:
        """Success, rate and spread (n, 3) of a chunk."""
        calibration = self.calibration if hinted else self.blind_calibration
        with torch.inference_mode():
            logits = self.network.decide(seen, numbers).numpy().astype(float)
            tries = [
                calibration.probability(
                    self.network.decide_dropping(seen, numbers, drawn)[:, SUCCESS].numpy()
                )
                for _ in range(passes)
            ]
        success = calibration.probability(logits[:, SUCCESS])
        rate = Calibration().probability(logits[:, RATE])
        spread = np.std(tries, axis=0) if passes else np.zeros(len(success))
        return np.column_stack([success, rate, spread])


def shipped_weights() -> Path:
    """Where the weights lie that come with the package."""
    return models_folder() / "weights" / SHIPPED


def save_metric(path: str | Path, metric: GraspMetric) -> None:
    """Write weights and card.

    Raises:
        BadInput: see `weights.save_weights`.
        VhDrakeError: the files can't be written.
    """
    arrays = {name: value.numpy() for name, value in metric.network.state_dict().items()}
    card = {
        **metric.card,
        "calibration": dc.asdict(metric.calibration),
        "blind_calibration": dc.asdict(metric.blind_calibration),
        "golden": np.round(golden_outputs(metric), 6).tolist(),
    }
    save_weights(path, arrays, card)


def golden_outputs(metric: GraspMetric) -> Array:
    """Success of eight inputs drawn from a fixed seed; the card keeps it, a test compares."""
    rng = np.random.default_rng(0)
    grids = torch.from_numpy(rng.random((8, CHANNELS, *[VOXELS] * 3)).astype(np.float32))
    numbers = torch.from_numpy(rng.normal(size=(8, NUMBERS)).astype(np.float32))
    with torch.inference_mode():
        logits = metric.network(grids, numbers)[:, SUCCESS].numpy()
    return metric.calibration.probability(logits.astype(float))


def load_metric(path: str | Path | None = None) -> GraspMetric:
    """Read weights that match their card and this network; None takes the shipped ones.

    Raises:
        BadInput: a file is missing, damaged, or of another network; never random weights.
    """
    path = shipped_weights() if path is None else Path(path)
    arrays, card = load_weights(path)
    network = GraspNetwork()
    wanted = {name: tuple(value.shape) for name, value in network.state_dict().items()}
    found = {name: array.shape for name, array in arrays.items()}
    if wanted != found:
        odd = sorted(set(wanted.items()) ^ set(found.items()))[0]
        raise BadInput(
            f"{path}: these are weights of another network (at {odd[0][:80]!r}); train anew with "
            "`vh-drake train`, or leave --weights out for the shipped ones"
        )
    network.load_state_dict(_tensors(arrays))
    network.eval()
    return GraspMetric(
        network,
        read_calibration(path, card, "calibration"),
        read_calibration(path, card, "blind_calibration"),
        card,
    )


def _tensors(arrays: dict[str, NDArray[Any]]) -> dict[str, torch.Tensor]:
    return {name: torch.from_numpy(np.array(array)) for name, array in arrays.items()}


def read_calibration(path: Path, card: dict[str, Any], name: str) -> Calibration:
    """From a card's entry of a name.

    Raises:
        BadInput: it is missing or unusable.
    """
    try:
        content = card[name]
        calibration = Calibration(float(content["slope"]), float(content["offset"]))
    except (TypeError, KeyError, ValueError) as error:
        raise BadInput(f"{path}: its card has no valid {name!r}; train anew") from error
    if not (np.isfinite([calibration.slope, calibration.offset]).all() and calibration.slope > 0):
        raise BadInput(f"{path}: its card has an unusable {name!r}; train anew")
    return calibration
