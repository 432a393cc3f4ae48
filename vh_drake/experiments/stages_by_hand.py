"""`reproduce stages-by-hand`: what each stage is worth, in very many lifts by the hand alone.

The same scenes meet every variant, as in `stages`, but kinematic touches stand for the arm's
and a hand on a carriage for the robot: each scene costs seconds, and small gains show. The best
rated grasp within the arm's reach is carried out.
"""

import dataclasses as dc
from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import numpy as np

from vh_drake.catalog import Options
from vh_drake.control.kinematics import ArmKinematics
from vh_drake.experiments.hand_scenes import drawn_scene, lifter_of, model_of, rows_of_scenes
from vh_drake.experiments.stages import WHOLE, gains, variant_rows
from vh_drake.geometry.signed_distance import signed_distance_grid
from vh_drake.gpis.meshing import closed_mesh
from vh_drake.grasping.planner_settings import PlannerSettings
from vh_drake.grasping.planners import plan_candidates
from vh_drake.learning.generating import SeenScene, hand_model
from vh_drake.reports import Report, Row
from vh_drake.scenes.rating import Score, make_scorer
from vh_drake.types import Array, Surface

SCENES = 150
_PADDING_M = 0.03  # of the potential around the true surface


@dc.dataclass(frozen=True)
class Variant:
    """What the robot does in every scene."""

    touches: int | None = 1  # None: the true surface is known, more than any touch tells
    scorer: str = "learned"
    planner: PlannerSettings = dc.field(default_factory=PlannerSettings)


VARIANTS: Mapping[str, Variant] = {
    WHOLE: Variant(),
    "no touch": Variant(touches=0),
    "true surface": Variant(touches=None),
    "rate and physical sense": Variant(scorer="conventional"),
    "rate on the estimate": Variant(scorer="rate"),
    "epsilon": Variant(scorer="epsilon"),
    "nominal force closure": Variant(scorer="nominal"),
    "surface planner only": Variant(planner=PlannerSettings(planners=["surface"])),
    "skeleton planner only": Variant(planner=PlannerSettings(planners=["skeleton"])),
    "top grasps only": Variant(planner=PlannerSettings(approaches=["collect"])),
}


def run(options: Options) -> Report:
    """All variants on the same scenes.

    Raises:
        BadInput: folder or options are unusable.
    """
    own = {"variants": list(VARIANTS), "scenes": options.scenes or SCENES}
    rows, settings = rows_of_scenes(lifts_of_scene, options, own)
    table = variant_rows(rows, list(VARIANTS), options.seed)
    return Report("stages-by-hand", settings, gains(table), {}, [*table, *rows])


def lifts_of_scene(task: Mapping[str, Any]) -> list[Row]:
    """One row a variant: whether the grasp that it takes for the best lifts the object."""
    own = (task["object"], task["folder"], task["mass_kg"])
    model, lifter = model_of(*own), lifter_of(*own)
    seen: dict[int | None, SeenScene | None] = {
        n: drawn_scene(model, task["object"], task["seed"], n) for n in (0, 1)
    }
    seen[None] = None if seen[0] is None else fully_known(seen[0])
    outcomes: dict[bytes, bool] = {}
    rows = []
    for name, variant in VARIANTS.items():
        scene, lifted = seen[variant.touches], False
        grasp = None if scene is None else best_grasp(scene, variant, task["seed"])
        if scene is not None and grasp is not None:
            X_WH, motion = grasp
            key = X_WH.tobytes() + motion.encode()
            if key not in outcomes:
                outcomes[key] = lifter.lift(scene.truth.X_WO, X_WH, motion).lifted
            lifted = outcomes[key]
        place = {key: task[key] for key in ("object", "split", "kind", "seed")}
        rows.append({"variant": name, **place, "found": grasp is not None, "lifted": lifted})
    return rows


def fully_known(scene: SeenScene) -> SeenScene:
    """The scene with the true surface for an estimate."""
    old, mesh = scene.surface.potential, scene.truth.mesh
    potential = signed_distance_grid(mesh, spacing=old.spacing, padding=_PADDING_M)
    vertices, faces, normals = closed_mesh(potential, mesh.vertices)
    surface = Surface(vertices, faces, normals, np.zeros(len(vertices)), potential)
    return dc.replace(scene, surface=surface)


def best_grasp(scene: SeenScene, variant: Variant, seed: int) -> tuple[Array, str] | None:
    """Pose and motion of the grasp that a variant rates best; None where it finds none."""
    table, hand = scene.view.table, hand_model("")
    candidates = plan_candidates(scene.surface, table, hand, variant.planner, seed, arm=_arm())
    if len(candidates) == 0:
        return None
    scorer = _scorer(variant.scorer, seed)
    scores = scorer(candidates, scene.surface, scene.view, scene.contacts).score
    best = int(np.argmax(scores))
    return candidates.X_WH[best], candidates.motion[best]


@lru_cache(maxsize=1)
def _arm() -> ArmKinematics:
    return ArmKinematics("right")


@lru_cache(maxsize=8)
def _scorer(name: str, seed: int) -> Score:
    return make_scorer(name, hand_model(""), seed)
