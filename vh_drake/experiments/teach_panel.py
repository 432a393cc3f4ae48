"""Sliders and buttons in Meshcat with which a hand is taught, and what they show."""

import dataclasses as dc
from collections.abc import Mapping

import numpy as np
from pydrake.common import MemoryFile
from pydrake.geometry import InMemoryMesh, Mesh, Meshcat
from pydrake.math import RigidTransform

from vh_drake.geometry.billboard import text_billboard
from vh_drake.geometry.glyphs import balls, joined, tube
from vh_drake.scenes.showing import sign_pose
from vh_drake.types import Array

# Label: what it jogs, in which sense, and the key that does the same.
JOG_BUTTONS = {
    "forward": ("x", 1, "ArrowUp"),
    "back": ("x", -1, "ArrowDown"),
    "left": ("y", 1, "ArrowLeft"),
    "right": ("y", -1, "ArrowRight"),
    "up": ("z", 1, "KeyE"),
    "down": ("z", -1, "KeyD"),
    "fingertips up": ("pitch", -1, "KeyI"),
    "fingertips down": ("pitch", 1, "KeyK"),
    "turn left": ("yaw", 1, "KeyJ"),
    "turn right": ("yaw", -1, "KeyL"),
    "roll left": ("roll", -1, "KeyU"),
    "roll right": ("roll", 1, "KeyO"),
}
ACTION_BUTTONS = {
    "lower until touch": "KeyT",
    "set key point": "Enter",
    "delete key point": "Delete",
    "previous key point": "Comma",
    "next key point": "Period",
    "play": "KeyP",
    "save": "",
    "load": "",
    "stop": "",
}
# Label: least, largest, smallest step, first value, and the keys that decrease and increase it.
SLIDERS = {
    "fingers [%]": (0.0, 100.0, 2.0, 0.0, "KeyF", "KeyG"),
    "thumb [%]": (0.0, 100.0, 2.0, 0.0, "KeyV", "KeyB"),
    "step [mm]": (1.0, 20.0, 1.0, 5.0, "", ""),
    "step [degrees]": (1.0, 15.0, 1.0, 3.0, "", ""),
    "spacing [s]": (0.1, 2.0, 0.1, 0.5, "", ""),
}
FINGER_SLIDERS = {"fingers [%]": "fingers", "thumb [%]": "thumb"}
_BLUE, _ORANGE = np.array([0.15, 0.35, 0.85]), np.array([1.0, 0.45, 0.0])
_PATH, _SIGN = "/teach/path", "/teach/sign"
# Over the near corner of the table, where neither the robot nor the controls hide it.
_P_W_SIGN, _SIGN_HEIGHT_M = (0.64, -0.77, 0.97), 0.03


@dc.dataclass(frozen=True)
class Touched:
    """What a user did to the panel since it was read last."""

    buttons: tuple[str, ...] = ()  # labels, once a click
    sliders: Mapping[str, float] = dc.field(default_factory=dict)  # new values of moved ones


class TeachPanel:
    """The controls of one Meshcat, and a sign and a path in its scene.

    Args:
        meshcat: its server must belong to the calling thread.
    """

    def __init__(self, meshcat: Meshcat) -> None:
        self._meshcat = meshcat
        self._clicks = dict.fromkeys((*JOG_BUTTONS, *ACTION_BUTTONS), 0)
        self._values: dict[str, float] = {}
        for label, (low, high, step, first, less, more) in SLIDERS.items():
            self._values[label] = meshcat.AddSlider(label, low, high, step, first, less, more)
        for label, (_, _, key) in JOG_BUTTONS.items():
            meshcat.AddButton(label, key)
        for label, key in ACTION_BUTTONS.items():
            meshcat.AddButton(label, key)
        meshcat.SetTransform(_SIGN, RigidTransform(sign_pose().rotation(), _P_W_SIGN))

    def read(self) -> Touched:
        """What happened since the last call, in the order of the panel."""
        buttons: list[str] = []
        for label, before in self._clicks.items():
            now = self._meshcat.GetButtonClicks(label)
            buttons += [label] * (now - before)
            self._clicks[label] = now
        values = {label: self._meshcat.GetSliderValue(label) for label in SLIDERS}
        moved = {label: v for label, v in values.items() if v != self._values[label]}
        self._values = values
        return Touched(tuple(buttons), moved)

    def value(self, label: str) -> float:
        """Of a slider, as it was read or shown last."""
        return self._values[label]

    def show_value(self, label: str, value: float) -> None:
        """Moves a slider; that is no act of the user."""
        if abs(value - self._values[label]) >= SLIDERS[label][2]:
            self._values[label] = self._meshcat.SetSliderValue(label, value)

    def show_text(self, text: str) -> None:
        """Puts a text on the sign."""
        sign = MemoryFile(text_billboard(text, height_m=_SIGN_HEIGHT_M), ".gltf", "sign")
        self._meshcat.SetObject(_SIGN, Mesh(InMemoryMesh(mesh_file=sign)))

    def show_path(self, p_WP: Array, selected: int) -> None:
        """Draws where key points (n, 3) [m] bring the power TCP, the selected one in orange."""
        if len(p_WP) == 0:
            self._meshcat.Delete(_PATH)
            return
        colors = np.tile(_BLUE, (len(p_WP), 1))
        colors[selected] = _ORANGE
        mesh = joined([balls(p_WP, colors, radius=0.006), tube(p_WP, _BLUE, radius=0.0015)])
        self._meshcat.SetTriangleColorMesh(
            _PATH,
            np.asfortranarray(mesh.vertices.T),
            np.asfortranarray(mesh.faces.T.astype(np.int32)),
            np.asfortranarray(mesh.colors.T),
        )

    def close(self) -> None:
        """Takes the controls off the page."""
        self._meshcat.DeleteAddedControls()
