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
from vh_drake.exploration.loop import Body, explore, make_body
from vh_drake.exploration.measures import measure
from vh_drake.exploration.tuned import RADIUS_M, TUNED, tuned
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
    measures = measure(explore(subject.body, settings, seed=seed), subject.body, settings)
    return {
        name: round(value, _DIGITS) if isinstance(value, float) else value
        for name, value in dc.asdict(measures).items()
    }


EQUAL_RADIUS = "_equal_radius"  # candidates within R_0 of the last contact, as for IGEF and chance

CONTENDERS: Mapping[str, Contender] = {
    **{name: partial(by_strategy, strategy=name) for name in TUNED},
    f"gp_variance{EQUAL_RADIUS}": partial(
        by_strategy, strategy="gp_variance", candidate_radius_m=RADIUS_M
    ),
}

DEFAULT = ("igef", "gp_variance", "random", f"gp_variance{EQUAL_RADIUS}")

# What a contender costs, and the same of IGEF: metrics of their rows.
BEYOND: Mapping[str, tuple[str, str]] = {}


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
