"""The coordinated grasp trajectory of figure 4.20: key points in a file, fit to an object's size.

While fingers and thumb close, the hand turns so that their tips stay at a height over the table;
then it presses, encloses the object, and lifts it. A file holds the columns of figure 4.20:
fingers, thumb, and where the hand goes with them. A wider object meets the fingers earlier, so
they, and the hand with them, go only a share of that way in the same time; the share is the one
at which the tips are as far apart as the object is wide.

Unlike the motion of whole trials (`vh_drake.grasping.motions`), which follows the fingers'
measured travel, this one runs with the clock, as in the thesis.
"""

import dataclasses as dc
import math
from pathlib import Path

import numpy as np
from scipy.optimize import brentq

from vh_drake.errors import BadInput, UnknownName
from vh_drake.geometry.model_files import models_folder
from vh_drake.hand.description import MOST_PROBLEMS
from vh_drake.hand.key_points import KeyPoint, KeyPointTrajectory
from vh_drake.hand.model import HandModel
from vh_drake.types import Array
from vh_drake.yaml_files import load_typed

APPROACHES = ("top", "side")
_LEAST_SHARE = 0.1  # of the way that the hand gathers, however wide the object is


@dc.dataclass
class GraspPoint:
    """Where hand and fingers are at one key point, counted from the initial one."""

    fingers: float = 0.0  # share of their motors' travel
    thumb: float = 0.0
    # Of the power TCP: along the open fingers, and up [m]; and how far the fingers turn down.
    forward_m: float = 0.0
    up_m: float = 0.0
    pitch_deg: float = 0.0
    press_m: float = 0.0  # below that height
    lift_m: float = 0.0  # above it


@dc.dataclass
class CoordinatedGrasp:
    """Key points at even times; the initial one, at rest and open, is left out."""

    name: str = ""
    approach: str = ""  # of the hand: from the "top" or the "side"
    spacing_s: float = 0.5
    key_points: list[GraspPoint] = dc.field(default_factory=list)

    @property
    def gathered(self) -> int:
        """Number of key points, the initial one included, before fingers and thumb enclose."""
        return 1 + sum(point.fingers < 1.0 for point in self.key_points)


def shipped_grasp(approach: str) -> CoordinatedGrasp:
    """The trajectory for the hand of ARMAR-6 from the "top" or the "side".

    Raises:
        UnknownName: another approach.
    """
    if approach not in APPROACHES:
        raise UnknownName("approach", approach, list(APPROACHES))
    file = models_folder() / "trajectories" / f"coordinated_{approach}.yaml"
    return load_coordinated_grasp(file)


def load_coordinated_grasp(path: str | Path) -> CoordinatedGrasp:
    """Reads a trajectory and checks it.

    Args:
        path: YAML file in the schema of `CoordinatedGrasp`.

    Raises:
        BadInput: the file is missing, malformed, or holds what no hand can follow.
    """
    grasp = load_typed(CoordinatedGrasp, path)
    problems = _problems(grasp)
    if problems:
        raise BadInput(f"{path}: " + "; ".join(problems[:MOST_PROBLEMS]))
    return grasp


def _problems(grasp: CoordinatedGrasp) -> list[str]:
    points = grasp.key_points
    ranges = {
        "fingers": (0.0, 1.0),
        "thumb": (0.0, 1.0),
        "forward_m": (-0.5, 0.5),
        "up_m": (-0.5, 0.5),
        "pitch_deg": (-90.0, 90.0),
        "press_m": (0.0, 0.05),
        "lift_m": (0.0, 1.0),
    }
    problems = [
        f"key point {i}: {name} is {getattr(point, name):g}, but must be from {low:g} to {high:g}"
        for i, point in enumerate(points, start=1)
        for name, (low, high) in ranges.items()
        if not low <= getattr(point, name) <= high  # NaN fails both comparisons.
    ]
    if grasp.approach not in APPROACHES:
        problems.append(f"approach {grasp.approach[:80]!r} must be {' or '.join(APPROACHES)}")
    if not (math.isfinite(grasp.spacing_s) and grasp.spacing_s > 0.0):
        problems.append(f"spacing_s is {grasp.spacing_s:g}, but must be positive")
    if not 2 <= grasp.gathered <= len(points):
        problems.append("the fingers must gather first (below 1) and then enclose (1)")
    elif any(point.fingers < 1.0 for point in points[grasp.gathered - 1 :]):
        problems.append("once the fingers enclose (1) they must not open again")
    return problems


def key_points_for(
    grasp: CoordinatedGrasp, hand: HandModel, size_m: float | None = None
) -> KeyPointTrajectory:
    """The trajectory for an object.

    Args:
        grasp: columns of figure 4.20.
        hand: that closes.
        size_m: width of the object between fingertips and thumb; None, or one that the
            gathering fingers don't meet, takes the columns as they are.

    Raises:
        BadInput: the size is not positive.
    """
    if size_m is not None and not size_m > 0.0:
        raise BadInput(f"the object's size is {size_m:g} m; give its width, a positive number")
    columns = np.array([dc.astuple(point) for point in [GraspPoint(), *grasp.key_points]])
    share = 1.0 if size_m is None else _gathered_share(columns, grasp, hand, size_m)
    stations = np.arange(len(columns), dtype=float)
    last = grasp.gathered - 1
    # While it gathers the hand goes a share of the way; from there it encloses and lifts.
    way = np.where(stations <= last, share * stations, stations)
    rows = np.column_stack([np.interp(way, stations, column) for column in columns.T])
    rows[:, 5:] = columns[:, 5:]  # It presses and lifts by the clock, not by the way.
    rows[last:, 2:5] = rows[last, 2:5]
    points = [
        KeyPoint.from_values(
            grasp.spacing_s * i,
            [row[0], row[1], row[2], 0.0, row[3] - row[5] + row[6], 0.0, row[4], 0.0],
        )
        for i, row in enumerate(rows)
    ]
    return KeyPointTrajectory(grasp.name, points)


def _gathered_share(
    columns: Array, grasp: CoordinatedGrasp, hand: HandModel, size_m: float
) -> float:
    """The share (0, 1] of the gathering way after which the tips are `size_m` apart."""
    stations = np.arange(len(columns), dtype=float)

    def too_wide(share: float) -> float:
        at = share * (grasp.gathered - 1)
        fingers, thumb = (float(np.interp(at, stations, columns[:, i])) for i in (0, 1))
        return tip_gap(hand, fingers, thumb) - size_m

    if too_wide(1.0) >= 0.0:
        return 1.0
    if too_wide(_LEAST_SHARE) <= 0.0:
        return _LEAST_SHARE
    return float(brentq(too_wide, _LEAST_SHARE, 1.0, xtol=1e-9))


def tip_gap(hand: HandModel, fingers: float, thumb: float) -> float:
    """Free distance between the fingertips, on average, and the thumbs' tips [m]."""
    angles = hand.joint_angles(hand.motor_fractions(fingers, thumb))
    tips, radii = hand.tips(angles), hand.arrays.sphere_radius[hand.tip_spheres]
    opposing = hand.opposing == 1
    between = tips[~opposing].mean(axis=0) - tips[opposing].mean(axis=0)
    return float(np.linalg.norm(between) - radii[~opposing].mean() - radii[opposing].mean())
