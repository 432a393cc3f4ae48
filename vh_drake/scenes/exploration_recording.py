"""An exploration in Meshcat: the estimate grows touch by touch.

Meshcat can't record a changing mesh, so that each step has a path of its own, which is visible for
its time only.
"""

from pathlib import Path

import numpy as np
from pydrake.geometry import Meshcat, Rgba

from vh_drake.exploration.explorer import ExplorerSettings, Known
from vh_drake.exploration.loop import Exploration, Touch
from vh_drake.exploration.trajectory import position
from vh_drake.geometry.colors import variance_colors
from vh_drake.geometry.glyphs import ColorMesh, arrows, balls, joined, tube
from vh_drake.geometry.meshes import TriMesh
from vh_drake.gpis.following import follow_surface
from vh_drake.scenes.recording import start_recording, write_recording
from vh_drake.scenes.showing import make_meshcat
from vh_drake.types import Array, ContactSet

STEP_S = 0.8
_MARGIN_M = 0.01
_BLUE, _RED = np.array([0.1, 0.25, 0.8]), np.array([0.85, 0.1, 0.1])
_OBJECT = Rgba(0.95, 0.8, 0.2, 0.35)
_PER_CURVE = 12


def record_exploration(
    result: Exploration, truth: TriMesh, settings: ExplorerSettings, path: Path
) -> Path:
    """Write a recording that opens in any browser without a server.

    The object is yellow glass; the estimate is dark where it is known and yellow where it is
    guessed; contacts with normals are red, and the fingertip's last way is a blue tube.

    Raises:
        TooLarge: the recording would be larger than 25 MB.
        OSError: the file can't be written.
    """
    meshcat = make_meshcat()
    show_object(meshcat, truth)
    start_recording(meshcat)
    known = [result.start, *(step.known for step in result.steps)]
    ways: list[Touch | None] = [None, *(step.touch for step in result.steps)]
    for i, (now, touch) in enumerate(zip(known, ways, strict=True)):
        _draw(meshcat, f"step/{i}", now, touch, settings)
        _show(meshcat, f"step/{i}", i, last=i == len(known) - 1)
    return write_recording(meshcat, path)


def show_object(meshcat: Meshcat, truth: TriMesh) -> None:
    """The object as yellow glass, and the camera before it."""
    center, size = truth.bounds.mean(axis=0), truth.diagonal
    meshcat.SetCameraPose(center + size * np.array([1.1, -1.3, 0.8]), center)
    _put(meshcat, "object", truth, _OBJECT)


def show_step(
    meshcat: Meshcat, number: int, known: Known, touch: Touch | None, settings: ExplorerSettings
) -> None:
    """Draw a step on a live page, colours as in a recording, and hide the one before.

    Args:
        meshcat: the page.
        number: of the step; 0 is the first contact.
        known: after it.
        touch: that led to it; None for the first contact.
        settings: of the explorer.
    """
    _draw(meshcat, f"step/{number}", known, touch, settings)
    if number:
        meshcat.SetProperty(f"step/{number - 1}", "visible", False)


def step_meshes(
    known: Known, touch: Touch | None, settings: ExplorerSettings
) -> dict[str, ColorMesh]:
    """What is drawn of a step: the estimate, the contacts, and the last way."""
    p = known.contacts.p_WC
    sheet = follow_surface(known.posterior, p, spacing_m=settings.spacing_m, margin_m=_MARGIN_M)
    colors = variance_colors(known.posterior.variance(sheet.vertices))
    meshes = {
        "estimate": ColorMesh(sheet.vertices, sheet.faces, colors),
        "contacts": _contacts(known.contacts),
    }
    if touch is not None:
        meshes["way"] = tube(_way(touch), _BLUE, radius=0.0007)
    return meshes


def _contacts(contacts: ContactSet) -> ColorMesh:
    colors = np.tile(_RED, (len(contacts), 1))
    normals = arrows(contacts.p_WC, contacts.n_WC, colors, length=0.01, radius=0.0005)
    return joined([balls(contacts.p_WC, colors, radius=0.0018), normals])


def _way(touch: Touch) -> Array:
    """Points (n, 3) of the fingertip's centre on its way to a contact."""
    ends = [1.0] * (len(touch.curves) - 1) + [touch.tau]
    return np.array(
        [
            position(curve, float(tau))
            for curve, end in zip(touch.curves, ends, strict=True)
            for tau in np.linspace(0.0, end, _PER_CURVE)
        ]
    )


def _draw(
    meshcat: Meshcat, path: str, known: Known, touch: Touch | None, settings: ExplorerSettings
) -> None:
    for name, mesh in step_meshes(known, touch, settings).items():
        if len(mesh.faces):
            meshcat.SetTriangleColorMesh(
                f"{path}/{name}",
                np.asfortranarray(mesh.vertices.T),
                np.asfortranarray(mesh.faces.T.astype(np.int32)),
                np.asfortranarray(mesh.colors.T),
            )


def _put(meshcat: Meshcat, path: str, mesh: TriMesh, color: Rgba) -> None:
    meshcat.SetTriangleMesh(
        path,
        np.asfortranarray(mesh.vertices.T),
        np.asfortranarray(mesh.faces.T.astype(np.int32)),
        color,
    )


def _show(meshcat: Meshcat, path: str, number: int, *, last: bool) -> None:
    """Visible from its step on until the next one."""
    meshcat.SetProperty(path, "visible", number == 0, time_in_recording=0.0)
    meshcat.SetProperty(path, "visible", True, time_in_recording=number * STEP_S)
    meshcat.SetProperty(path, "visible", last, time_in_recording=(number + 1) * STEP_S)
