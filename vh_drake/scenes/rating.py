"""Which rating the scorer uses."""

from collections.abc import Callable

from vh_drake.grasping.scoring import ScoringSettings, score_candidates
from vh_drake.hand.model import HandModel
from vh_drake.types import Candidates, GraspScores, ObjectView, Surface

Score = Callable[[Candidates, Surface, ObjectView], GraspScores]


def conventional_scorer(
    hand: HandModel, seed: int, settings: ScoringSettings | None = None
) -> Score:
    """Force-closure rate on the estimate, times physical sense."""
    settings = settings or ScoringSettings()

    def score(candidates: Candidates, surface: Surface, view: ObjectView) -> GraspScores:
        return score_candidates(candidates, surface, view.table, hand, settings, seed)

    return score
