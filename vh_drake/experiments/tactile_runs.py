"""Simulated touches of the tactile normal sensor, and its readings of them for many seeds."""

import dataclasses as dc
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from vh_drake.geometry.meshes import Mask
from vh_drake.scenes.tactile_touch import (
    PAD_M,
    make_tactile_touch,
    plate_rotation,
    press_heights,
    record_touch,
)
from vh_drake.sensing.tactile import TactileSensor, TactileSettings
from vh_drake.types import Array

LIFT_M, PRESS_S, REST_S = 0.006, 0.8, 0.2
CONTACT_N = 0.05  # force above which the pad truly touches


@dc.dataclass(frozen=True, eq=False)
class Motion:
    """What the sensor went through, one row a period."""

    time_s: Array  # (n,)
    force_n: Array  # (n,)
    R_WS: Array  # (n, 3, 3)
    acceleration_m_s2: Array  # (n,)
    n_WPlate: Array  # (3,) outward normal of the plate


@dc.dataclass(frozen=True, eq=False)
class Readings:
    """What the sensor says, one row a period."""

    pressure_pa: Array  # (n,)
    filtered_pa: Array  # (n,)
    contact: Mask  # (n,)
    R_WS: Array  # (n, 3, 3)
    normal_W: Array  # (n, 3) zero before the first surface


def simulate(task: dict[str, Any]) -> dict[str, Any]:
    """Physics of some touches on one plate; takes and returns what JSON can hold.

    Args:
        task: `tilt_deg`, `heading_deg` and `friction` of the plate, `depths_mm` of the touches,
            and the `rest_s` between them.
    """
    tilt, heading = np.deg2rad(task["tilt_deg"]), np.deg2rad(task["heading_deg"])
    heights = press_heights(
        1e-3 * np.array(task["depths_mm"]),
        lift_m=LIFT_M + 0.7 * PAD_M * float(np.tan(tilt)),
        press_s=PRESS_S,
        rest_s=task["rest_s"],
    )
    touch = make_tactile_touch(
        heights, tilt_rad=tilt, heading_rad=heading, friction=task["friction"]
    )
    record = record_touch(touch, heights[0, -1])
    return {
        "time_s": np.round(record.time_s, 6).tolist(),
        "force_n": np.round(record.force_n, 9).tolist(),
        "turn_rad": np.round(Rotation.from_matrix(record.R_WS).as_rotvec(), 9).tolist(),
        "acceleration_m_s2": np.round(record.acceleration_m_s2, 9).tolist(),
        "n_WPlate": plate_rotation(tilt, heading).matrix()[:, 2].tolist(),
    }


def motion_of(result: dict[str, Any]) -> Motion:
    """The arrays of a simulated result."""
    return Motion(
        np.array(result["time_s"]),
        np.array(result["force_n"]),
        Rotation.from_rotvec(result["turn_rad"]).as_matrix(),
        np.array(result["acceleration_m_s2"]),
        np.array(result["n_WPlate"]),
    )


def read(motion: Motion, settings: TactileSettings, seed: int) -> Readings:
    """What the sensor says of a motion; the noise is that of the LeafSystem with this seed."""
    sensor = TactileSensor(settings)
    state = sensor.start(np.eye(3), np.random.default_rng([seed, 0]))
    states = []
    for k in range(len(motion.time_s)):
        rng = np.random.default_rng([seed, k + 1])
        state = sensor.step(state, motion.force_n[k], motion.R_WS[k], rng)
        states.append(state)
    return Readings(
        np.array([s.element.reading_pa for s in states]),
        np.array([s.detection.filtered_pa for s in states]),
        np.array([s.detection.contact for s in states]),
        np.array([s.R_WS for s in states]),
        np.array([s.normal_W for s in states]),
    )


def intervals(flags: Mask) -> list[tuple[int, int]]:
    """First index and index after the last of each run of true values (n,)."""
    edges = np.diff(np.concatenate([[0], flags.astype(int), [0]]))
    return [
        (int(a), int(b))
        for a, b in zip(np.flatnonzero(edges == 1), np.flatnonzero(edges == -1), strict=True)
    ]


def angle_deg(a: Array, b: Array) -> float:
    """Angle between two unit vectors."""
    return float(np.rad2deg(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b)))
