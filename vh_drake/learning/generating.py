"""One labelled scene: object, pose, look, touches, estimate, candidates, labels."""

import dataclasses as dc
from collections.abc import Iterator
from functools import cache

import numpy as np

from vh_drake.errors import BadInput, NothingSeen
from vh_drake.geometry.meshes import TriMesh
from vh_drake.gpis.surface import estimate_surface
from vh_drake.grasping.field import ObjectField, object_field
from vh_drake.grasping.planner_settings import PlannerSettings
from vh_drake.grasping.planners import plan_candidates
from vh_drake.hand.description import load_hand
from vh_drake.hand.model import HandModel, read_hand_model
from vh_drake.hand.shipped import hand_file
from vh_drake.learning.labels import LabelSettings, guarded_rates, nominal_closure
from vh_drake.learning.scene import SceneSettings, TrueObject, look, place, single, vary
from vh_drake.learning.shards import LabelledScene
from vh_drake.learning.touches import KinematicTouchSettings, explore
from vh_drake.types import Candidates, ContactSet, ObjectView, Surface

_TRIES = 4  # poses of an object until one can be grasped at all


@dc.dataclass
class GeneratorSettings:
    """How scenes are drawn and labelled."""

    candidates: int = 160  # a scene
    touch_weights: list[float] = dc.field(
        default_factory=lambda: [0.2, 0.3, 0.2, 0.1, 0.1, 0.1]
    )  # how often 0, 1, 2, ... touches are tried
    # Else the touches of scenes in turn; each round of them shares one pose and one look.
    touch_counts: list[int] = dc.field(default_factory=list)
    scene: SceneSettings = dc.field(default_factory=SceneSettings)
    touch: KinematicTouchSettings = dc.field(default_factory=KinematicTouchSettings)
    label: LabelSettings = dc.field(default_factory=LabelSettings)
    estimate: LabelSettings = dc.field(
        default_factory=lambda: LabelSettings(min_samples=12, max_samples=24)
    )
    hand: str = ""  # a shipped hand's name or a description file


@dc.dataclass(frozen=True, eq=False)
class SeenScene:
    """A scene after its touches: what the robot knows, and the truth beside it."""

    truth: TrueObject
    field: ObjectField  # of the true object
    view: ObjectView
    contacts: ContactSet
    surface: Surface
    estimate: ObjectField  # of the estimated surface


def labelled_scene(
    mesh: TriMesh, name: str, index: int, seed: int, settings: GeneratorSettings
) -> LabelledScene:
    """Draw a scene with an object and label its candidates.

    Where nothing is seen, or no hand finds a place, the pose is drawn again; a scene that
    stays without candidates is kept, without any.

    Args:
        mesh: watertight, in its own frame.
        name: of the object, for the record.
        index: of the scene, part of the seed.
        seed: of the data set.
        settings: of the generator.
    """
    hand = hand_model(settings.hand)
    rounds = _rounds(settings)
    touches = settings.touch_counts[index % rounds] if settings.touch_counts else None
    for rng in _draws(seed, index, settings):
        try:
            seen = seen_scene(mesh, settings, rng, touches=touches)
            candidates = candidates_of(seen, hand, settings.candidates, int(rng.integers(2**31)))
        except (NothingSeen, BadInput):
            continue
        if len(candidates):
            return _labelled(seen, candidates, hand, name, index, seed, settings)
    return _empty(name, index, seed)


def _rounds(settings: GeneratorSettings) -> int:
    """How many scenes share one pose and one look."""
    return max(len(settings.touch_counts), 1)


def _draws(seed: int, index: int, settings: GeneratorSettings) -> Iterator[np.random.Generator]:
    """Chance anew for each try of a scene; alike for the scenes of one round."""
    for attempt in range(_TRIES):
        yield np.random.default_rng([seed, index // _rounds(settings), attempt])


def true_object(mesh: TriMesh, scene: LabelledScene, settings: GeneratorSettings) -> TrueObject:
    """The object as it lay in a scene, which keeps only what was seen of it.

    Args:
        mesh: watertight, in its own frame.
        scene: drawn with it.
        settings: with which it was drawn.

    Raises:
        BadInput: no draw shows what the scene shows, so that mesh or settings are others.
    """
    for rng in _draws(scene.seed, scene.scene, settings):
        try:
            truth, _, view = _seen(mesh, settings, rng)
        except NothingSeen:
            continue
        if np.array_equal(view.p_WO, scene.view.p_WO):
            return truth
    raise BadInput(f"scene {scene.scene} shows another object than this mesh of {scene.object}")


@cache
def hand_model(hand: str) -> HandModel:
    """A hand by name or file, read once a process."""
    return read_hand_model(load_hand(hand_file(hand)))


def seen_scene(
    mesh: TriMesh, settings: GeneratorSettings, rng: np.random.Generator, *, touches: int | None
) -> SeenScene:
    """Place, look, touch, estimate; the number of touches is drawn where None.

    Raises:
        NothingSeen: the camera shows too little of the object.
        BadInput: the estimate encloses nothing.
    """
    truth, drawn, view = _seen(mesh, settings, rng)
    field = object_field(Surface(truth.mesh.vertices, truth.mesh.faces), truth.table)
    wanted = drawn if touches is None else touches
    contacts = explore(view, field, wanted, rng, settings.touch)
    surface = estimate_surface(view, contacts)
    return SeenScene(truth, field, view, contacts, surface, object_field(surface, view.table))


def _seen(
    mesh: TriMesh, settings: GeneratorSettings, rng: np.random.Generator
) -> tuple[TrueObject, int, ObjectView]:
    """The placed object, how many touches were drawn, and what the camera shows."""
    truth = place(vary(mesh, settings.scene, rng), settings.scene, rng)
    weights = np.array(settings.touch_weights)
    drawn = int(rng.choice(len(weights), p=weights / weights.sum()))
    return truth, drawn, look(truth, settings.scene, rng)


def candidates_of(seen: SeenScene, hand: HandModel, count: int, seed: int) -> Candidates:
    """Candidates of all planners on the estimate, in single precision.

    Raises:
        BadInput: the estimate is empty or open.
    """
    settings = PlannerSettings(candidates=count)
    found = plan_candidates(seen.surface, seen.view.table, hand, settings, seed)
    return dc.replace(found, X_WH=single(found.X_WH))


def _labelled(
    seen: SeenScene,
    candidates: Candidates,
    hand: HandModel,
    name: str,
    index: int,
    seed: int,
    settings: GeneratorSettings,
) -> LabelledScene:
    label = guarded_rates(candidates, seen.field, hand, settings.label, index)
    estimate = guarded_rates(candidates, seen.estimate, hand, settings.estimate, index + 1)
    nominal = nominal_closure(candidates, seen.estimate, hand, settings.estimate)
    return LabelledScene(
        scene=index,
        object=name,
        seed=seed,
        view=seen.view,
        contacts=seen.contacts,
        candidates=candidates,
        label_rate=label.rate,
        label_error=label.standard_error,
        label_samples=label.samples,
        estimate_rate=estimate.rate,
        estimate_samples=estimate.samples,
        nominal=nominal,
    )


def _empty(name: str, index: int, seed: int) -> LabelledScene:
    none, counts = np.zeros(0), np.zeros(0, np.int64)
    return LabelledScene(
        scene=index,
        object=name,
        seed=seed,
        view=ObjectView(),
        contacts=ContactSet(),
        candidates=Candidates(),
        label_rate=none,
        label_error=none,
        label_samples=counts,
        estimate_rate=none,
        estimate_samples=counts,
        nominal=np.zeros(0, bool),
    )
