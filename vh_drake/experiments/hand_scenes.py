"""Scenes of objects that the hand alone lifts: drawn as in a data set, in a simulator's plant."""

from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from vh_drake.errors import BadInput, NothingSeen
from vh_drake.experiments.lift_trials import LiftObject
from vh_drake.learning.generating import GeneratorSettings, SeenScene, hand_model, seen_scene
from vh_drake.learning.scene import SceneSettings
from vh_drake.objects.loading import load_object
from vh_drake.objects.model import ObjectModel
from vh_drake.reports import Row
from vh_drake.scenes.hand_lift import HandLifter
from vh_drake.scenes.lifts import table_of

_TRIES = 4  # poses of an object until the camera shows enough of it


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
