"""The command line: parses, calls one library function, prints.

Heavy modules are imported inside the commands, so that `--help` answers at once.
"""

import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from vh_drake.errors import BadInput, VhDrakeError

FAILED = 1  # The job ran and failed its aim.
UNUSABLE_INPUT = 2
INTERRUPTED = 130

app = typer.Typer(
    name="vh-drake",
    help="Visuo-haptic grasping of unknown objects with ARMAR-6.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

JsonOption = Annotated[
    bool, typer.Option("--json", help="Print the result alone, as JSON, on standard output.")
]

HandOption = Annotated[
    str, typer.Option(metavar="NAME|FILE", help="armar6_right, or a hand's description.")
]


def main() -> None:
    """Runs the command line; ends the process with the status of what happened."""
    try:
        app()
    except VhDrakeError as error:
        _fail(error, UNUSABLE_INPUT if isinstance(error, BadInput) else FAILED)
    except OSError as error:  # A full disk, a folder that may not be written.
        _fail(error, FAILED)
    except KeyboardInterrupt:
        sys.exit(INTERRUPTED)


def _fail(error: Exception, status: int) -> None:
    print(f"vh-drake: {error}", file=sys.stderr)
    sys.exit(status)


def print_result(
    rows: Sequence[Mapping[str, Any]], *, as_json: bool, columns: Sequence[str]
) -> None:
    """Prints rows as JSON, or as a table of the named columns."""
    if as_json:
        print(json.dumps(list(rows), indent=2))
        return
    table = Table(*columns)
    for row in rows:
        table.add_row(*(_cell(row[column]) for column in columns))
    Console().print(table)


def _cell(value: Any) -> str:
    return "" if value is None else escape(str(value))


def _print_version(wanted: bool) -> None:
    if wanted:
        print(f"vh_drake {version('vh_drake')}")
        raise typer.Exit


@app.callback()
def options(
    show_version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Print the version."
        ),
    ] = False,
) -> None:
    """Visuo-haptic grasping of unknown objects with ARMAR-6."""


@app.command()
def doctor(as_json: JsonOption = False) -> None:
    """Check what a grasp needs of this machine, and name the remedy of each failure."""
    from vh_drake.scenes.doctor import examine

    checks = examine()
    rows = [asdict(check) | {"ok": check.ok if as_json else _mark(check.ok)} for check in checks]
    print_result(rows, as_json=as_json, columns=("name", "ok", "found", "remedy"))
    if not all(check.ok for check in checks):
        raise typer.Exit(FAILED)


def _mark(ok: bool) -> str:
    return "yes" if ok else "NO"


@app.command()
def objects(
    folder: Annotated[
        Path | None,
        typer.Option("--objects", metavar="DIR", help="A folder of meshes, or a YCB download."),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """List the embedded objects, or those of a folder."""
    from vh_drake.objects.listing import folder_rows, library_rows

    rows = library_rows() if folder is None else folder_rows(folder)
    details = ("size_mm",) if folder is None else ("split", "file")
    columns = ("name", "mass_g", *details)
    print_result([asdict(row) for row in rows], as_json=as_json, columns=columns)


@app.command()
def diagram(
    out: Annotated[
        Path, typer.Option("--out", metavar="FILE", help="Ends in .svg, .png, .pdf or .dot.")
    ] = Path("diagram.svg"),
    depth: Annotated[int, typer.Option(min=1, help="Of nested diagrams that are opened.")] = 2,
) -> None:
    """Draw the whole diagram: its systems, ports and connections."""
    from vh_drake.objects.loading import load_object
    from vh_drake.scenes.drawing import draw_diagram
    from vh_drake.scenes.scenario import Scenario
    from vh_drake.scenes.visuo_haptic import make_visuo_haptic_diagram

    scenario = Scenario(contact="point")
    model = load_object(scenario.object)
    print(draw_diagram(make_visuo_haptic_diagram(scenario, model), out, depth=depth))


@app.command()
def grasp(
    object_: Annotated[
        str, typer.Argument(metavar="[OBJECT]", help="A name of the library, or a mesh file.")
    ] = "",
    seed: Annotated[
        int | None, typer.Option(min=0, help="Draws pose and noise; 0 unless given.")
    ] = None,
    touches: Annotated[int | None, typer.Option(help="Touches before planning, 0 to 5.")] = None,
    scorer: Annotated[str | None, typer.Option(help="conventional")] = None,
    contact: Annotated[str | None, typer.Option(help="hydroelastic or point")] = None,
    hand: HandOption = "",
    mass: Annotated[float | None, typer.Option(help="Of the object, in kg.")] = None,
    scale: Annotated[float | None, typer.Option(help="Multiplies the mesh's coordinates.")] = None,
    objects_: Annotated[
        Path | None, typer.Option("--objects", metavar="DIR", help="Where OBJECT is a name.")
    ] = None,
    scenario: Annotated[Path | None, typer.Option(metavar="FILE", help="A YAML scenario.")] = None,
    out: Annotated[Path, typer.Option(metavar="DIR", help="For results.")] = Path("out/grasp"),
    show: Annotated[bool, typer.Option("--meshcat/--no-meshcat", help="A live page.")] = True,
    record: Annotated[bool, typer.Option("--record/--no-record", help="recording.html")] = True,
    host: Annotated[str, typer.Option(help="Address of the live page.")] = "localhost",
    as_json: JsonOption = False,
) -> None:
    """Look, touch, fuse, plan, rate, grasp, lift and hold an unknown object."""
    from vh_drake.experiments.grasp_command import grasp_and_report
    from vh_drake.scenes.scenario import overridden

    chosen = overridden(
        scenario,
        seed=seed,
        object=object_ or None,
        touches=touches,
        scorer=scorer,
        contact=contact,
        hand=hand or None,
        mass_kg=mass,
        scale=scale,
        objects=None if objects_ is None else str(objects_),
    )
    lifted = grasp_and_report(
        chosen, out, host=host if show else None, record=record, as_json=as_json
    )
    if not lifted:
        raise typer.Exit(FAILED)


@app.command()
def plan(
    cloud: Annotated[
        Path, typer.Argument(metavar="CLOUD", help="PLY, PCD or NPZ, in metres, z up.")
    ],
    contacts: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Touched places, CSV or JSON.")
    ] = None,
    table: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="The table's plane, where CLOUD is the object alone."),
    ] = None,
    camera: Annotated[
        tuple[float, float, float] | None,
        typer.Option(metavar="X Y Z", help="Where the camera stood, in metres."),
    ] = None,
    hand: HandOption = "",
    seed: Annotated[int, typer.Option(min=0, help="Of every random choice.")] = 0,
    top: Annotated[int, typer.Option(min=1, help="How many grasps are told.")] = 10,
    out: Annotated[Path, typer.Option(metavar="DIR", help="For results.")] = Path("out/plan"),
    as_json: JsonOption = False,
) -> None:
    """Rate grasps for a point cloud of yours, without simulation."""
    from vh_drake.experiments.plan_command import PlanRequest, grasp_rows, plan_from_files

    report = plan_from_files(PlanRequest(cloud, contacts, table, camera, hand, seed, top), out)
    if as_json:
        print(json.dumps(report, indent=2))
    else:
        columns = ("rank", "score", "standard_error", "motion", "position_m")
        print_result(grasp_rows(report), as_json=False, columns=columns)
        print(f"files in {out}")
    if not report["grasps"]:
        _fail(
            VhDrakeError("no free grasp found; is the object in one piece and its size right?"),
            FAILED,
        )
