"""The ways to explore that tables compare, by name.

A new one gets an entry in `CONTENDERS`: a function that explores a subject once and gives its
numbers. Names in `DEFAULT` run where the user chooses none. What shall be compared with IGEF as
<name>_over_igef_mean_ratio also gets an entry in `BEYOND`.
"""

import dataclasses as dc
from collections.abc import Callable, Mapping
from functools import cache, partial
from pathlib import Path

from vh_drake.errors import UnknownName
from vh_drake.experiments.hand_closing import planned_hand, true_closer
from vh_drake.exploration.explorer import ExplorerSettings
from vh_drake.exploration.knowing_strategy import explore_rating_truth
from vh_drake.exploration.loop import Body, Exploration, explore, make_body
from vh_drake.exploration.measures import measure
from vh_drake.exploration.shortest_way import Sites, explore_knowing, make_sites
from vh_drake.exploration.tuned import IGEF_KNOWING, RADIUS_M, TUNED, tuned
from vh_drake.exploration.whole_hand import Closer, Hand, explore_by_hand
from vh_drake.hand.description import load_hand
from vh_drake.hand.model import HandModel, read_hand_model
from vh_drake.hand.shipped import hand_file
from vh_drake.objects.loading import load_object
from vh_drake.objects.model import ObjectModel
from vh_drake.reports import Row

_DIGITS = 4


@dc.dataclass(frozen=True, eq=False)
class Subject:
    """An object that is explored."""

    model: ObjectModel
    body: Body


@cache
def subject(name: str, folder: str) -> Subject:
    """An object of a folder, or of the embedded library where the folder is empty."""
    model = load_object(name, folder=Path(folder) if folder else None)
    return Subject(model, make_body(model.mesh, model.com))


# Explores a subject from a seed; the numbers are named as the fields of `Measures`.
Contender = Callable[[Subject, int], Row]


def by_strategy(
    subject: Subject, seed: int, *, strategy: str, candidate_radius_m: float | None = None
) -> Row:
    """One exploration by the fingertip alone."""
    settings = tuned(strategy, candidate_radius_m=candidate_radius_m)
    return _numbers(explore(subject.body, settings, seed=seed), subject, settings)


def _numbers(result: Exploration, subject: Subject, settings: ExplorerSettings) -> Row:
    measures = measure(result, subject.body, settings)
    return {
        name: round(value, _DIGITS) if isinstance(value, float) else value
        for name, value in dc.asdict(measures).items()
    }


@cache
def _sites(subject: Subject) -> Sites:
    return make_sites(subject.body, subject.model.mesh)


def by_shortest_way(subject: Subject, seed: int) -> Row:
    """One exploration by the fingertip on a way that was planned on the true object."""
    settings = tuned("igef")  # for fingertip and estimate; the strategy is not asked
    result = explore_knowing(subject.body, _sites(subject), settings, seed=seed)
    return _numbers(result, subject, settings)


def by_igef_knowing(subject: Subject, seed: int) -> Row:
    """One exploration by IGEF that rates the true surface."""
    result = explore_rating_truth(subject.body, _sites(subject), IGEF_KNOWING, seed=seed)
    return _numbers(result, subject, IGEF_KNOWING)


@cache
def _hand() -> tuple[HandModel, Hand]:
    """The right hand of ARMAR-6, and how it plans closings."""
    model = read_hand_model(load_hand(hand_file()))
    return model, planned_hand(model)


@cache
def _closer(subject: Subject) -> Closer:
    return true_closer(_hand()[0], subject.model.mesh)


def by_whole_hand(subject: Subject, seed: int) -> Row:
    """One exploration by closings of a hand; it costs hand motions, the first touch among them."""
    settings = tuned("igef")
    result = explore_by_hand(subject.body, _closer(subject), _hand()[1], settings, seed=seed)
    closings = sum(motion.closing for motion in result.motions)
    touched = sum(motion.contacts for motion in result.motions if motion.closing)
    return {
        "end": result.end,
        "explored_share": round(result.share, _DIGITS),
        "motions": 1 + len(result.motions),
        "closings": closings,
        "contacts_per_closing": round(touched / max(closings, 1), _DIGITS),
        "contacts": len(result.known.contacts),
    }


# Know the object, as no strategy does: what could be saved at most, and what without looking ahead.
KNOWING: Mapping[str, Contender] = {
    "shortest_way": by_shortest_way,
    "igef_knowing": by_igef_knowing,
}
EQUAL_RADIUS = "_equal_radius"  # candidates within R_0 of the last contact, as for IGEF and chance

CONTENDERS: Mapping[str, Contender] = {
    **{name: partial(by_strategy, strategy=name) for name in TUNED},
    f"gp_variance{EQUAL_RADIUS}": partial(
        by_strategy, strategy="gp_variance", candidate_radius_m=RADIUS_M
    ),
    "whole_hand": by_whole_hand,
    **KNOWING,
}

DEFAULT = ("igef", "gp_variance", "random", f"gp_variance{EQUAL_RADIUS}", "lookahead", "whole_hand")

# What a contender costs, and the same of IGEF: metrics of their rows.
BEYOND: Mapping[str, tuple[str, str]] = {
    "lookahead": ("distance_cm", "distance_cm"),
    "whole_hand": ("motions", "contacts"),  # with one finger every contact is a motion
}


def chosen_contenders(names: str | None) -> tuple[str, ...]:
    """Names from a comma-separated list; None is `DEFAULT`, "all" all there are.

    Raises:
        UnknownName: a name is no contender; the message lists them.
    """
    if names is None:
        return DEFAULT
    chosen = list(CONTENDERS) if names == "all" else [name.strip() for name in names.split(",")]
    for name in chosen:
        if name not in CONTENDERS:
            raise UnknownName("strategy", name, ["all", *CONTENDERS])
    return tuple(dict.fromkeys(chosen))
