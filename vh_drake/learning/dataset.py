"""A data set of labelled scenes: a folder of shards, generated resumably by any number of workers.

`dataset.json` says what was asked for. Each shard holds some scenes of one object and is
written whole or not at all, so a killed run goes on where it stopped, and the bytes are the same
whoever computed them. `checksums.json` comes last and vouches for all.
"""

import contextlib
import dataclasses as dc
import hashlib
import json
from collections.abc import Iterator
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

import numpy as np

from vh_drake.atomic_files import write_bytes
from vh_drake.batch import run_tasks
from vh_drake.errors import BadInput
from vh_drake.learning.generating import GeneratorSettings, labelled_scene
from vh_drake.learning.labels import SUCCESS_RATE
from vh_drake.learning.shards import LabelledScene, read_shard, shard_bytes
from vh_drake.learning.training_objects import object_mesh, training_objects

_SPEC = "dataset.json"
_CHECKSUMS = "checksums.json"
_MAX_JSON_BYTES = 64 * 2**20


@dc.dataclass(frozen=True)
class DatasetSpec:
    """All that a data set's bytes depend on, beside the versions of the libraries."""

    scenes: int
    objects: tuple[str, ...]
    folder: Path | None = None  # of meshes
    seed: int = 0
    scenes_per_shard: int = 8
    settings: GeneratorSettings = dc.field(default_factory=GeneratorSettings)

    @property
    def shards(self) -> int:
        """How many files."""
        return -(-self.scenes // self.scenes_per_shard)

    def object_of(self, shard: int) -> str:
        """The object of a shard: all in turn, shuffled anew in every round."""
        count = len(self.objects)
        order = np.random.default_rng([self.seed, 77, shard // count]).permutation(count)
        return self.objects[order[shard % count]]

    def content(self) -> dict[str, Any]:
        """As JSON holds it."""
        content = dc.asdict(self)
        content["folder"] = None if self.folder is None else self.folder.name
        return {**content, "objects": list(self.objects)}


def make_spec(
    scenes: int,
    *,
    folder: Path | None = None,
    shapes: int = 80,
    library: bool = True,
    seed: int = 0,
    settings: GeneratorSettings | None = None,
) -> DatasetSpec:
    """What `generate` needs to know.

    Args:
        scenes: how many.
        folder: meshes of the user's own; those that its objects.csv calls "test" stay out.
        shapes: how many drawn shapes come along.
        library: whether the embedded objects come along, less those of table 4.6.
        seed: of everything.
        settings: of scenes, touches and labels.

    Raises:
        BadInput: a number out of range, or no object.
    """
    if scenes < 1 or shapes < 0 or seed < 0:
        raise BadInput(f"--scenes {scenes}, --shapes {shapes} and --seed {seed}: too small")
    names = training_objects(folder, shapes=shapes, library=library)
    return DatasetSpec(scenes, tuple(names), folder, seed, settings=settings or GeneratorSettings())


def generate(
    out: Path,
    spec: DatasetSpec,
    *,
    workers: int = 0,
    executor: Executor | None = None,
    title: str = "",
) -> dict[str, Any]:
    """Compute the shards that are missing.

    Args:
        out: a folder, empty or with a part of the same data set; workers on other machines
            must see it under the same path.
        spec: what to generate.
        workers: processes; 0 takes every core.
        executor: computes instead, see `dask_executor`.
        title: of the progress bar.

    Returns:
        What `info` tells.

    Raises:
        BadInput: the folder holds another data set, or an object is unusable.
        VhDrakeError: the disk is full or the folder can't be written.
    """
    _claim(out, spec)
    missing = {
        shard_name(i): (str(out), spec, i)
        for i in range(spec.shards)
        if not (out / shard_name(i)).is_file()
    }
    run_tasks(
        _write_shard,
        missing,
        settings={},
        workers=workers,
        executor=executor,
        title=title,
    )
    sums = {shard_name(i): _sha256(out / shard_name(i)) for i in range(spec.shards)}
    write_bytes(out / _CHECKSUMS, (json.dumps(sums, indent=1) + "\n").encode())
    return info(out)


@contextlib.contextmanager
def dask_executor(address: str) -> Iterator[Executor]:
    """The workers of a Dask cluster; one that dies is replaced by the others.

    Raises:
        BadInput: Dask is not installed, or nobody answers at the address.
    """
    try:
        from distributed import Client
    except ImportError as error:
        raise BadInput("--scheduler needs Dask: pip install 'vh_drake[distributed]'") from error
    try:
        client = Client(address, timeout="4s")
    except (OSError, ValueError) as error:
        raise BadInput(f"--scheduler {address}: no Dask scheduler answers ({error})") from error
    with client:
        yield client.get_executor(retries=2)


def shard_name(index: int) -> str:
    """File name of a shard."""
    return f"scenes-{index:05d}.parquet"


def shard_paths(folder: Path) -> list[Path]:
    """The shards of a data set, in order.

    Raises:
        BadInput: there is none.
    """
    paths = sorted(folder.glob("scenes-*.parquet"))
    if not paths:
        raise BadInput(f"{folder}: no data set; make one with `vh-drake dataset generate`")
    return paths


def read_scenes(folder: Path) -> Iterator[LabelledScene]:
    """All scenes of a data set, in order, those without candidates left out.

    Raises:
        BadInput: no data set, or a damaged shard.
    """
    for path in shard_paths(folder):
        yield from (scene for scene in read_shard(path) if len(scene.candidates))


def info(folder: Path) -> dict[str, Any]:
    """Numbers about a data set, finished or not.

    Raises:
        BadInput: no data set, or a damaged shard.
    """
    scenes = list(read_scenes(folder))
    rates = np.concatenate([np.zeros(0), *(scene.label_rate for scene in scenes)])
    touches = np.array([len(scene.contacts) for scene in scenes], np.int64)
    planners: dict[str, int] = {}
    for scene in scenes:
        for name in scene.candidates.planner:
            planners[name] = planners.get(name, 0) + 1
    wanted = _read_json(folder / _SPEC)
    return {
        "scenes": len(scenes),
        "scenes_wanted": wanted.get("scenes"),
        "objects": len({scene.object for scene in scenes}),
        "candidates": len(rates),
        "planners": dict(sorted(planners.items())),
        "success_share": float((rates > SUCCESS_RATE).mean()) if len(rates) else 0.0,
        "mean_rate": float(rates.mean()) if len(rates) else 0.0,
        "scenes_by_contacts": np.bincount(touches, minlength=6).tolist(),
        "bytes": sum(path.stat().st_size for path in shard_paths(folder)),
    }


def verify(folder: Path) -> list[str]:
    """What is wrong with a data set, in sentences; empty where all is well.

    Raises:
        BadInput: there is no data set at all.
    """
    spec, sums = _read_json(folder / _SPEC), _read_json(folder / _CHECKSUMS)
    problems = []
    if not spec:
        problems.append(f"{folder / _SPEC} is missing or damaged")
    if not sums:
        problems.append(f"{folder / _CHECKSUMS} is missing: the data set was not finished")
    for path in shard_paths(folder):
        try:
            problems += [f"{path.name}: {text}" for s in read_shard(path) for text in faults(s)]
        except BadInput as error:
            problems.append(str(error))
        if sums and sums.get(path.name) != _sha256(path):
            problems.append(f"{path.name}: its SHA-256 is not that of {_CHECKSUMS}")
    there = {path.name for path in shard_paths(folder)}
    problems += [f"{name} is missing" for name in sorted(set(sums) - there)]
    return problems


def faults(scene: LabelledScene) -> list[str]:
    """What can't be so in a scene."""
    n, where = len(scene.candidates), f"scene {scene.scene}"
    columns = (scene.label_rate, scene.label_error, scene.estimate_rate, scene.nominal)
    if any(len(column) != n for column in columns):
        return [f"{where}: columns of unlike length"]
    R = scene.candidates.X_WH[:, :3, :3]
    numbers = (scene.view.p_WO, scene.contacts.p_WC, scene.candidates.X_WH, *columns)
    checks = (
        (all(np.isfinite(values).all() for values in numbers), "values that are not finite"),
        (np.allclose(R @ R.transpose(0, 2, 1), np.eye(3), atol=1e-5), "a pose that is no rotation"),
        (((scene.label_rate >= 0) & (scene.label_rate <= 1)).all(), "a rate outside 0..1"),
        ((scene.label_samples > 0).all(), "a label without trials"),
    )
    return [f"{where}: {text}" for fine, text in checks if not fine]


def _claim(out: Path, spec: DatasetSpec) -> None:
    """Note what the folder is for, or refuse one that is for something else."""
    content = json.dumps(spec.content(), indent=1, sort_keys=True) + "\n"
    path = out / _SPEC
    if path.is_file() and path.read_text() != content:
        raise BadInput(f"{out} holds a data set of other settings; choose another --out")
    for leftover in out.glob(".scenes-*"):  # of a kill in the middle of writing
        leftover.unlink()
    write_bytes(path, content.encode())


def _write_shard(task: tuple[str, DatasetSpec, int]) -> int:
    """Compute and write one shard; returns its number of candidates."""
    out, spec, shard = task
    name = spec.object_of(shard)
    mesh = object_mesh(name, spec.folder)
    first = shard * spec.scenes_per_shard
    indices = range(first, min(first + spec.scenes_per_shard, spec.scenes))
    scenes = [labelled_scene(mesh, name, i, spec.seed, spec.settings) for i in indices]
    write_bytes(Path(out) / shard_name(shard), shard_bytes(scenes))
    return sum(len(scene.candidates) for scene in scenes)


def _sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _read_json(path: Path) -> dict[str, Any]:
    """A JSON object; empty where there is none."""
    try:
        if path.stat().st_size > _MAX_JSON_BYTES:
            return {}
        content = json.loads(path.read_text())
    except (OSError, ValueError, RecursionError):
        return {}
    return content if isinstance(content, dict) else {}
