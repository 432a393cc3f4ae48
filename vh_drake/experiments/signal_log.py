"""The signals of a trial as a table, for people who plot them or compare robots."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from pydrake.systems.framework import Context, Diagram

from vh_drake.reports import Row, csv_text
from vh_drake.result_files import write_text

# Subdiagram, vector port, and its columns with units; "{}" counts from 1.
_XYZ = ("x", "y", "z")
SIGNALS: tuple[tuple[str, str, tuple[str, ...]], ...] = (
    ("station", "joint_state", ("joint_{}_rad", "joint_{}_rad_per_s")),
    ("station", "commanded_state", ("commanded_joint_{}_rad", "commanded_joint_{}_rad_per_s")),
    (
        "station",
        "hand_velocity",
        (*(f"w_WH_{a}_rad_per_s" for a in _XYZ), *(f"v_WH_{a}_m_per_s" for a in _XYZ)),
    ),
    (
        "station",
        "hand_acceleration",
        (*(f"alpha_WH_{a}_rad_per_s2" for a in _XYZ), *(f"a_WH_{a}_m_per_s2" for a in _XYZ)),
    ),
    (
        "station",
        "wrist_wrench",
        (*(f"wrist_torque_{a}_nm" for a in _XYZ), *(f"wrist_force_{a}_n" for a in _XYZ)),
    ),
    ("station", "motor_fraction", ("motor_{}",)),
    ("decision", "motor_command", ("motor_command_{}",)),
    ("station", "tendon_force", ("tendon_force_{}_n",)),
    ("station", "finger_joints", ("finger_joint_{}_rad",)),
)


class SignalLog:
    """Gathers what goes over the ports between robot and decision, a row a moment.

    Args:
        station: the robot.
        decision: what commands it.
    """

    def __init__(self, station: Diagram, decision: Diagram) -> None:
        self._parts = {"station": station, "decision": decision}
        self.rows: list[Row] = []

    def note(self, root: Context, phase: str) -> None:
        """Add a row.

        Args:
            root: of the diagram that holds both.
            phase: what the robot is about.
        """
        contexts = {n: part.GetMyContextFromRoot(root) for n, part in self._parts.items()}
        row: Row = {"time_s": round(root.get_time(), 6), "phase": phase}
        pose = self._parts["station"].GetOutputPort("hand_pose").Eval(contexts["station"])
        row |= dict(zip((f"p_WH_{a}_m" for a in _XYZ), pose.translation().tolist(), strict=True))
        quaternion = pose.rotation().ToQuaternion().wxyz().tolist()
        row |= dict(zip((f"q_WH_{a}" for a in "wxyz"), quaternion, strict=True))
        for part, port, columns in SIGNALS:
            values = self._parts[part].GetOutputPort(port).Eval(contexts[part])
            row |= _named(columns, np.asarray(values).tolist())
        self.rows.append(row)

    def save(self, path: Path) -> None:
        """Write the rows as CSV.

        Raises:
            VhDrakeError: the file can't be written.
        """
        write_text(path, csv_text(self.rows))


def _named(columns: Sequence[str], values: Sequence[float]) -> Row:
    """Values under their columns; a column with "{}" stands for as many as there are of it."""
    each = len(values) // len(columns)
    names = [column.format(i + 1) for column in columns for i in range(each)]
    return dict(zip(names, values, strict=True))
