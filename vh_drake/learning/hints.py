"""What closing the hand on the estimate tells of a grasp, for the metric to weigh.

The force-closure rate on the estimate is hard to beat where the estimate is right. How many
fingers touch, and how far their contacts are from anything seen or touched, tells when it may
be wrong.
"""

import dataclasses as dc

import numpy as np
from scipy.spatial import cKDTree

from vh_drake.geometry.meshes import Mask
from vh_drake.grasping.closing import Closure
from vh_drake.grasping.field import ObjectField
from vh_drake.hand.model import HandModel
from vh_drake.learning.labels import (
    LabelSettings,
    guarded_rates,
    nominal_closure,
    nominal_closures,
)
from vh_drake.types import Array, Candidates, IntArray

HINT_NUMBERS = 11
HINT_SETTINGS = LabelSettings(min_samples=12, max_samples=24)
_LOG_ODDS = 4.0  # one unit of each number, so that all are of one magnitude
_FINGERS = 4.0
_OFFSET_M = 0.05
_CONTACTS = 8.0
_MEAN_GUESS_M = 0.03
_FAR_M = 0.06  # contacts farther from any evidence are all alike


@dc.dataclass(frozen=True, eq=False)
class Hints:
    """Of n grasps on the estimate."""

    rate: Array  # (n,) force-closure rate
    samples: IntArray  # (n,) trials
    nominal: Mask  # (n,) closure without disturbance
    fingers: Array  # (n,) mean number of fingers in contact, thumbs left out
    opposed: Array  # (n,) share in which a thumb and something else touch
    offset: Array  # (n, 3) mean contact less centre of mass, in the hand's axes [m]
    closures: tuple[Closure, ...]  # (n,) how the undisturbed grasps end
    contacts: Array  # (n,) of these
    mean_guess: Array  # (n,) mean distance of these contacts from a fused point [m]
    max_guess: Array  # (n,) the largest [m]


def hints_on_estimate(
    candidates: Candidates, estimate: ObjectField, fused: Array, hand: HandModel, seed: int
) -> Hints:
    """Close the hand on the estimate, disturbed and undisturbed.

    Args:
        candidates: n grasps.
        estimate: distance to the estimated surface.
        fused: (p, 3) points of camera and touches [m].
        hand: that grasps.
        seed: of the disturbances.
    """
    rates = guarded_rates(candidates, estimate, hand, HINT_SETTINGS, seed)
    closures = nominal_closures(candidates, estimate, hand, HINT_SETTINGS)
    contacts = [closure.p_WC for closure in closures]
    tree = cKDTree(fused)
    guesses = [np.minimum(tree.query(p)[0], _FAR_M) if len(p) else [_FAR_M] for p in contacts]
    touched = (rates.fingers > 0) | (rates.opposed > 0)
    offset_W = np.where(touched[:, None], rates.centroid - estimate.center, 0.0)
    return Hints(
        rate=rates.rate,
        samples=rates.samples,
        nominal=nominal_closure(candidates, estimate, hand, HINT_SETTINGS),
        fingers=rates.fingers,
        opposed=rates.opposed,
        offset=np.einsum("nij,ni->nj", candidates.X_WH[:, :3, :3], offset_W),
        closures=tuple(closures),
        contacts=np.array([len(p) for p in contacts], float),
        mean_guess=np.array([np.mean(guess) for guess in guesses]),
        max_guess=np.array([np.max(guess) for guess in guesses]),
    )


def hint_inputs(hints: Hints | None, count: int) -> Array:
    """Numbers (n, 11) for the network: 1 and the hints, or all 0 without any."""
    if hints is None:
        return np.zeros((count, HINT_NUMBERS))
    closed = hints.rate * hints.samples
    odds = np.log((closed + 0.5) / (hints.samples - closed + 0.5))
    return np.column_stack(
        [
            np.ones(count),
            odds / _LOG_ODDS,
            hints.nominal,
            hints.fingers / _FINGERS,
            hints.opposed,
            hints.offset / _OFFSET_M,
            hints.contacts / _CONTACTS,
            hints.mean_guess / _MEAN_GUESS_M,
            hints.max_guess / _FAR_M,
        ]
    )
