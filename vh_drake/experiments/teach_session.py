"""A hand under instruction: reads the panel, moves the simulated robot, keeps the key points."""

import dataclasses as dc
from collections.abc import Callable
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator

from vh_drake.errors import VhDrakeError
from vh_drake.experiments.teach_panel import (
    FINGER_SLIDERS,
    JOG_BUTTONS,
    TeachPanel,
    Touched,
)
from vh_drake.hand.key_points import KeyPoint, hand_pose, load_key_points, save_key_points
from vh_drake.hand.program import travel_time
from vh_drake.hand.teaching import Teaching
from vh_drake.scenes.teaching import TeachingScene
from vh_drake.types import Array

TICK_S = 0.05
_MOST_APPROACH_S = 8.0
_ARRIVED_M = 0.003
_SETTLE_S = 0.6

Tell = Callable[[str], None]


class TeachSession:
    """One user, one robot, one file.

    Args:
        scene: the simulated robot.
        panel: where the user acts.
        file: that `save` writes and `load` reads.
        tell: takes a line about what happened.
    """

    def __init__(self, scene: TeachingScene, panel: TeachPanel, file: Path, tell: Tell) -> None:
        self._scene, self._panel, self._file, self._tell = scene, panel, file, tell
        self._simulator = Simulator(scene.diagram, scene.context)
        self._tare = 0
        self.X_WH0 = scene.X_WH0
        self.teaching = Teaching()
        self.saved = self.teaching.points
        self._shown: Teaching | None = None
        self._text = ""

    @property
    def time_s(self) -> float:
        """Of the simulation."""
        return float(self._scene.context.get_time())

    @property
    def X_WH_target(self) -> Array:
        """Where the hand shall be now (4, 4)."""
        return hand_pose(self.teaching.target, self._scene.hand.description, self.X_WH0)

    def start(self) -> None:
        """Brings the hand over the object."""
        self._command()
        self._simulator.Initialize()
        while self.time_s < _MOST_APPROACH_S:
            self._simulator.AdvanceTo(self.time_s + TICK_S)
            p_WH = self._pose()[:3, 3]
            if np.linalg.norm(p_WH - self.X_WH0[:3, 3]) < _ARRIVED_M:
                break
        self._simulator.AdvanceTo(self.time_s + _SETTLE_S)
        self._panel.read()  # What was clicked meanwhile was not meant for this place.
        self._say("over the object; jog the hand")

    def tick(self) -> bool:
        """One step of what the user wants; False once they have stopped."""
        touched = self._panel.read()
        self._move_fingers(touched)
        for label in touched.buttons:
            if label == "stop":
                return False
            try:
                self._act(label)
            except VhDrakeError as error:  # A file that can't be read must not end the session.
                self._say(str(error))
        playing = self.teaching.playing_s is not None
        self.teaching = self.teaching.advanced(TICK_S)
        if playing and self.teaching.playing_s is None:
            self._say("played")
        self._command()
        self._simulator.AdvanceTo(self.time_s + TICK_S)
        self._feel()
        self._show()
        return True

    def save(self, file: Path) -> None:
        """Writes the key points.

        Raises:
            BadInput: there are none.
            VhDrakeError: the file can't be written.
        """
        save_key_points(file, self.teaching.trajectory(file.stem))
        self.saved = self.teaching.points

    def load(self) -> None:
        """Reads the key points; the hand's target is the start that they count from.

        Raises:
            BadInput: the file is missing or unusable.
        """
        trajectory = load_key_points(self._file)
        self._root()
        self.teaching = self.teaching.loaded(trajectory)
        self.saved = self.teaching.points

    def _act(self, label: str) -> None:
        if label in JOG_BUTTONS:
            self._jog(label)
            return
        actions: dict[str, Callable[[], str]] = {
            "lower until touch": self._lower,
            "set key point": self._set,
            "delete key point": self._delete,
            "previous key point": lambda: self._go(-1),
            "next key point": lambda: self._go(1),
            "play": self._play,
            "save": self._save,
            "load": self._load,
        }
        self._say(actions[label]())

    def _jog(self, label: str) -> None:
        name, sense, _ = JOG_BUTTONS[label]
        step = 1e-3 * self._panel.value("step [mm]")
        if name in ("roll", "pitch", "yaw"):
            step = self._panel.value("step [degrees]")
        self.teaching = self.teaching.jogged(name, sense * step)
        self._say(_offset_text(self.teaching.target))

    def _move_fingers(self, touched: Touched) -> None:
        for label, name in FINGER_SLIDERS.items():
            if label in touched.sliders:
                self.teaching = self.teaching.moved(name, touched.sliders[label] / 100.0)

    def _lower(self) -> str:
        self._tare += 1
        self.teaching = self.teaching.lowered()
        return "lowering until the wrist feels something"

    def _set(self) -> str:
        if not self.teaching.points:
            self._root()
        self.teaching = self.teaching.key_point_set(self._panel.value("spacing [s]"))
        return self._where("set")

    def _delete(self) -> str:
        self.teaching = self.teaching.key_point_deleted()
        return self._where("selected")

    def _go(self, by: int) -> str:
        self.teaching = self.teaching.gone(by)
        return self._where("selected")

    def _play(self) -> str:
        first = self.teaching.gone(-len(self.teaching.points)).target
        there = hand_pose(first, self._scene.hand.description, self.X_WH0)
        self.teaching = self.teaching.played(travel_time(self._pose(), there) + 0.5)
        return "playing" if self.teaching.points else "no key points to play"

    def _save(self) -> str:
        self.save(self._file)
        return f"saved in {self._file}"

    def _load(self) -> str:
        self.load()
        return f"{len(self.teaching.points)} key points loaded"

    def _root(self) -> None:
        """The target becomes the start that poses count from."""
        self.X_WH0 = self.X_WH_target
        self.teaching = self.teaching.rooted()

    def _where(self, what: str) -> str:
        if not self.teaching.points:
            return "no key points"
        number, count = self.teaching.selected + 1, len(self.teaching.points)
        time_s = self.teaching.points[self.teaching.selected].time_s
        return f"key point {number} of {count} at {time_s:g} s {what}"

    def _pose(self) -> Array:
        """X_WH (4, 4) as the arm's servos are commanded now."""
        X_WH = self._scene.diagram.GetOutputPort("commanded_pose").Eval(self._scene.context)
        pose: Array = X_WH.GetAsMatrix4()
        return pose

    def _command(self) -> None:
        target = self.teaching.target
        motors = self._scene.hand.motor_fractions(target.fingers, target.thumb)
        down = [0.0, 0.0, -1.0] if self.teaching.lowering else np.zeros(3)
        diagram, context = self._scene.diagram, self._scene.context
        diagram.GetInputPort("target_pose").FixValue(context, RigidTransform(self.X_WH_target))
        diagram.GetInputPort("motor_command").FixValue(context, motors)
        diagram.GetInputPort("tare").FixValue(context, [float(self._tare)])
        diagram.GetInputPort("approach_direction").FixValue(context, down)

    def _feel(self) -> None:
        """A hand that sinks stops where it is once it touches."""
        contact = self._scene.diagram.GetOutputPort("contact").Eval(self._scene.context)[0]
        if self.teaching.lowering and contact > 0:
            above = self._pose()[2, 3] - self.X_WH_target[2, 3]
            self.teaching = self.teaching.touched().jogged("z", float(above))
            self._say("touched")

    def _say(self, text: str) -> None:
        self._text = text
        self._tell(f"{self.time_s:7.2f} s  {text}")
        self._panel.show_text(text if len(text) < 60 else text[:57] + "...")

    def _show(self) -> None:
        """Sliders follow what plays; the path follows the key points."""
        for label, name in FINGER_SLIDERS.items():
            self._panel.show_value(label, 100.0 * getattr(self.teaching.target, name))
        shown = self._shown
        same = shown is not None and shown.points == self.teaching.points
        if shown is None or not same or shown.selected != self.teaching.selected:
            self._panel.show_path(self._path(), self.teaching.selected)
            self._shown = dc.replace(self.teaching)

    def _path(self) -> Array:
        """Where the key points bring the power TCP (n, 3) [m]."""
        description = self._scene.hand.description
        p_HP = np.array(description.tcps["power"])
        poses = [hand_pose(point, description, self.X_WH0) for point in self.teaching.points]
        return np.array([X[:3, :3] @ p_HP + X[:3, 3] for X in poses]).reshape(-1, 3)


def _offset_text(target: KeyPoint) -> str:
    """How far a target is from the start, without what is zero."""
    lengths = zip(("forward", "left", "up"), 1e3 * np.array(target.position_m), strict=True)
    angles = zip(("roll", "pitch", "yaw"), target.rpy_deg, strict=True)
    parts = [f"{name} {value:.4g} mm" for name, value in lengths if abs(value) > 1e-3]
    parts += [f"{name} {value:.4g} deg" for name, value in angles if abs(value) > 1e-3]
    return ", ".join(parts) or "at the start"
