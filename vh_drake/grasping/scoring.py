"""The conventional rating of candidates: force-closure rate times physical sense.

A grasp may close well on the estimate and yet fail: because it holds the object far from its
centre of mass, which lets it tilt; with too few fingers; on parts of the surface that are a
guess; or where the object lies so in the hand that thumb and fingers slip past it. Each of
these is a factor between 0 and 1, and the score is the product.
"""

import dataclasses as dc

import numpy as np
from scipy.spatial import cKDTree

from vh_drake.errors import BadInput
from vh_drake.grasping.closure_rate import ClosureRates, PerturbationSettings, closure_rates
from vh_drake.grasping.field import ObjectField, object_field
from vh_drake.grasping.in_hand import PlaceSettings, well_placed
from vh_drake.grasping.motions import MOTIONS, CollectSettings, motion_of
from vh_drake.grasping.wrench_space import ContactSettings
from vh_drake.hand.model import HandModel
from vh_drake.types import Array, Candidates, GraspScores, Plane, Surface


@dc.dataclass
class ScoringSettings:
    """Weights of the conventional rating."""

    perturbation: PerturbationSettings = dc.field(default_factory=PerturbationSettings)
    contact: ContactSettings = dc.field(default_factory=ContactSettings)
    collect: CollectSettings = dc.field(default_factory=CollectSettings)
    center_scale_m: float = 0.04  # horizontal offset that costs 1 - exp(-1/2)
    enough_fingers: float = 3.0  # beside the thumb; all where the hand has fewer
    variance_weight: float = 0.4  # what a grasp on the least certain parts loses at most
    place: PlaceSettings = dc.field(default_factory=PlaceSettings)


@dc.dataclass(frozen=True, eq=False)
class GraspRating:
    """The factors of n scores, each in 0..1."""

    rate: Array  # (n,) force-closure rate
    standard_error: Array  # (n,) of the rate
    centered: Array  # (n,) how near the contacts' centroid is to the centre of mass
    held: Array  # (n,) how many fingers touch, and whether a thumb opposes them
    certain: Array  # (n,) how well the surface is known around the contacts' centroid
    placed: Array  # (n,) how well the object lies between thumb and fingers

    def scores(self) -> GraspScores:
        """The product of the factors, with the rate's error scaled alike."""
        sense = self.centered * self.held * self.certain * self.placed
        return GraspScores(self.rate * sense, self.standard_error * sense)


def score_candidates(
    candidates: Candidates,
    surface: Surface,
    table: Plane,
    hand: HandModel,
    settings: ScoringSettings,
    seed: int,
) -> GraspScores:
    """Scores of candidates in their order; see `rate_candidates` for the factors."""
    return rate_candidates(candidates, surface, table, hand, settings, seed).scores()


def rate_candidates(
    candidates: Candidates,
    surface: Surface,
    table: Plane,
    hand: HandModel,
    settings: ScoringSettings,
    seed: int,
) -> GraspRating:
    """Rate candidates on an estimated surface.

    Raises:
        BadInput: the surface is empty or open, a motion is unknown, or a setting is unusable.
    """
    unknown = set(candidates.motion) - set(MOTIONS)
    if unknown:
        raise BadInput(f"unknown closing motion {sorted(unknown)}; choose of {list(MOTIONS)}")
    most = float((hand.opposing == 0).sum())
    settings = dc.replace(settings, enough_fingers=min(settings.enough_fingers, most))
    field = object_field(surface, table)
    certainty = vertex_certainty(surface.variance, len(surface.vertices))
    tree = cKDTree(surface.vertices)
    factors = np.zeros((6, len(candidates)))
    for name in sorted(set(candidates.motion)):
        own = np.array([motion == name for motion in candidates.motion])
        rates = closure_rates(
            hand,
            field,
            motion_of(name, hand, settings.collect),
            candidates.X_WH[own],
            perturbation=settings.perturbation,
            contact=settings.contact,
            seed=seed,
        )
        factors[:5, own] = _factors(rates, field, tree, certainty, settings)
        factors[5, own] = well_placed(
            candidates.X_WH[own], name, surface.vertices, field, hand, settings.place
        )
    return GraspRating(*factors)


def vertex_certainty(variance: Array, count: int) -> Array:
    """How well each vertex is known: 1 at the least variance, 0 at the largest, (count,)."""
    if len(variance) != count or np.ptp(variance) <= 0:
        return np.ones(count)
    rank = (np.asarray(variance) - variance.min()) / np.ptp(variance)
    certainty: Array = 1 - rank
    return certainty


def _factors(
    rates: ClosureRates,
    field: ObjectField,
    tree: cKDTree,
    certainty: Array,
    settings: ScoringSettings,
) -> Array:
    """The first rows of `GraspRating`, (5, n)."""
    up = np.asarray(field.table.normal)
    offset = rates.centroid - field.center
    offset = np.linalg.norm(offset - (offset @ up)[:, None] * up, axis=1)
    touched = rates.fingers > 0
    centered = np.exp(-((offset / settings.center_scale_m) ** 2) / 2) * touched
    fingers = np.clip(rates.fingers / settings.enough_fingers, 0, 1)
    held = fingers * (0.3 + 0.7 * rates.opposed)
    nearest = tree.query(rates.centroid, k=min(50, len(certainty)))[1].reshape(len(offset), -1)
    certain = 1 - settings.variance_weight * (1 - certainty[nearest].mean(axis=1))
    return np.stack([rates.rate, rates.standard_error, centered, held, certain])
