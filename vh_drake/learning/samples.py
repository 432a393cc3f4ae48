"""Training samples: scenes with their fields in memory, grids made when they are needed."""

import dataclasses as dc
import io
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from vh_drake.atomic_files import write_bytes
from vh_drake.batch import run_tasks
from vh_drake.errors import BadInput
from vh_drake.geometry.meshes import Mask
from vh_drake.learning.dataset import shard_paths
from vh_drake.learning.features import (
    SceneFields,
    pose_inputs,
    sample_grids,
)
from vh_drake.learning.hints import HINT_NUMBERS
from vh_drake.learning.knowledge import scene_knowledge
from vh_drake.learning.shards import LabelledScene, read_shard
from vh_drake.learning.soft_labels import RatePrior, fit_prior
from vh_drake.types import Array, IntArray

GROUP = 16  # candidates of one scene that enter a batch together
_FIELDS = "fields"  # folder of cached fields within a data set


@dc.dataclass(frozen=True, eq=False)
class SceneSamples:
    """n candidates of one scene, ready to learn from."""

    object: str
    scene: int
    fields: SceneFields
    X_WH: Array  # (n, 4, 4)
    numbers: NDArray[np.float32]  # (n, 28), hints among them
    success: Array  # (n,) how probable it is, by the label's trials, that the rate is over 0.8
    rate: Array  # (n,) of the label
    estimate_rate: Array  # (n,) on the estimate
    nominal: Mask  # (n,)

    def __len__(self) -> int:
        return len(self.X_WH)


@dc.dataclass(frozen=True, eq=False)
class Batch:
    """Inputs and targets of b candidates."""

    grids: torch.Tensor  # (b, 2, 32, 32, 32)
    numbers: torch.Tensor  # (b, 28)
    targets: torch.Tensor  # (b, 2) success and rate


def load_samples(folder: Path, *, workers: int = 1, title: str = "") -> list[SceneSamples]:
    """All scenes of a data set with candidates; fields are cached beside the shards.

    Raises:
        BadInput: no data set, a damaged shard, or no scene with candidates.
    """
    paths = shard_paths(folder)
    missing = {path.name: path for path in paths if not _cache(path).is_file()}
    run_tasks(_cache_fields, missing, settings={}, workers=workers, title=title)
    shards = {path: [s for s in read_shard(path) if len(s.candidates)] for path in paths}
    prior = _prior([scene for scenes in shards.values() for scene in scenes])
    samples = [
        sample for path, scenes in shards.items() for sample in _shard_samples(path, scenes, prior)
    ]
    if not samples:
        raise BadInput(f"{folder}: no scene has a candidate; generate more")
    return samples


def _prior(scenes: Sequence[LabelledScene]) -> RatePrior:
    """Of the rates of a data set; uniform where it has no candidate."""
    if not scenes:
        return RatePrior()
    rate = np.concatenate([scene.label_rate for scene in scenes])
    return fit_prior(rate, np.concatenate([scene.label_samples for scene in scenes]))


def split_objects(objects: Sequence[str], share: float, seed: int) -> tuple[set[str], set[str]]:
    """Objects to learn from, and those held out for stopping and calibration.

    Raises:
        BadInput: there are fewer than two objects.
    """
    names = sorted(set(objects))
    if len(names) < 2:
        raise BadInput(f"the data set has {len(names)} object; learning needs at least two")
    order = np.random.default_rng([seed, 5]).permutation(len(names))
    held = max(1, round(share * len(names)))
    return {names[i] for i in order[held:]}, {names[i] for i in order[:held]}


