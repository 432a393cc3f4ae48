"""How often a grasp closes with force closure when its pose is off (Weisz & Allen 2012)."""

import dataclasses as dc

import numpy as np
from numba import njit

from vh_drake.errors import BadInput
from vh_drake.geometry.compiling import bare_njit
from vh_drake.grasping.closing import ClosingState, close_fingers, new_state
from vh_drake.grasping.field import FieldArrays, ObjectField
from vh_drake.grasping.motions import MotionArrays
from vh_drake.grasping.wrench_space import (
    ContactSettings,
    check_contact_settings,
    fill_wrenches,
    spans_positively,
)
from vh_drake.hand.kinematics import HandArrays, copy_pose
from vh_drake.hand.model import HandModel
from vh_drake.types import Array, IntArray


@dc.dataclass
class PerturbationSettings:
    """How a grasp's pose is disturbed, and how many trials are judged."""

    position_std_m: float = 0.005  # per axis
    rotation_std_deg: float = 5.0  # per axis, about the power TCP
    palm_advance_m: float = 0.0  # 0: the hand does not feel its way before closing
    min_samples: int = 24
    max_samples: int = 100
    target_error: float = 0.05  # standard error at which sampling may stop


@dc.dataclass(frozen=True, eq=False)
class ClosureRates:
    """Of n grasps; means are over the trials of a grasp that did not start in collision."""

    rate: Array  # (n,) share of trials with force closure
    standard_error: Array  # (n,) of the rate, by the rule of succession
    samples: IntArray  # (n,) trials
    fingers: Array  # (n,) mean number of fingers in contact, thumbs left out
    opposed: Array  # (n,) share in which a thumb and another finger, or the palm, touch
    centroid: Array  # (n, 3) mean centroid of the contacts [m]


def closure_rates(
    hand: HandModel,
    field: ObjectField,
    motion: MotionArrays,
    X_WH: Array,
    *,
    perturbation: PerturbationSettings,
    contact: ContactSettings,
    seed: int,
) -> ClosureRates:
    """Force-closure rates of grasps X_WH (n, 4, 4) that close with the same motion.

    Every grasp meets the same disturbances, so that differences between grasps are less
    noisy than the rates. A trial that starts in collision counts as failed; the table's
    height is known, so it is no obstacle here.

    Raises:
        BadInput: a setting is out of range.
    """
    _check(perturbation)
    check_contact_settings(contact)
    rng = np.random.default_rng(seed)
    noise = rng.standard_normal((perturbation.max_samples, 6))
    noise[:, :3] *= perturbation.position_std_m
    noise[:, 3:] *= np.deg2rad(perturbation.rotation_std_deg)
    palm = np.asarray(hand.description.palm) / np.linalg.norm(hand.description.palm)
    table = _rate_all(
        hand.arrays,
        field.arrays,
        motion,
        np.ascontiguousarray(X_WH[:, :3], np.float64),
        _link_kinds(hand),
        np.ascontiguousarray(field.center),
        field.size_m,
        np.asarray(hand.description.tcps["power"], np.float64),
        palm,
        noise,
        (perturbation.min_samples, perturbation.target_error, perturbation.palm_advance_m),
        (contact.friction, contact.edges),
    )
    samples, closed, touching = table[:, 0], table[:, 1], np.maximum(table[:, 2], 1)
    return ClosureRates(
        rate=closed / samples,
        standard_error=succession_error(closed, samples),
        samples=samples.astype(np.int64),
        fingers=table[:, 3] / touching,
        opposed=table[:, 4] / touching,
        centroid=table[:, 5:8] / touching[:, None],
    )


def succession_error(successes: Array, samples: Array) -> Array:
    """Standard error of a share, one success and one failure added; never 0."""
    share = (successes + 1) / (samples + 2)
    error: Array = np.sqrt(share * (1 - share) / (samples + 2))
    return error


def _check(settings: PerturbationSettings) -> None:
    if not 0 < settings.min_samples <= settings.max_samples:
        raise BadInput(
            f"perturbation: need 0 < min_samples <= max_samples; got "
            f"{settings.min_samples} and {settings.max_samples}"
        )
    if not min(settings.position_std_m, settings.rotation_std_deg, settings.palm_advance_m) >= 0:
        raise BadInput("perturbation: spreads and palm advance must not be negative")


