"""The command `vh-drake grasp`: a trial with progress, a table, files and pictures."""

import json
import sys
from pathlib import Path

from rich.console import Console
from rich.table import Table

from vh_drake.errors import VhDrakeError
from vh_drake.experiments.grasp_trial import (
    TrialResult,
    load_trial_object,
    raise_failure,
    run_trial,
)
from vh_drake.scenes.scenario import Scenario
from vh_drake.scenes.showing import make_meshcat


def grasp_and_report(
    scenario: Scenario,
    out: Path,
    *,
    host: str | None,
    record: bool,
    as_json: bool,
    log: Path | None = None,
) -> bool:
    """Run a trial, tell people about it, and write its files.

    Args:
        scenario: what is simulated.
        out: folder for result.json, timing.json and recording.html.
        host: of the live page; None for none.
        record: write a recording.
        as_json: print the result alone on standard output.
        log: CSV file for the signals of the run.

    Returns:
        Whether the object was lifted and held.

    Raises:
        BadInput: scenario, object or hand are unusable; nothing was started or written.
        VhDrakeError: no grasp was tried; the files are written all the same.
    """
    console = Console(file=sys.stderr)
    model = load_trial_object(scenario)
    meshcat = make_meshcat(host or "localhost") if host is not None or record else None
    if meshcat is not None and host is not None:
        console.print(f"watch at {meshcat.web_url()}", highlight=False)

    def tell(phase: str, time_s: float) -> None:
        console.print(f"{time_s:7.2f} s  {phase}", highlight=False)

    done = run_trial(
        scenario, model, out=out, meshcat=meshcat, record=record, on_phase=tell, log=log
    )
    if as_json:
        print(json.dumps(done.result, indent=2))
    else:
        print_report(done, out, Console())
    for warning in done.warnings:
        print(f"vh-drake: warning: {warning}", file=sys.stderr)
    raise_failure(done.result)
    return done.lifted


def print_report(done: TrialResult, out: Path, console: Console) -> None:
    """The stages with their times, and what came of it."""
    result, timing = done.result, done.timing
    stages = timing["stages"]
    if not isinstance(stages, dict):
        raise VhDrakeError("timing without stages")
    table = Table(title=f"{result['object']}, seed {result['seed']}")
    for column in ("stage", "simulated s", "wall s"):
        table.add_column(column, justify="left" if column == "stage" else "right")
    for name, spent in stages.items():
        table.add_row(name, f"{spent['simulated_s']:.2f}", f"{spent['wall_s']:.2f}")
    table.add_row("all", f"{timing['simulated_s']:.2f}", f"{timing['wall_s']:.2f}")
    console.print(table)
    for i, touch in enumerate(result["touches"], start=1):  # type: ignore[arg-type, var-annotated]
        console.print(_touch_line(i, touch), highlight=False)
    if result["surface_error_mm"] is not None:
        console.print(f"surface error {result['surface_error_mm']} mm", highlight=False)
    attempts = result["attempts"]
    if isinstance(attempts, list) and len(attempts) > 1:
        console.print(f"{len(attempts)} grasps tried", highlight=False)
    lifted = "lifted and held" if done.lifted else "NOT lifted"
    console.print(
        f"{lifted}: {result['height_m']} m over the table for {result['hold_s']} s, "
        f"slip {result['slip_mm']} mm and {result['slip_deg']} degrees",
        highlight=False,
    )
    console.print(f"files in {out}", highlight=False)


def _touch_line(number: int, touch: dict[str, object]) -> str:
    if not touch["felt"]:
        return f"touch {number}: nothing felt where the estimate was"
    away = "hidden" if touch.get("faces_away_from_camera") else "not hidden"
    return (
        f"touch {number}: {touch.get('prediction_error_mm')} mm from the prediction, "
        f"{touch.get('felt_error_mm')} mm felt error, a place {away} from the camera, "
        f"object moved {touch['object_displacement_mm']} mm"
    )
