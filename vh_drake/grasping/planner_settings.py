"""What grasp planners may propose."""

import dataclasses as dc

from vh_drake.errors import BadInput, UnknownName
from vh_drake.grasping.motions import CollectSettings

PLANNERS = ("surface", "skeleton")
APPROACHES = ("collect", "side", "free")


@dc.dataclass
class PlannerSettings:
    """Numbers and limits of both planners.

    There are three approaches. *collect* comes from the top with the line from fingertips to
    thumb parallel to the table, *side* with the palm upright and the thumb up: both held objects
    in simulation, and their offsets are those that did. *free* comes from anywhere, for hands
    without a table below.

    Along is the direction of the fingers, across is to their left as seen from above; both
    count from the object to the power TCP, so that a negative `along` puts the object nearer
    to the fingertips.
    """

    planners: list[str] = dc.field(default_factory=lambda: list(PLANNERS))
    approaches: list[str] = dc.field(default_factory=lambda: ["collect", "side"])
    candidates: int = 800  # of all planners together
    rounds: int = 10  # of drawing until enough candidates are free
    draws: int = 400  # of each planner and approach a round
    least_width_m: float = 0.02
    clearance_m: float = 0.006  # between object and hand before it closes
    collect: CollectSettings = dc.field(default_factory=CollectSettings)
    collect_along_m: list[float] = dc.field(default_factory=lambda: [-0.05, -0.025])
    collect_across_m: list[float] = dc.field(default_factory=lambda: [-0.04, -0.015])
    collect_widest_m: float = 0.12
    collect_tallest_m: float = 0.13
    collect_highest_m: float = 0.03  # how far the hand may rise off its height to be free
    # Of the fingers, down: with level fingers the arm can't come from everywhere.
    side_tilts_deg: list[float] = dc.field(default_factory=lambda: [0.0, 25.0])
    side_along_m: list[float] = dc.field(default_factory=lambda: [-0.06, -0.035])
    side_heights_m: list[float] = dc.field(default_factory=lambda: [0.05, 0.12])
    side_below_top_m: float = 0.05  # of the hand's middle; the thumb is above it
    side_near_center_m: float = 0.03  # of the hand's middle above or below the centre of mass
    side_widest_m: float = 0.11
    side_lowest_m: float = 0.09  # height of objects that are taken from the side
    free_widest_m: float = 0.11
    # Of skeletons: how far a section may leave a straight line, and how long it must be.
    straight_m: float = 0.005
    section_m: float = 0.015


def check_planner_settings(settings: PlannerSettings) -> None:
    """Refuse settings that ask for nothing.

    Raises:
        BadInput: a number is not positive, or a list is empty.
        UnknownName: a planner or approach that does not exist.
    """
    if min(settings.candidates, settings.rounds, settings.draws) < 1:
        raise BadInput("planner settings: candidates, rounds and draws must be positive")
    for kind, names, choices in (
        ("grasp planner", settings.planners, PLANNERS),
        ("approach", settings.approaches, APPROACHES),
    ):
        if not names:
            raise BadInput(f"planner settings name no {kind}; choose of {', '.join(choices)}")
        for name in names:
            if name not in choices:
                raise UnknownName(kind, name[:80], list(choices))
