"""The pictures of the README: one trial, seen at its telling moments.

`python -m vh_drake.experiments.pictures [FOLDER]` writes them into `docs`, or into a folder.
"""

import dataclasses as dc
import io
import sys
import tempfile
from pathlib import Path

import numpy as np
from matplotlib.image import imread, imsave
from pydrake.geometry import Meshcat
from pydrake.systems.analysis import Simulator

from vh_drake.errors import VhDrakeError
from vh_drake.experiments.browser import screenshot
from vh_drake.experiments.grasp_trial import Trial, longest_s, make_trial
from vh_drake.scenes.scenario import Scenario
from vh_drake.scenes.showing import make_meshcat
from vh_drake.types import Array

SIZE = (1000, 750)  # pixels
FOV_Y_DEG = 42.0
MOST_BYTES = 400_000
STEP_S = 0.02
OBJECT_PATH = "/drake/scene/object"
# Meshcat's controls do nothing in a picture.
NO_CONTROLS = "<style>.dg, #stats-plot {display: none !important}</style></head>"


@dc.dataclass(frozen=True)
class Shot:
    """A picture, the moment at which it is taken, and from where."""

    name: str
    phase: str  # the first one that begins so
    after_s: float  # it began
    p_OCamera: tuple[float, float, float]  # from the object, axes as the world's [m]
    p_OTarget: tuple[float, float, float]
    hidden: tuple[str, ...] = ()  # Meshcat paths


ROBOT = ("/drake/scene/armar6", "/drake/scene/right")
SHOTS = (
    Shot(
        "touch",
        "touch: feel",
        0.2,
        (0.42, 0.62, 0.38),
        (-0.02, -0.03, 0.14),
        (OBJECT_PATH, "/phase"),
    ),
    Shot(
        "estimate",
        "plan grasps",
        0.0,
        (0.21, 0.13, 0.16),
        (0.0, 0.0, 0.015),
        (OBJECT_PATH, *ROBOT, "/phase"),
    ),
    Shot(
        "candidates",
        "grasp: ",
        0.1,
        (0.3, -0.26, 0.28),
        (0.0, 0.0, 0.05),
        (OBJECT_PATH, *ROBOT, "/phase", "/cloud"),
    ),
    Shot("lift", "grasp: hold", 1.0, (1.3, -0.95, 0.85), (-0.2, 0.0, 0.36), ("/phase",)),
)


def take_pictures(
    folder: Path, scenario: Scenario | None = None, shots: tuple[Shot, ...] = SHOTS
) -> list[Path]:
    """Runs a trial and writes a picture of each shot.

    Args:
        folder: of the pictures; made where missing.
        scenario: None takes the default with point contact.
        shots: moments and views.

    Returns:
        The files, in the order of `shots`.

    Raises:
        VhDrakeError: the trial never came to one of the moments, or there is no browser.
    """
    folder.mkdir(parents=True, exist_ok=True)
    meshcat = make_meshcat()
    meshcat.SetCamera(Meshcat.PerspectiveCamera(fov=FOV_Y_DEG, aspect=SIZE[0] / SIZE[1]))
    trial = make_trial(scenario or Scenario(contact="point"), meshcat=meshcat)
    with tempfile.TemporaryDirectory() as pages:
        found = _pages(trial, meshcat, shots, Path(pages))
        missing = [shot.name for shot in shots if shot.name not in found]
        if missing:
            raise VhDrakeError(f"the trial ended before the moments of {', '.join(missing)}")
        return [_picture(found[shot.name], folder / f"{shot.name}.jpg") for shot in shots]


def _pages(
    trial: Trial, meshcat: Meshcat, shots: tuple[Shot, ...], folder: Path
) -> dict[str, Path]:
    """A page for each shot whose moment came."""
    simulator = Simulator(trial.diagram, trial.context)
    context = trial.decision.GetMyContextFromRoot(trial.context)
    began: dict[str, float] = {}
    found: dict[str, Path] = {}
    while simulator.get_context().get_time() < longest_s(trial.scenario) and len(found) < len(
        shots
    ):
        now = simulator.get_context().get_time()
        phase = trial.decision.GetOutputPort("phase").Eval(context)
        for shot in shots:
            if phase.startswith(shot.phase):
                since = began.setdefault(shot.name, now)
                if shot.name not in found and now >= since + shot.after_s:
                    trial.diagram.ForcedPublish(trial.context)
                    found[shot.name] = _page(meshcat, shot, trial.X_WO.translation(), folder)
        if trial.decision.GetOutputPort("story").Eval(context).finished:
            break
        simulator.AdvanceTo(now + STEP_S)
    return found


def _page(meshcat: Meshcat, shot: Shot, p_WO: Array, folder: Path) -> Path:
    """The scene as it is now, as a page that needs no server."""
    meshcat.SetCameraPose(p_WO + np.array(shot.p_OCamera), p_WO + np.array(shot.p_OTarget))
    for path in shot.hidden:
        meshcat.SetProperty(path, "visible", False)
    html = meshcat.StaticHtml()
    for path in shot.hidden:
        meshcat.SetProperty(path, "visible", True)
    page = folder / f"{shot.name}.html"
    page.write_text(html.replace("</head>", NO_CONTROLS, 1))
    return page


def _picture(page: Path, path: Path) -> Path:
    """A JPEG of a page, small enough for a README."""
    png = screenshot(page, page.with_suffix(".png"), size=SIZE, budget_s=10.0)
    pixels = np.ascontiguousarray(imread(png)[..., :3])
    for quality in (92, 85, 75, 60):
        data = io.BytesIO()
        imsave(data, pixels, format="jpeg", pil_kwargs={"quality": quality})
        if data.tell() <= MOST_BYTES:
            break
    path.write_bytes(data.getvalue())
    return path


def main() -> None:
    """Writes the README's pictures."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path("docs")
    for path in take_pictures(folder):
        print(path)


if __name__ == "__main__":
    main()
