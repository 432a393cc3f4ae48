"""Scenes of objects that the hand alone lifts: drawn as in a data set, in a simulator's plant."""

from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from vh_drake.batch import run_tasks
from vh_drake.catalog import Options
from vh_drake.errors import BadInput, NothingSeen
from vh_drake.experiments.lift_trials import LiftObject, chosen_objects
from vh_drake.experiments.robustness import scenes
from vh_drake.learning.generating import GeneratorSettings, SeenScene, hand_model, seen_scene
from vh_drake.learning.scene import SceneSettings
from vh_drake.objects.loading import load_object
from vh_drake.objects.model import ObjectModel
from vh_drake.reports import Row
from vh_drake.scenes.hand_lift import HandLifter
from vh_drake.scenes.lifts import table_of

_TRIES = 4  # poses of an object until the camera shows enough of it


def rows_of_scenes(
    function: Callable[[Row], list[Row]], options: Options, settings: Row, **more: Any
) -> tuple[list[Row], Row]:
    """Apply a function to scenes of all objects in turn; resumes from the out folder's journal.

    Args:
        function: of the top level of a module; of a `hand_task`.
        options: objects, split, seed, workers, out.
        settings: all that the rows depend on beside these, "scenes" among them.
        more: what every task holds beside object and seed.

    Returns:
        The rows of all scenes, and all settings.

    Raises:
        BadInput: folder or options are unusable.
    """
    objects, left_out = chosen_objects(options)
    tasks = {
        f"{item.name} {seed}": hand_task(item, seed, **more)
        for item, seed in scenes(objects, settings["scenes"], options.seed)
    }
    settings = {
        "objects": [item.name for item in objects],
        "left_out": left_out,
        **settings,
        "seed": options.seed,
        "contact": "point",
    }
    found = run_tasks(
        function,
        tasks,
        settings=settings,
        journal=options.out / "journal.jsonl",
        workers=options.workers,
        title="lifting",
    )
    return [row for scene in found for row in scene], settings


def hand_task(item: LiftObject, seed: int, **more: Any) -> Row:
    """An object and a seed as JSON holds them."""
    return {
        "object": item.name,
        "folder": item.folder,
        "mass_kg": item.mass_kg,
        "split": item.split,
        "kind": item.kind,
        "seed": seed,
        **more,
    }


def drawn_scene(model: ObjectModel, name: str, seed: int, touches: int) -> SeenScene | None:
    """A scene after some touches, which change neither pose nor look; None if little is seen."""
    plain = SceneSettings(scale=[1.0, 1.0], stretch=[1.0, 1.0])
    settings = GeneratorSettings(scene=plain)
    for attempt in range(_TRIES):
        rng = np.random.default_rng([seed, attempt, *name.encode()])
        try:
            return seen_scene(model.mesh, settings, rng, touches=touches)
        except (NothingSeen, BadInput):
            continue
    return None


@lru_cache(maxsize=2)
def model_of(name: str, folder: str, mass_kg: float | None) -> ObjectModel:
    """The object of a task, read once a process."""
    return load_object(name, mass_kg=mass_kg, folder=Path(folder) if folder else None)


@lru_cache(maxsize=2)
def lifter_of(name: str, folder: str, mass_kg: float | None) -> HandLifter:
    """The simulator of a task, built once a process."""
    model = model_of(name, folder, mass_kg)
    return HandLifter(hand_model(""), model, table_of(SceneSettings()))
