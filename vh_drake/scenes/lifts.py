"""What comes of planned grasps when the hand alone carries them out in a simulator.

A force-closure label is told of an object that stands still. Here some grasps of the scenes of
a data set lift the true object from the table, with a mass drawn as of household things.
"""

import dataclasses as dc
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vh_drake.batch import run_tasks
from vh_drake.geometry.meshes import TriMesh
from vh_drake.learning.dataset import shard_paths
from vh_drake.learning.generating import GeneratorSettings, hand_model, true_object
from vh_drake.learning.lift_records import GRASPS, LIFTS_FILE, LIFTS_SETTINGS, Lifted
from vh_drake.learning.scene import SceneSettings
from vh_drake.learning.shards import LabelledScene, read_shard
from vh_drake.learning.training_objects import object_mesh
from vh_drake.objects.model import make_object
from vh_drake.scenes.hand_lift import HandLifter
from vh_drake.scenes.scenario import Table
from vh_drake.types import IntArray

_DENSITY = (80.0, 5000.0)  # of foam to steel tools [kg/m³], drawn evenly in its logarithm
_MASS = (0.01, 1.2)  # [kg]
_LEAST = 0.25  # weight of a grasp that never closes on the estimate; always is worth 1 more


def lift_grasps(
    folder: Path, meshes: Path | None, scenes: int, *, workers: int = 0, title: str = ""
) -> list[Lifted]:
    """Carry out grasps of a data set's scenes; what was done is kept beside the shards.

    Args:
        folder: of the data set, made by default settings.
        meshes: the folder of objects from which it was made.
        scenes: how many, the first of each shard, then the second, and so on.
        workers: processes; 0 takes every core.
        title: of the progress bar.

    Raises:
        BadInput: no data set, an object is missing or another, or a damaged file.
    """
    shards = shard_paths(folder)
    each = max(len(read_shard(path)) for path in shards[:1])
    places = [(path, i) for i in range(each) for path in shards][:scenes]
    tasks = {f"{path.stem} {i}": (path, i, meshes) for path, i in places}
    rows = run_tasks(
        _lift_place,
        tasks,
        settings=LIFTS_SETTINGS,
        journal=folder / LIFTS_FILE,
        workers=workers,
        title=title,
    )
    return [Lifted(**row) for row in rows]


def lift_facts(lifts: Sequence[Lifted]) -> dict[str, Any]:
    """How many grasps were carried out, and the share that lifted."""
    outcomes = [lifted for scene in lifts for lifted in scene.lifted]
    return {
        "scenes": sum(bool(scene.grasps) for scene in lifts),
        "lifts": len(outcomes),
        "lifted_share": float(np.mean(outcomes)) if outcomes else None,
    }


def _lift_place(task: tuple[Path, int, Path | None]) -> Mapping[str, Any]:
    shard, place, meshes = task
    scenes = read_shard(shard)
    if place >= len(scenes) or len(scenes[place].candidates) == 0:
        return dc.asdict(Lifted(-1, [], []))
    return dc.asdict(lift_scene(scenes[place], object_mesh(scenes[place].object, meshes)))


def lift_scene(scene: LabelledScene, mesh: TriMesh, count: int = GRASPS) -> Lifted:
    """Carry out some grasps of a scene.

    Args:
        scene: with candidates, drawn with default settings.
        mesh: of its object, as it was drawn with.
        count: of grasps, fewer where the scene has fewer.

    Raises:
        BadInput: the mesh is not that of the scene.
    """
    settings = GeneratorSettings()
    truth = true_object(mesh, scene, settings)
    rng = np.random.default_rng([scene.seed, scene.scene, 41])
    p_OV = (truth.mesh.vertices - truth.X_WO[:3, 3]) @ truth.X_WO[:3, :3]
    standing = TriMesh(p_OV, truth.mesh.faces)
    model = make_object(scene.object, standing, drawn_mass(standing.volume, rng))
    lifter = HandLifter(hand_model(settings.hand), model, table_of(settings.scene))
    chosen = drawn_grasps(scene, count, rng)
    own = scene.candidates.taken(chosen)
    lifted = [
        lifter.lift(truth.X_WO, X_WH, motion).lifted
        for X_WH, motion in zip(own.X_WH, own.motion, strict=True)
    ]
    return Lifted(scene.scene, chosen.tolist(), lifted)


def table_of(settings: SceneSettings) -> Table:
    """The table of drawn scenes, for simulation."""
    return Table(height_m=settings.table_height_m, center=list(settings.center))


def drawn_mass(volume_m3: float, rng: np.random.Generator) -> float:
    """A mass [kg] for an object of a volume, full or hollow, of foam or of metal."""
    density = np.exp(rng.uniform(*np.log(_DENSITY)))
    return float(np.clip(density * volume_m3, *_MASS))


def drawn_grasps(scene: LabelledScene, count: int, rng: np.random.Generator) -> IntArray:
    """Indices of candidates, sorted; those that close on the estimate come more often."""
    weights = _LEAST + scene.estimate_rate
    shares = weights / weights.sum()
    chosen = rng.choice(len(weights), min(count, len(weights)), replace=False, p=shares)
    return np.sort(chosen)