def _link_kinds(hand: HandModel) -> IntArray:
    """(n + 1,) finger of each link; thumbs count from -2 downwards, the base is -1."""
    finger = hand.finger_of_link
    kinds: IntArray = np.where(hand.thumb_links, -2 - finger, finger)
    return kinds


@njit(cache=True)
def _rate_all(
    hand: HandArrays,
    field: FieldArrays,
    motion: MotionArrays,
    X_WH: Array,
    kinds: IntArray,
    center: Array,
    size: float,
    tcp: Array,
    palm: Array,
    noise: Array,
    sampling: tuple[int, float, float],
    contact: tuple[float, int],
) -> Array:
    """Rows (n, 8): samples, closed, touching, fingers, opposed, centroid; sums over samples."""
    state, pose = new_state(hand), np.empty((3, 4))
    links = len(kinds)
    p, n, rows = np.empty((links, 3)), np.empty((links, 3)), np.empty((links * contact[1], 6))
    result = np.zeros((len(X_WH), 8))
    for grasp in range(len(X_WH)):
        sums = result[grasp]
        for sample in range(len(noise)):
            disturb(X_WH[grasp], tcp, noise[sample], pose)
            sums[0] += 1
            if close_fingers(hand, field, motion, pose, palm, sampling[2], state):
                count = _gather(state, kinds, p, n, sums)
                if count >= 3:
                    fill_wrenches(p[:count], n[:count], center, size, contact[0], contact[1], rows)
                    sums[1] += spans_positively(rows, count * contact[1])
            if sums[0] >= sampling[0]:
                share = (sums[1] + 1) / (sums[0] + 2)
                if share * (1 - share) <= sampling[1] ** 2 * (sums[0] + 2):
                    break
    return result


@bare_njit
def _gather(state: ClosingState, kinds: IntArray, p: Array, n: Array, sums: Array) -> int:
    """Pack the contacts into p and n, add up who touches; returns their number."""
    count, thumbs, fingers, others, previous = 0, 0, 0, 0, -1
    x, y, z = 0.0, 0.0, 0.0
    for link in range(len(kinds)):
        if state.touched[link]:
            for i in range(3):
                p[count, i], n[count, i] = state.p[link, i], state.n[link, i]
            count += 1
            x, y, z = x + state.p[link, 0], y + state.p[link, 1], z + state.p[link, 2]
            thumbs += kinds[link] < -1
            others += kinds[link] >= -1
            if kinds[link] >= 0 and kinds[link] != previous:
                fingers, previous = fingers + 1, kinds[link]
    if count > 0:
        sums[2] += 1
        sums[3] += fingers
        sums[4] += thumbs > 0 and others > 0
        sums[5], sums[6], sums[7] = sums[5] + x / count, sums[6] + y / count, sums[7] + z / count
    return count


@bare_njit
def disturb(X: Array, tcp: Array, noise: Array, result: Array) -> None:
    """Write X, moved by noise[:3] along its axes and turned by noise[3:] at a TCP, to `result`."""
    angle = np.sqrt(noise[3] ** 2 + noise[4] ** 2 + noise[5] ** 2)
    s = np.sin(angle) / angle if angle > 1e-9 else 1.0
    v = (1 - np.cos(angle)) / angle**2 if angle > 1e-9 else 0.5
    a, b, c = noise[3], noise[4], noise[5]
    R = (
        (1 - v * (b * b + c * c), v * a * b - s * c, v * a * c + s * b),
        (v * a * b + s * c, 1 - v * (a * a + c * c), v * b * c - s * a),
        (v * a * c - s * b, v * b * c + s * a, 1 - v * (a * a + b * b)),
    )
    copy_pose(X, result)
    for i in range(3):
        row = (X[i, 0], X[i, 1], X[i, 2])
        for j in range(3):
            result[i, j] = row[0] * R[0][j] + row[1] * R[1][j] + row[2] * R[2][j]
        for j in range(3):
            result[i, 3] += row[j] * (tcp[j] + noise[j]) - result[i, j] * tcp[j]
