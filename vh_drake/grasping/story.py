"""What a behaviour lived through; the stuff that reports are made of."""

import dataclasses as dc

import numpy as np

from vh_drake.types import Array, Immutable, TouchPlan


@dc.dataclass(frozen=True, eq=False)
class TouchRecord(Immutable):
    """One touch: what was planned and what was felt."""

    plan: TouchPlan
    felt: bool  # False: the finger found nothing
    time_s: float  # simulated time of the end of the touch
    p_WC: Array = dc.field(default_factory=lambda: np.full(3, np.nan))  # felt position [m]
    n_WC: Array = dc.field(default_factory=lambda: np.full(3, np.nan))  # felt outward normal
    view_shift: Array = dc.field(default_factory=lambda: np.zeros(3))  # that it told of [m]


@dc.dataclass(frozen=True, eq=False)
class GraspRecord(Immutable):
    """One grasp that was tried."""

    X_WH: Array  # (4, 4) hand pose in which the closing starts
    motion: str
    planner: str
    score: float
    rank: int  # how many better rated candidates the arm could not reach
    candidates: dict[str, int]  # number by planner
    held: bool | None = None  # what the robot feels; None while it tries
    weight_n: float = 0.0  # that the wrist felt at the end


@dc.dataclass(frozen=True, eq=False)
class Story(Immutable):
    """The behaviour so far."""

    phase: str = "look"
    touches: tuple[TouchRecord, ...] = ()
    grasps: tuple[GraspRecord, ...] = ()
    finished: bool = False
    failure: str = ""  # why it gave up; empty while running and after a tried grasp

    def with_outcome(self, *, held: bool, weight_n: float) -> "Story":
        """The story after its last grasp."""
        last = dc.replace(self.grasps[-1], held=held, weight_n=weight_n)
        return dc.replace(self, grasps=(*self.grasps[:-1], last))
