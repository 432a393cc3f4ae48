"""The command `vh-drake explore`: one object, explored by touch until enough of it is known."""

import dataclasses as dc
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from vh_drake.errors import BadInput
from vh_drake.experiments.exploration_pictures import draw_mesh, draw_progress, draw_way, set_view
from vh_drake.experiments.figure_files import save_figure
from vh_drake.exploration.explorer import ExplorerSettings
from vh_drake.exploration.loop import EndSettings, Exploration, Step, explore, make_body
from vh_drake.exploration.measures import measure
from vh_drake.exploration.tuned import tuned
from vh_drake.geometry.meshes import TriMesh
from vh_drake.gpis.following import follow_surface
from vh_drake.objects.loading import load_object
from vh_drake.result_files import write_json
from vh_drake.scenes.exploration_recording import record_exploration

_DIGITS = 6
_MARGIN_M = 0.01
_MOST_TOUCHES = 600


@dc.dataclass(frozen=True)
class ExploreRequest:
    """What a user wants explored, and how."""

    object: str  # a name, or a mesh file
    objects: Path | None = None  # a folder in which it is a name
    scale: float = 1.0
    strategy: str = "igef"
    touches: int | None = None  # at most; None until the goal
    goal: float = 0.8  # explored share of the surface
    seed: int = 0


def explore_object(request: ExploreRequest, out: Path, *, record: bool) -> dict[str, Any]:
    """Explores, and writes explore.json, explore.png and, if asked for, recording.html.

    Returns:
        The content of explore.json; the same bytes for the same request.

    Raises:
        BadInput: object, goal, seed or number of touches are unusable.
        UnknownName: no such object or strategy.
        VhDrakeError: the results can't be written.
    """
    _check(request)
    settings = tuned(request.strategy)
    model = load_object(request.object, folder=request.objects, scale=request.scale)
    body = make_body(model.mesh, model.com, explored_radius_m=settings.explored_radius_m)
    most = _MOST_TOUCHES if request.touches is None else request.touches
    result = explore(
        body, settings, EndSettings(goal=request.goal, most_touches=most), seed=request.seed
    )
    report = {
        "object": model.name,
        "object_report": list(model.report),
        "settings": _settings(request, settings),
        **{key: _plain(value) for key, value in dc.asdict(measure(result, body, settings)).items()},
        "reached": result.end == "goal",
        "first_contact": {
            "position_m": _plain(result.start.contacts.p_WC[0]),
            "normal": _plain(result.start.contacts.n_WC[0]),
        },
        "touches": [_touch(step) for step in result.steps],
    }
    write_json(out / "explore.json", report)
    save_figure(out / "explore.png", draw(result, model.mesh, request))
    if record:
        record_exploration(result, model.mesh, settings, out / "recording.html")
    return report


def draw(result: Exploration, truth: TriMesh, request: ExploreRequest) -> Figure:
    """The way around the object, the estimate, and the explored share over the distance."""
    figure = Figure(figsize=(16.0, 5.5), layout="constrained")
    way: Any = figure.add_subplot(1, 3, 1, projection="3d")
    draw_way(way, result, truth, "object (yellow), way (blue), contacts with normals (dark)")
    estimate: Any = figure.add_subplot(1, 3, 2, projection="3d")
    p = result.known.contacts.p_WC
    sheet = follow_surface(result.known.posterior, p, margin_m=_MARGIN_M)
    if len(sheet.faces):
        draw_mesh(estimate, TriMesh(sheet.vertices, sheet.faces), "silver", alpha=1.0)
    estimate.set_title("estimate from the contacts", fontsize=10)
    set_view(estimate, truth)
    progress = figure.add_subplot(1, 3, 3)
    run = (100.0 * result.lengths_m, result.shares)
    draw_progress(progress, {request.strategy: [run]}, goal=request.goal)
    progress.set_title("explored share of the true surface", fontsize=10)
    return figure


def _check(request: ExploreRequest) -> None:
    if not 0 <= request.seed < 2**31:
        raise BadInput(f"--seed is {request.seed}; choose a number from 0 to {2**31 - 1}")
    if request.touches is not None and not 1 <= request.touches <= _MOST_TOUCHES:
        raise BadInput(f"--touches is {request.touches}; choose 1 to {_MOST_TOUCHES}")
    if not 0.0 < request.goal <= 1.0:
        raise BadInput(f"--goal is {request.goal:g}; choose a share above 0 and up to 1")


def _settings(request: ExploreRequest, settings: ExplorerSettings) -> dict[str, Any]:
    asked = {
        name: str(value) if isinstance(value, Path) else value
        for name, value in dc.asdict(request).items()
    }
    return {**asked, "explorer": repr(settings)}


def _touch(step: Step) -> dict[str, Any]:
    touch = step.touch
    return {
        "predicted_position_m": _plain(touch.p_WT),
        "position_m": _plain(touch.p_WC),
        "normal": _plain(touch.n_WC),
        "prediction_error_mm": _plain(1e3 * np.linalg.norm(touch.p_WT - touch.p_WC)),
        "length_cm": _plain(100.0 * touch.length_m),
        "rotation_deg": _plain(np.degrees(touch.turn_rad)),
        "missed": touch.missed,
        "explored_share": _plain(step.coverage.share),
    }


def _plain(value: Any) -> Any:
    """Rounded numbers that JSON can hold; None for what is not a number."""
    if isinstance(value, bool | int | str):
        return value
    if isinstance(value, np.ndarray):
        return np.round(value, _DIGITS).tolist()
    return round(float(value), _DIGITS) if np.isfinite(value) else None
