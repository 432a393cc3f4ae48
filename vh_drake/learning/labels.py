"""Whether a grasp would hold: its force-closure rate when executed as the robot does it.

The robot comes to a grasp slowly and stops at the first contact (section 4.2.6). So a disturbed
grasp is not lost where the planned pose lies a little inside the object: the hand starts some
centimetres out along its palm, comes on until it touches or has reached the pose, and closes.
"""

import dataclasses as dc
from functools import lru_cache

import numpy as np

from vh_drake.geometry.meshes import Mask
from vh_drake.grasping.closing import Closure, close_hand
from vh_drake.grasping.closure_rate import PerturbationSettings, closure_rates, succession_error
from vh_drake.grasping.epsilon import epsilon_quality
from vh_drake.grasping.field import ObjectField
from vh_drake.grasping.motions import CollectSettings, MotionArrays, motion_of
from vh_drake.grasping.wrench_space import ContactSettings, wrench_matrix
from vh_drake.hand.model import HandModel
from vh_drake.types import Array, Candidates, IntArray

SUCCESS_RATE = 0.8  # above it a grasp counts as successful (section 4.4.2)


@dc.dataclass
class LabelSettings:
    """How grasps are executed and disturbed (section 4.3.2; the thesis gives no numbers)."""

    guarded_m: float = 0.03  # of the approach, along the palm, that a contact ends
    position_std_m: float = 0.005  # per axis
    rotation_std_deg: float = 5.0  # per axis
    min_samples: int = 20
    max_samples: int = 48
    target_error: float = 0.06  # standard error at which sampling may stop
    friction: float = 0.8

    def perturbation(self) -> PerturbationSettings:
        """For `closure_rates`."""
        return PerturbationSettings(
            position_std_m=self.position_std_m,
            rotation_std_deg=self.rotation_std_deg,
            palm_advance_m=self.guarded_m,
            min_samples=self.min_samples,
            max_samples=self.max_samples,
            target_error=self.target_error,
        )


@dc.dataclass(frozen=True, eq=False)
class Rates:
    """Of n candidates."""

    closed: IntArray  # (n,) trials with force closure
    samples: IntArray  # (n,) trials
    fingers: Array  # (n,) mean number of fingers in contact, thumbs left out
    opposed: Array  # (n,) share in which a thumb and something else touch
    centroid: Array  # (n, 3) mean centroid of the contacts [m]

    @property
    def rate(self) -> Array:
        """(n,) share of trials with force closure."""
        share: Array = self.closed / np.maximum(self.samples, 1)
        return share

    @property
    def standard_error(self) -> Array:
        """(n,) by the rule of succession."""
        return succession_error(self.closed.astype(float), self.samples.astype(float))


def guarded_rates(
    candidates: Candidates,
    field: ObjectField,
    hand: HandModel,
    settings: LabelSettings,
    seed: int,
) -> Rates:
    """Force-closure rates of disturbed grasps, each motion by its own; candidates' order.

    Args:
        candidates: poses and motions.
        field: the true object for labels, the estimate for what the robot can know.
        hand: that grasps.
        settings: of execution and disturbance.
        seed: of the disturbances.
    """
    table = np.zeros((len(candidates), 7))
    for name, own, motion in _by_motion(candidates, hand):
        rates = closure_rates(
            hand,
            field,
            motion,
            start_poses(candidates.X_WH[own], hand, settings.guarded_m),
            perturbation=settings.perturbation(),
            contact=ContactSettings(friction=settings.friction),
            seed=seed + len(name),
        )
        columns = (rates.rate, rates.samples, rates.fingers, rates.opposed, rates.centroid)
        table[own] = np.column_stack(columns)
    closed, samples = np.rint(table[:, 0] * table[:, 1]), table[:, 1]
    return Rates(
        closed.astype(np.int64), samples.astype(np.int64), table[:, 2], table[:, 3], table[:, 4:]
    )


def nominal_closure(
    candidates: Candidates, field: ObjectField, hand: HandModel, settings: LabelSettings
) -> Mask:
    """Whether undisturbed grasps are force closed (n,): the thesis's conventional metric."""
    undisturbed = dc.replace(
        settings, position_std_m=0.0, rotation_std_deg=0.0, min_samples=1, max_samples=1
    )
    return guarded_rates(candidates, field, hand, undisturbed, 0).closed > 0


def nominal_epsilon(
    candidates: Candidates, field: ObjectField, hand: HandModel, settings: LabelSettings
) -> Array:
    """Epsilon quality (n,) of undisturbed grasps; 0 without force closure."""
    contact = ContactSettings(friction=settings.friction)
    epsilon = np.zeros(len(candidates))
    for i, closure in enumerate(nominal_closures(candidates, field, hand, settings)):
        if len(closure.links) >= 3:
            W = wrench_matrix(
                closure.p_WC,
                closure.n_WC,
                center=field.center,
                size_m=field.size_m,
                settings=contact,
            )
            epsilon[i] = epsilon_quality(W)
    return epsilon


def nominal_closures(
    candidates: Candidates, field: ObjectField, hand: HandModel, settings: LabelSettings
) -> list[Closure]:
    """How each undisturbed grasp ends."""
    starts = start_poses(candidates.X_WH, hand, settings.guarded_m)
    return [
        close_hand(hand, field, _motion(name, hand), X_WH, palm_advance_m=settings.guarded_m)
        for name, X_WH in zip(candidates.motion, starts, strict=True)
    ]


def start_poses(X_WH: Array, hand: HandModel, guarded_m: float) -> Array:
    """Poses (n, 4, 4) drawn back against the palm's direction."""
    palm = np.asarray(hand.description.palm) / np.linalg.norm(hand.description.palm)
    starts = X_WH.copy()
    starts[:, :3, 3] -= guarded_m * (X_WH[:, :3, :3] @ palm)
    return starts


def _by_motion(candidates: Candidates, hand: HandModel) -> list[tuple[str, Mask, MotionArrays]]:
    """Each motion's name, whose candidates are its own (n,), and the motion."""
    names = np.array(candidates.motion)
    return [(str(name), names == name, _motion(str(name), hand)) for name in np.unique(names)]


@lru_cache(maxsize=8)
def _motion(name: str, hand: HandModel) -> MotionArrays:
    return motion_of(name, hand, CollectSettings())
