"""What the robot knows of a scene and of grasps in it, for the metric and the lift model."""

import dataclasses as dc

from vh_drake.gpis.surface import estimate_surface
from vh_drake.grasping.field import ObjectField, object_field
from vh_drake.hand.model import HandModel
from vh_drake.learning.features import SceneFields, fused_points, scene_fields
from vh_drake.learning.generating import hand_model
from vh_drake.learning.hints import Hints, hints_on_estimate
from vh_drake.learning.shards import LabelledScene
from vh_drake.types import Candidates, ContactSet, ObjectView, Surface


@dc.dataclass(frozen=True, eq=False)
class Knowledge:
    """Of n grasps in one scene."""

    candidates: Candidates  # n
    surface: Surface  # the estimate
    estimate: ObjectField  # distance to it
    fields: SceneFields
    hints: Hints  # of the candidates


def knowledge(
    candidates: Candidates,
    surface: Surface,
    view: ObjectView,
    contacts: ContactSet,
    hand: HandModel,
    seed: int,
) -> Knowledge:
    """What follows from view, touches and estimate.

    Args:
        candidates: n grasps.
        surface: the estimate.
        view: what the camera shows.
        contacts: what was touched.
        hand: that grasps.
        seed: of the disturbances for the hints.

    Raises:
        BadInput: an empty or open estimate, or nothing seen and touched.
    """
    estimate = object_field(surface, view.table)
    hints = hints_on_estimate(candidates, estimate, fused_points(view, contacts), hand, seed)
    fields = scene_fields(view, contacts, surface)
    return Knowledge(candidates, surface, estimate, fields, hints)


def scene_knowledge(scene: LabelledScene, candidates: Candidates | None = None) -> Knowledge:
    """Of a scene as it is kept on disk, and of some of its candidates or all."""
    own = scene.candidates if candidates is None else candidates
    surface = estimate_surface(scene.view, scene.contacts)
    return knowledge(own, surface, scene.view, scene.contacts, hand_model(""), scene.scene)
