"""Which rating the scorer uses."""

import dataclasses as dc
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from vh_drake.grasping.closure_rate import PerturbationSettings
from vh_drake.grasping.field import ObjectField, object_field
from vh_drake.grasping.scoring import (
    GraspRating,
    ScoringSettings,
    rate_candidates,
    score_candidates,
)
from vh_drake.hand.model import HandModel
from vh_drake.learning.features import fused_points, scene_fields
from vh_drake.learning.hints import Hints, hints_on_estimate
from vh_drake.learning.labels import (
    LabelSettings,
    guarded_rates,
    nominal_closure,
    nominal_epsilon,
)
from vh_drake.learning.metric import GraspMetric, Prediction, load_metric
from vh_drake.types import Array, Candidates, ContactSet, GraspScores, ObjectView, Surface

Score = Callable[[Candidates, Surface, ObjectView, ContactSet], GraspScores]

_DISTURBED = LabelSettings(min_samples=24, max_samples=100, target_error=0.05)
_LOT = 1e-6  # less than any two measures differ
_PASSES = 8  # of dropout, for the standard error
# Enough to see where the contacts lie and how many fingers touch.
_FEW = PerturbationSettings(min_samples=8, max_samples=8)


def make_scorer(name: str, hand: HandModel, seed: int) -> Score:
    """The scorer of a scenario.

    The shipped metric has learnt with one hand; candidates of any other are rated
    conventionally, whatever the name.

    Args:
        name: "learned", "conventional", or one of BASELINES.
        hand: that shall grasp.
        seed: of every random choice.

    Raises:
        BadInput: the shipped weights are missing or damaged.
    """
    name = scorer_in_use(name, hand)
    if name == "learned":
        return learned_scorer(load_metric(), hand, seed)
    if name in BASELINES:
        return baseline_scorer(name, hand, seed)
    return conventional_scorer(hand, seed)


def scorer_in_use(name: str, hand: HandModel) -> str:
    """What rates the grasps of a hand where a scenario names a scorer.

    Raises:
        BadInput: the shipped weights are missing or damaged.
    """
    foreign = name == "learned" and load_metric().card.get("hand") != hand.description.name
    return "conventional" if foreign else name


def baseline_scorer(name: str, hand: HandModel, seed: int) -> Score:
    """A measure of the grasp on the estimate by itself; the lot decides between equals.

    Args:
        name: "rate", the force-closure rate under disturbances; "epsilon", of the undisturbed
            grasp; "nominal", whether that is force closed (the thesis's conventional metric).
        hand: that shall grasp.
        seed: of disturbances and lots.
    """
    measure = BASELINES[name]

    def score(
        candidates: Candidates, surface: Surface, view: ObjectView, _contacts: ContactSet
    ) -> GraspScores:
        if len(candidates) == 0:
            return GraspScores()
        worth, error = measure(candidates, object_field(surface, view.table), hand, seed)
        lots = np.random.default_rng(seed).random(len(candidates))
        return GraspScores(worth + _LOT * lots, error)

    return score


def _rate(
    candidates: Candidates, estimate: ObjectField, hand: HandModel, seed: int
) -> tuple[Array, Array]:
    rates = guarded_rates(candidates, estimate, hand, _DISTURBED, seed)
    return rates.rate, rates.standard_error


def _epsilon(
    candidates: Candidates, estimate: ObjectField, hand: HandModel, _seed: int
) -> tuple[Array, Array]:
    return nominal_epsilon(candidates, estimate, hand, _DISTURBED), np.zeros(len(candidates))


def _nominal(
    candidates: Candidates, estimate: ObjectField, hand: HandModel, _seed: int
) -> tuple[Array, Array]:
    closed = nominal_closure(candidates, estimate, hand, _DISTURBED)
    return closed.astype(float), np.zeros(len(candidates))


BASELINES: Mapping[
    str, Callable[[Candidates, ObjectField, HandModel, int], tuple[Array, Array]]
] = {"rate": _rate, "epsilon": _epsilon, "nominal": _nominal}


def conventional_scorer(
    hand: HandModel, seed: int, settings: ScoringSettings | None = None
) -> Score:
    """Force-closure rate on the estimate, times physical sense."""
    settings = settings or ScoringSettings()

    def score(
        candidates: Candidates, surface: Surface, view: ObjectView, _contacts: ContactSet
    ) -> GraspScores:
        return score_candidates(candidates, surface, view.table, hand, settings, seed)

    return score


def learned_scorer(
    metric: GraspMetric | Path, hand: HandModel, seed: int, settings: ScoringSettings | None = None
) -> Score:
    """Probability of success by the learned metric, times physical sense.

    Labels come from closing a hand around an object that stands still. How the object lies
    in the hand, how far from its centre of mass and by how many fingers it is held, decides
    in a real lift too; these factors are those of the conventional rating.

    Args:
        metric: or its weights.
        hand: that the metric was trained for.
        seed: of every random choice.
        settings: of the physical sense.

    Raises:
        BadInput: the weights are missing or damaged.
    """
    trained = load_metric(metric) if isinstance(metric, Path) else metric

    def score(
        candidates: Candidates, surface: Surface, view: ObjectView, contacts: ContactSet
    ) -> GraspScores:
        if len(candidates) == 0:
            return GraspScores()
        scene = (candidates, surface, view, contacts)
        return learned_rating(trained, hand, seed, scene, settings).scores()

    return score


@dc.dataclass(frozen=True, eq=False)
class LearnedRating:
    """What the learned score of n candidates is made of."""

    told: Prediction
    hints: Hints
    sense: GraspRating  # its force-closure rate comes from few trials and does not count

    def scores(self) -> GraspScores:
        """Probability of success times physical sense."""
        sense = self.sense.centered * self.sense.held * self.sense.placed
        return GraspScores(self.told.success * sense, self.told.spread * sense)


def learned_rating(
    metric: GraspMetric,
    hand: HandModel,
    seed: int,
    scene: tuple[Candidates, Surface, ObjectView, ContactSet],
    settings: ScoringSettings | None = None,
) -> LearnedRating:
    """The learned metric and the factors of physical sense, one by one; see `learned_scorer`."""
    candidates, surface, view, contacts = scene
    settings = dc.replace(settings or ScoringSettings(), perturbation=_FEW)
    fields = scene_fields(view, contacts, surface)
    estimate = object_field(surface, view.table)
    hints = hints_on_estimate(candidates, estimate, fused_points(view, contacts), hand, seed)
    told = metric.predict(candidates, fields, hints, passes=_PASSES, seed=seed)
    sense = rate_candidates(candidates, surface, view.table, hand, settings, seed)
    return LearnedRating(told, hints, sense)
