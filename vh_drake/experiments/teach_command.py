"""The command `vh-drake teach`: a page with sliders and buttons, a robot that follows them."""

import time
from collections.abc import Callable
from pathlib import Path

from vh_drake.errors import BadInput
from vh_drake.experiments.grasp_trial import load_trial_object
from vh_drake.experiments.teach_panel import TeachPanel
from vh_drake.experiments.teach_session import TICK_S, TeachSession
from vh_drake.hand.key_points import load_key_points
from vh_drake.scenes.scenario import Scenario
from vh_drake.scenes.showing import make_meshcat
from vh_drake.scenes.teaching import make_teaching_scene

UNSAVED = ".unsaved.yaml"  # takes the place of the file's suffix


def teach(scenario: Scenario, file: Path, *, host: str, tell: Callable[[str], None]) -> None:
    """Serve the page until its `stop` is clicked, or the process is interrupted.

    Key points that were not saved by then go into a file beside the named one.

    Args:
        scenario: what is simulated.
        file: of key points; loaded at the start where it exists.
        host: of the page.
        tell: takes lines for people.

    Raises:
        BadInput: scenario, object, hand or file are unusable.
        VhDrakeError: unsaved key points can't be written.
    """
    model = load_trial_object(scenario)
    if file.is_dir():
        raise BadInput(f"{file} is a folder; name a file for the key points")
    if file.exists():
        load_key_points(file)  # What is wrong with it shows before anything starts.
    meshcat = make_meshcat(host)
    tell(f"teach at {meshcat.web_url()} (Open Controls); the button `stop` ends it")
    panel = TeachPanel(meshcat)
    session = TeachSession(make_teaching_scene(scenario, model, meshcat), panel, file, tell)
    try:
        session.start()
        if file.exists():
            session.load()
            tell(f"{len(session.teaching.points)} key points from {file}")
        run(session)
    finally:
        _keep(session, file, tell)
        panel.close()


def run(session: TeachSession) -> None:
    """Ticks, at most as fast as the clock, until the user has stopped."""
    began, start_s = time.perf_counter(), session.time_s
    while session.tick():
        ahead = session.time_s - start_s - (time.perf_counter() - began)
        if ahead > 0:
            time.sleep(ahead)
        elif ahead < -TICK_S:  # What was lost is not made up for.
            began, start_s = time.perf_counter(), session.time_s


def _keep(session: TeachSession, file: Path, tell: Callable[[str], None]) -> None:
    if session.teaching.points and session.teaching.points != session.saved:
        other = file.with_suffix(UNSAVED)
        session.save(other)
        tell(f"unsaved key points are in {other}")
