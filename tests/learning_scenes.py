"""Small labelled scenes that several tests share."""

import functools

import numpy as np
from scenery import can_view

from vh_drake.gpis.surface import estimate_surface
from vh_drake.learning.generating import GeneratorSettings, labelled_scene
from vh_drake.learning.labels import LabelSettings
from vh_drake.learning.training_objects import object_mesh
from vh_drake.types import Candidates, ContactSet, ObjectView, Surface

FAST = GeneratorSettings(
    candidates=24,
    label=LabelSettings(min_samples=8, max_samples=8),
    estimate=LabelSettings(min_samples=8, max_samples=8),
)


@functools.cache
def can_scene(touches=1):
    """A labelled scene with an embedded can."""
    settings = GeneratorSettings(**{**vars(FAST), "touch_counts": [touches]})
    return labelled_scene(object_mesh("can", None), "can", 0, 0, settings)


@functools.cache
def can_estimate() -> tuple[ObjectView, ContactSet, Surface]:
    """View, one contact and estimate of the can of `scenery`."""
    contacts = ContactSet(np.array([[0.74, -0.3, 0.95]]), np.array([[1.0, 0.0, 0.0]]))
    return can_view(), contacts, estimate_surface(can_view(), contacts)


def poses_around_the_can(count, seed=0):
    """Random hand poses near it, as candidates."""
    rng = np.random.default_rng(seed)
    X_WH = np.tile(np.eye(4), (count, 1, 1))
    X_WH[:, :3, :3] = np.linalg.qr(rng.normal(size=(count, 3, 3)))[0]
    X_WH[:, :3, :3] *= np.sign(np.linalg.det(X_WH[:, :3, :3]))[:, None, None]
    X_WH[:, :3, 3] = np.array([0.7, -0.3, 1.0]) + rng.uniform(-0.08, 0.08, (count, 3))
    return Candidates(X_WH, ("collect",) * count, ("surface",) * count)
