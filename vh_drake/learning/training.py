"""Training the metric: resumable, deterministic, stopped early on objects that it never saw."""

import csv
import dataclasses as dc
import io
import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch.nn.functional import binary_cross_entropy_with_logits

from vh_drake.atomic_files import write_bytes
from vh_drake.errors import BadInput
from vh_drake.learning.calibration import auc
from vh_drake.learning.network import RATE, SUCCESS, GraspNetwork
from vh_drake.learning.samples import SceneSamples, batches, split_objects, without_hints
from vh_drake.learning.weights import load_weights, save_weights
from vh_drake.types import Array

_CHECKPOINT = "checkpoint.safetensors"
_CURVES = "curves.csv"
_RATE_WEIGHT = 0.5  # of the rate's loss beside that of success


@dc.dataclass(frozen=True)
class TrainingSettings:
    """How the network is trained."""

    epochs: int = 6  # at most
    rounds_per_epoch: int = 2  # after each the held-out objects are judged
    patience: int = 3  # rounds without improvement
    batch: int = 128
    learning_rate: float = 1e-3  # at most; it rises over the first tenth and falls to zero
    weight_decay: float = 1e-2
    blind: float = 0.3  # share of the samples that are shown without hints
    held_out: float = 0.15  # share of the objects for stopping and calibration
    seed: int = 0


@dc.dataclass(frozen=True)
class Round:
    """What was measured after a part of an epoch."""

    round: int
    epoch: float
    train_loss: float
    held_loss: float
    held_auc: float
    best: bool


@dc.dataclass
class _Run:
    """All that a training run remembers."""

    network: GraspNetwork
    optimizer: torch.optim.Optimizer
    rounds: list[Round]
    best: dict[str, torch.Tensor]

    @property
    def least(self) -> float:
        """The least loss so far."""
        return min((r.held_loss for r in self.rounds), default=float("inf"))

    def is_over(self, settings: TrainingSettings) -> bool:
        """Whether patience or epochs are used up."""
        done = len(self.rounds)
        last_best = max((r.round for r in self.rounds if r.best), default=done)
        spent = done - last_best >= settings.patience
        return spent or done >= settings.epochs * settings.rounds_per_epoch


@dc.dataclass(frozen=True, eq=False)
class Trained:
    """A trained network, and how it came about."""

    network: GraspNetwork  # with the weights of the best round
    rounds: tuple[Round, ...]
    learnt: tuple[str, ...]  # objects
    held_out: tuple[str, ...]


def train(
    scenes: Sequence[SceneSamples],
    out: Path,
    settings: TrainingSettings | None = None,
    tell: Callable[[Round], None] = lambda _: None,
) -> Trained:
    """Train, or go on where a killed run stopped.

    Args:
        scenes: of at least two objects.
        out: folder for checkpoint.safetensors and curves.csv.
        settings: of the training.
        tell: is told every round.

    Raises:
        BadInput: too few objects, unusable settings, or a checkpoint of other settings.
        VhDrakeError: the folder can't be written.
    """
    settings = settings or TrainingSettings()
    _check(settings)
    learnt, held = split_objects([s.object for s in scenes], settings.held_out, settings.seed)
    training = [scene for scene in scenes if scene.object in learnt]
    judging = [scene for scene in scenes if scene.object in held]
    run = _start(settings)
    _resume(run, out, settings)
    while not run.is_over(settings):
        round_ = _train_round(run, training, judging, settings)
        _save(run, out, settings)
        tell(round_)
    run.network.load_state_dict(run.best)
    run.network.eval()
    return Trained(run.network, tuple(run.rounds), tuple(sorted(learnt)), tuple(sorted(held)))


def predict(network: GraspNetwork, scenes: Sequence[SceneSamples], *, blind: bool = False) -> Array:
    """Logits (n, 2) of all candidates of some scenes, in their order, maybe without hints."""
    network.eval()
    parts = []
    with torch.inference_mode():
        for batch in batches(scenes, 512, None):
            numbers = without_hints(batch.numbers) if blind else batch.numbers
            parts.append(network(batch.grids, numbers))
    return np.concatenate([np.zeros((0, 2)), *(part.numpy() for part in parts)]).astype(float)


def loss(logits: torch.Tensor, targets: torch.Tensor) -> torch.Tensor:
    """Cross entropy of success, and with less weight of the rate; targets need not be 0 or 1."""
    success = binary_cross_entropy_with_logits(logits[:, SUCCESS], targets[:, SUCCESS])
    rate = binary_cross_entropy_with_logits(logits[:, RATE], targets[:, RATE])
    return success + _RATE_WEIGHT * rate


def curves_csv(rounds: Sequence[Round]) -> str:
    """The learning curves as CSV."""
    text = io.StringIO()
    writer = csv.DictWriter(text, [f.name for f in dc.fields(Round)], lineterminator="\n")
    writer.writeheader()
    writer.writerows(dc.asdict(r) for r in rounds)
    return text.getvalue()