def batches(
    scenes: Sequence[SceneSamples], size: int, rng: np.random.Generator | None
) -> Iterator[Batch]:
    """All candidates once: groups of a scene, shuffled, several groups a batch.

    Args:
        scenes: where the candidates come from.
        size: of a batch, in whole groups.
        rng: shuffles; None keeps the order.
    """
    groups: list[tuple[SceneSamples, IntArray]] = []
    for scene in scenes:
        order = np.arange(len(scene)) if rng is None else rng.permutation(len(scene))
        groups += [(scene, order[i : i + GROUP]) for i in range(0, len(order), GROUP)]
    turns = np.arange(len(groups)) if rng is None else rng.permutation(len(groups))
    step = max(1, size // GROUP)
    for first in range(0, len(turns), step):
        yield _batch([groups[i] for i in turns[first : first + step]])


def _batch(groups: list[tuple[SceneSamples, IntArray]]) -> Batch:
    grids = [sample_grids(scene.fields, scene.X_WH[own]) for scene, own in groups]
    numbers = [scene.numbers[own] for scene, own in groups]
    targets = [np.column_stack([scene.success[own], scene.rate[own]]) for scene, own in groups]
    return Batch(
        torch.cat(grids),
        torch.from_numpy(np.concatenate(numbers)),
        torch.from_numpy(np.concatenate(targets).astype(np.float32)),
    )


def scene_samples(
    scene: LabelledScene,
    fields: SceneFields,
    numbers: NDArray[np.float32],
    prior: RatePrior | None = None,
) -> SceneSamples:
    """A labelled scene with its fields and numbers; the prior of its rates is uniform if None."""
    return SceneSamples(
        object=scene.object,
        scene=scene.scene,
        fields=fields,
        X_WH=scene.candidates.X_WH,
        numbers=numbers,
        success=(prior or RatePrior()).success_probability(scene.label_rate, scene.label_samples),
        rate=scene.label_rate,
        estimate_rate=scene.estimate_rate,
        nominal=scene.nominal,
    )


def without_hints(numbers: torch.Tensor, hidden: torch.Tensor | None = None) -> torch.Tensor:
    """A copy of the numbers (n, 28) whose rows `hidden` (n,), else all, have no hints."""
    blind = numbers.clone()
    rows = torch.ones(len(numbers), dtype=torch.bool) if hidden is None else hidden
    blind[rows, -HINT_NUMBERS:] = 0
    return blind


def _cache(shard: Path) -> Path:
    return shard.parent / _FIELDS / f"{shard.stem}.npz"


def _cache_fields(shard: Path) -> int:
    """Compute and keep fields and numbers of a shard's scenes; returns how many."""
    arrays: dict[str, NDArray[Any]] = {}
    scenes = [scene for scene in read_shard(shard) if len(scene.candidates)]
    for i, scene in enumerate(scenes):
        fields, numbers = inputs_of(scene)
        arrays[f"values_{i}"] = fields.values.astype(np.float16)
        arrays[f"numbers_{i}"] = numbers
        arrays[f"frame_{i}"] = np.concatenate(
            [fields.origin, [fields.spacing], fields.center, fields.size]
        )
    buffer = io.BytesIO()
    np.savez_compressed(buffer, allow_pickle=False, **arrays)
    write_bytes(_cache(shard), buffer.getvalue())
    return len(scenes)


def inputs_of(scene: LabelledScene) -> tuple[SceneFields, NDArray[np.float32]]:
    """Fields and numbers (n, 28), hints included, of a scene as it is kept on disk."""
    known = scene_knowledge(scene)
    return known.fields, pose_inputs(known.fields, scene.candidates, known.hints)


def _shard_samples(
    shard: Path, scenes: Sequence[LabelledScene], prior: RatePrior
) -> list[SceneSamples]:
    with np.load(_cache(shard), allow_pickle=False) as arrays:
        return [
            scene_samples(
                scene,
                _fields(scene, arrays[f"values_{i}"], arrays[f"frame_{i}"]),
                arrays[f"numbers_{i}"],
                prior,
            )
            for i, scene in enumerate(scenes)
        ]


def _fields(scene: LabelledScene, values: NDArray[np.float16], frame: Array) -> SceneFields:
    return SceneFields(
        origin=frame[:3],
        spacing=float(frame[3]),
        values=values,  # type: ignore[arg-type]  # Half precision until it is sampled
        center=frame[4:7],
        size=frame[7:],
        table=scene.view.table,
        contacts=len(scene.contacts),
    )
