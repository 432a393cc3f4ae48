r"""Grasp trajectories as key points: hand pose, fingers and thumb over time (section 4.5.4).

Between key points everything is interpolated linearly, as in figure 4.20. Poses count from the
hand's pose at the start, in axes G: z up, x the horizontal direction in which the fingers
point then, y to its left. (Where they point straight up or down, x is where the palm faces.)
With the rotation :math:`R = R_z R_y R_x` of yaw, pitch and roll, and the power TCP P,

.. math:: R_{WH} = R_{WG} R R_{WG}^\top R_{WH_0}, \qquad p_{WP} = p_{WP_0} + R_{WG} p

so a positive pitch lowers the fingertips and turns the hand about a point near its palm.
"""

import dataclasses as dc
import itertools
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from pydrake.common.yaml import yaml_dump_typed
from scipy.spatial.transform import Rotation

from vh_drake.errors import BadInput
from vh_drake.hand.description import MOST_PROBLEMS, HandDescription
from vh_drake.result_files import write_text
from vh_drake.types import Array
from vh_drake.yaml_files import load_typed

MOST_KEY_POINTS = 200
LONGEST_S = 600.0
FARTHEST_M = 2.0
_UPRIGHT = 0.1  # horizontal part of the fingers' direction below which they point up or down


@dc.dataclass
class KeyPoint:
    """Where hand and fingers are at one time."""

    time_s: float = 0.0
    fingers: float = 0.0  # share of their motors' travel: 0 open, 1 closed
    thumb: float = 0.0
    # Of the power TCP from its place at the start, in G: forward, left, up [m].
    position_m: list[float] = dc.field(default_factory=lambda: [0.0, 0.0, 0.0])
    # Roll, pitch and yaw of the hand from its orientation at the start, about the axes of G.
    rpy_deg: list[float] = dc.field(default_factory=lambda: [0.0, 0.0, 0.0])

    def values(self) -> Array:
        """All but the time (8,): fingers, thumb, position [m], roll, pitch, yaw [degrees]."""
        return np.array([self.fingers, self.thumb, *self.position_m, *self.rpy_deg], float)

    @staticmethod
    def from_values(time_s: float, values: Sequence[float] | Array) -> "KeyPoint":
        """The inverse of `values`, rounded to 0.1 µm and 0.1 millidegrees."""
        fingers, thumb, *rest = (round(float(v), 7) + 0.0 for v in values)
        angles = [round(angle, 4) + 0.0 for angle in rest[3:]]
        return KeyPoint(round(float(time_s), 6), fingers, thumb, rest[:3], angles)


@dc.dataclass
class KeyPointTrajectory:
    """Key points in the order of their times."""

    name: str = ""
    key_points: list[KeyPoint] = dc.field(default_factory=list)


def load_key_points(path: str | Path) -> KeyPointTrajectory:
    """Reads a trajectory and checks it.

    Args:
        path: YAML file in the schema of `KeyPointTrajectory`.

    Raises:
        BadInput: the file is missing, malformed, empty, or holds values out of range.
    """
    trajectory = load_typed(KeyPointTrajectory, path)
    try:
        check_key_points(trajectory)
    except BadInput as error:
        raise BadInput(f"{path}: {error}") from error
    return trajectory


def save_key_points(path: Path, trajectory: KeyPointTrajectory) -> None:
    """Writes what `load_key_points` reads.

    Raises:
        BadInput: the trajectory is empty or holds values out of range.
        VhDrakeError: the file can't be written.
    """
    check_key_points(trajectory)
    write_text(path, yaml_dump_typed(trajectory, schema=KeyPointTrajectory))


def check_key_points(trajectory: KeyPointTrajectory) -> None:
    """Refuses what no hand can follow.

    Raises:
        BadInput: no key points or too many, times that do not grow, or values out of range.
    """
    points = trajectory.key_points
    if not 0 < len(points) <= MOST_KEY_POINTS:
        raise BadInput(f"{len(points)} key points; a trajectory has 1 to {MOST_KEY_POINTS}")
    problems = [
        f"key point {i}: {text}" for i, point in enumerate(points) for text in _problems(point)
    ]
    problems += [
        f"key point {i} at {after.time_s:g} s must be later than the one before it, "
        f"{before.time_s:g} s"
        for i, (before, after) in enumerate(itertools.pairwise(points), start=1)
        if after.time_s <= before.time_s
    ]
    if problems:
        raise BadInput("; ".join(problems[:MOST_PROBLEMS]))


def _problems(point: KeyPoint) -> list[str]:
    limits = {
        "time_s": ([point.time_s], 1, 0.0, LONGEST_S),
        "fingers": ([point.fingers], 1, 0.0, 1.0),
        "thumb": ([point.thumb], 1, 0.0, 1.0),
        "position_m": (point.position_m, 3, -FARTHEST_M, FARTHEST_M),
        "rpy_deg": (point.rpy_deg, 3, -180.0, 180.0),
    }
    return [
        f"{name} is {', '.join(f'{v:g}' for v in values[:4])}, but must be {count} "
        f"{'number' if count == 1 else 'numbers'} from {low:g} to {high:g}"
        for name, (values, count, low, high) in limits.items()
        if len(values) != count or not all(math.isfinite(v) and low <= v <= high for v in values)
    ]


def key_point_at(points: Sequence[KeyPoint], time_s: float) -> KeyPoint:
    """The trajectory at a time; before its start and after its end it stands still."""
    times = [point.time_s for point in points]
    rows = np.array([point.values() for point in points])
    return KeyPoint.from_values(time_s, [np.interp(time_s, times, row) for row in rows.T])


def hand_pose(point: KeyPoint, description: HandDescription, X_WH0: Array) -> Array:
    """X_WH (4, 4) of a key point, where the hand was at X_WH0 (4, 4) at the start."""
    R_WG = start_axes(description, X_WH0)
    turn = Rotation.from_euler("xyz", point.rpy_deg, degrees=True).as_matrix()
    p_HP = np.array(description.tcps["power"])
    X_WH = np.eye(4)
    X_WH[:3, :3] = R_WG @ turn @ R_WG.T @ X_WH0[:3, :3]
    p_WP = X_WH0[:3, :3] @ p_HP + X_WH0[:3, 3] + R_WG @ np.array(point.position_m)
    X_WH[:3, 3] = p_WP - X_WH[:3, :3] @ p_HP
    return X_WH


def start_axes(description: HandDescription, X_WH0: Array) -> Array:
    """R_WG (3, 3): forward along the fingers, left, up."""
    forward = X_WH0[:3, :3] @ np.array(description.along)
    if np.linalg.norm(forward[:2]) < _UPRIGHT * np.linalg.norm(forward):
        forward = X_WH0[:3, :3] @ np.array(description.palm)
    x, y = forward[:2] / np.linalg.norm(forward[:2])
    return np.array([[x, -y, 0.0], [y, x, 0.0], [0.0, 0.0, 1.0]])
