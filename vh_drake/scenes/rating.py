"""Which rating the scorer uses."""

import dataclasses as dc
from collections.abc import Callable, Mapping

import numpy as np

from vh_drake.grasping.field import ObjectField, object_field
from vh_drake.grasping.scoring import ScoringSettings, score_candidates
from vh_drake.hand.model import HandModel
from vh_drake.learning.hints import Hints
from vh_drake.learning.knowledge import knowledge
from vh_drake.learning.labels import (
    LabelSettings,
    guarded_rates,
    nominal_closure,
    nominal_epsilon,
)
from vh_drake.learning.lift_inputs import lift_inputs, with_success
from vh_drake.learning.lift_model import (
    LiftModel,
    check_metric,
    lift_model_beside,
    load_lift_model,
)
from vh_drake.learning.metric import GraspMetric, Prediction, load_metric
from vh_drake.types import Array, Candidates, ContactSet, GraspScores, ObjectView, Surface

Score = Callable[[Candidates, Surface, ObjectView, ContactSet], GraspScores]

_DISTURBED = LabelSettings(min_samples=24, max_samples=100, target_error=0.05)
_LOT = 1e-6  # less than any two measures differ
_PASSES = 8  # of dropout, for the standard error


def make_scorer(name: str, hand: HandModel, seed: int, weights: str = "") -> Score:
    """The scorer of a scenario.

    A metric has learnt with one hand; candidates of any other are rated conventionally,
    whatever the name.

    Args:
        name: "learned", "conventional", or one of BASELINES.
        hand: that shall grasp.
        seed: of every random choice.
        weights: file of the learned metric, with its lift model beside it; empty: the shipped.

    Raises:
        BadInput: weights are missing or damaged, or metric and lift model don't belong together.
    """
    name, path = scorer_in_use(name, hand, weights), weights or None
    if name == "learned":
        lift = load_lift_model(lift_model_beside(path))
        return learned_scorer(load_metric(path), lift, hand, seed)
    if name in BASELINES:
        return baseline_scorer(name, hand, seed)
    return conventional_scorer(hand, seed)


def scorer_in_use(name: str, hand: HandModel, weights: str = "") -> str:
    """What rates the grasps of a hand where a scenario names a scorer, and maybe weights.

    Raises:
        BadInput: the weights are missing or damaged.
    """
    if name != "learned":
        return name
    learnt_with = load_metric(weights or None).card.get("hand")
    return "learned" if learnt_with == hand.description.name else "conventional"


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


def learned_scorer(metric: GraspMetric, lift: LiftModel, hand: HandModel, seed: int) -> Score:
    """Probability that the hand lifts the object, by what was learnt.

    The metric foretells whether a grasp closes around an object that stands still. How the
    object lies in the hand and where fingers meet it decides in a lift too; the lift model
    weighs both.

    Args:
        metric: of closing.
        lift: of lifting.
        hand: that both were trained for.
        seed: of every random choice.

    Raises:
        BadInput: the lift model was fitted with another metric.
    """
    check_metric(lift, metric)

    def score(
        candidates: Candidates, surface: Surface, view: ObjectView, contacts: ContactSet
    ) -> GraspScores:
        if len(candidates) == 0:
            return GraspScores()
        scene = (candidates, surface, view, contacts)
        return learned_rating(metric, lift, hand, seed, scene).scores()

    return score


@dc.dataclass(frozen=True, eq=False)
class LearnedRating:
    """What the learned score of n candidates is made of."""

    told: Prediction
    hints: Hints
    lift: Array  # (n,) probability of a lift
    error: Array  # (n,) its standard error

    def scores(self) -> GraspScores:
        """Probability of a lift."""
        return GraspScores(self.lift, self.error)


def learned_rating(
    metric: GraspMetric,
    lift: LiftModel,
    hand: HandModel,
    seed: int,
    scene: tuple[Candidates, Surface, ObjectView, ContactSet],
) -> LearnedRating:
    """What metric and lift model say of candidates, one by one; see `learned_scorer`.

    The standard error has two parts: how little the judges agree, and how far the probability
    moves as dropout moves the metric's word.
    """
    known = knowledge(*scene, hand, seed)
    told = metric.predict(known.candidates, known.fields, known.hints, passes=_PASSES, seed=seed)
    hidden, numbers = lift.hidden(told.seen), lift_inputs(known, hand, told)
    probability, error = lift.rate(hidden, numbers)
    low, high = (
        lift.rate(hidden, with_success(numbers, told.success + moved))[0]
        for moved in (-told.spread, told.spread)
    )
    return LearnedRating(told, known.hints, probability, np.hypot(error, (high - low) / 2))
