"""Whether an object can be grasped at all, as it lies: a search on its true mesh.

Where no candidate of a scene succeeds, planner and estimate may be at fault, or the hand: it may
not span the object, or not get below it. Poses drawn on the truth, many more of them, and with
none of the limits that usual plans keep to, tell these apart.
"""

import dataclasses as dc

import numpy as np

from vh_drake.grasping.field import object_field
from vh_drake.grasping.planner_settings import APPROACHES, PlannerSettings
from vh_drake.grasping.planners import joined, plan_candidates
from vh_drake.hand.model import HandModel
from vh_drake.learning.labels import LabelSettings, guarded_rates
from vh_drake.learning.scene import TrueObject
from vh_drake.types import Surface

_FINAL = 50  # of the roughly best rated, that are labelled
_ANY_M = 1.0  # wider and taller than any object on the table
UNLIMITED = PlannerSettings(
    candidates=3000,
    rounds=20,
    draws=2000,
    collect_along_m=[-0.09, 0.03],
    collect_across_m=[-0.09, 0.06],
    collect_widest_m=_ANY_M,
    collect_tallest_m=_ANY_M,
    collect_highest_m=0.1,
    side_heights_m=[0.02, 0.3],
    side_below_top_m=-0.1,
    side_near_center_m=0.2,
    side_widest_m=_ANY_M,
    side_lowest_m=0.0,
    free_widest_m=_ANY_M,
)


def best_grasp(
    truth: TrueObject,
    hand: HandModel,
    label: LabelSettings,
    seed: int = 0,
    *,
    settings: PlannerSettings = UNLIMITED,
) -> tuple[float, int]:
    """The highest force-closure rate found on the true mesh, and of how many candidates.

    Args:
        truth: the object on the table.
        hand: that grasps.
        label: how the best of them are executed and disturbed.
        seed: of draws and disturbances.
        settings: what is tried; each approach by itself, in the number of `candidates`.
    """
    surface = Surface(truth.mesh.vertices, truth.mesh.faces)
    field = object_field(surface, truth.table)
    tried = joined(
        [
            plan_candidates(
                surface, truth.table, hand, dc.replace(settings, approaches=[approach]), seed
            )
            for approach in APPROACHES
        ]
    )
    if len(tried) == 0:
        return 0.0, 0
    rough = guarded_rates(tried, field, hand, LabelSettings(), seed).rate
    best = np.argsort(-rough, kind="stable")[:_FINAL]
    finest = guarded_rates(tried.taken(best), field, hand, label, seed + 1).rate
    return float(finest.max()), len(tried)