def _check(settings: TrainingSettings) -> None:
    least = min(settings.epochs, settings.rounds_per_epoch, settings.patience, settings.batch)
    if least < 1 or not settings.learning_rate > 0 or not 0 < settings.held_out < 1:
        raise BadInput(
            "training settings: epochs, rounds, patience, batch and learning rate must be "
            "positive, held_out between 0 and 1"
        )


def _start(settings: TrainingSettings) -> _Run:
    torch.manual_seed(settings.seed)
    network = GraspNetwork()
    optimizer = torch.optim.AdamW(
        network.parameters(), lr=settings.learning_rate, weight_decay=settings.weight_decay
    )
    return _Run(network, optimizer, [], {})


def _train_round(
    run: _Run,
    training: Sequence[SceneSamples],
    judging: Sequence[SceneSamples],
    settings: TrainingSettings,
) -> Round:
    """One part of an epoch, then the verdict on the held-out objects."""
    done, parts = len(run.rounds), settings.rounds_per_epoch
    shuffled = np.random.default_rng([settings.seed, 11, done // parts]).permutation(len(training))
    own = [training[i] for i in np.array_split(shuffled, parts)[done % parts]]
    rng = np.random.default_rng([settings.seed, 13, done])
    torch.manual_seed(settings.seed * 1_000_003 + done)  # of dropout, alike after a resumption
    run.network.train()
    steps = -(-sum(map(len, own)) // settings.batch)
    total, count = 0.0, 0
    for step, batch in enumerate(batches(own, settings.batch, rng)):
        share = (done + step / steps) / (settings.epochs * parts)
        for group in run.optimizer.param_groups:
            group["lr"] = settings.learning_rate * learning_rate_factor(share)
        hidden = torch.rand(len(batch.numbers)) < settings.blind
        numbers = without_hints(batch.numbers, hidden)
        value = loss(run.network(batch.grids, numbers), batch.targets)
        run.optimizer.zero_grad(set_to_none=True)
        value.backward()  # type: ignore[no-untyped-call]  # torch
        run.optimizer.step()
        total, count = (
            total + float(value.detach()) * len(batch.targets),
            count + len(batch.targets),
        )
    logits = predict(run.network, judging)
    targets = np.concatenate([np.column_stack([s.success, s.rate]) for s in judging])
    held = float(loss(torch.from_numpy(logits), torch.from_numpy(targets)))
    best = held < run.least
    result = Round(
        done + 1,
        (done + 1) / parts,
        round(total / max(count, 1), 6),
        round(held, 6),
        round(auc(logits[:, SUCCESS], targets[:, SUCCESS] > 0.5), 5),
        best,
    )
    run.rounds.append(result)
    if best:
        run.best = {name: value.clone() for name, value in run.network.state_dict().items()}
    return result


def learning_rate_factor(share: float) -> float:
    """Of the largest rate, after a share of all epochs: up over a tenth, then down a cosine."""
    rise = 0.1
    if share < rise:
        return 0.05 + 0.95 * share / rise
    return float(0.5 + 0.5 * np.cos(np.pi * min((share - rise) / (1 - rise), 1.0)))


def _save(run: _Run, out: Path, settings: TrainingSettings) -> None:
    """Network, optimizer and best weights, and the curves so far."""
    arrays: dict[str, NDArray[Any]] = {}
    for name, value in run.network.state_dict().items():
        arrays[f"network/{name}"] = value.numpy()
        arrays[f"best/{name}"] = run.best[name].numpy()
    for i, state in run.optimizer.state_dict()["state"].items():
        arrays |= {f"optimizer/{i}/{key}": np.asarray(value) for key, value in state.items()}
    card = {
        "settings": dc.asdict(settings),
        "rounds": [dc.asdict(r) for r in run.rounds],
    }
    save_weights(out / _CHECKPOINT, arrays, card)
    write_bytes(out / _CURVES, curves_csv(run.rounds).encode())


def _resume(run: _Run, out: Path, settings: TrainingSettings) -> None:
    """Take up a checkpoint, if there is one."""
    if not (out / _CHECKPOINT).is_file():
        return
    arrays, card = load_weights(out / _CHECKPOINT)
    if card.get("settings") != json.loads(json.dumps(dc.asdict(settings))):
        raise BadInput(f"{out} holds a run of other settings; choose another --out, or delete it")
    tensors = {name: torch.from_numpy(np.array(array)) for name, array in arrays.items()}
    run.network.load_state_dict(_part(tensors, "network/"))
    run.best = _part(tensors, "best/")
    states: dict[int, dict[str, torch.Tensor]] = {}
    for name, value in _part(tensors, "optimizer/").items():
        index, key = name.split("/")
        states.setdefault(int(index), {})[key] = value
    content = run.optimizer.state_dict()
    run.optimizer.load_state_dict({**content, "state": states})
    run.rounds = [Round(**r) for r in card["rounds"]]


def _part(tensors: dict[str, torch.Tensor], prefix: str) -> dict[str, torch.Tensor]:
    return {
        name.removeprefix(prefix): value
        for name, value in tensors.items()
        if name.startswith(prefix)
    }
