"""One labelled scene: object, pose, look, touches, estimate, candidates, labels."""

import dataclasses as dc
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
    rounds = max(len(settings.touch_counts), 1)
    touches = settings.touch_counts[index % rounds] if settings.touch_counts else None
    for attempt in range(_TRIES):
        rng = np.random.default_rng([seed, index // rounds, attempt])
        try:
            seen = seen_scene(mesh, settings, rng, touches=touches)
            candidates = candidates_of(seen, hand, settings.candidates, int(rng.integers(2**31)))
        except (NothingSeen, BadInput):
            continue
        if len(candidates):
            return _labelled(seen, candidates, hand, name, index, seed, settings)
    return _empty(name, index, seed)


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
    truth = place(vary(mesh, settings.scene, rng), settings.scene, rng)
    weights = np.array(settings.touch_weights)
    drawn = int(rng.choice(len(weights), p=weights / weights.sum()))
    view = look(truth, settings.scene, rng)
    field = object_field(Surface(truth.mesh.vertices, truth.mesh.faces), truth.table)
    wanted = drawn if touches is None else touches
    contacts = explore(view, field, wanted, rng, settings.touch)
    surface = estimate_surface(view, contacts)
    return SeenScene(truth, field, view, contacts, surface, object_field(surface, view.table))


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
