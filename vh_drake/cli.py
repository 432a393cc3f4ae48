"""The command line: parses, calls one library function, prints.

Heavy modules are imported inside the commands, so that `--help` answers at once.
"""

import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from vh_drake.errors import BadInput, VhDrakeError

if TYPE_CHECKING:
    from vh_drake.catalog import Entry, Options

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

WeightsOption = Annotated[
    Path | None, typer.Option(metavar="FILE", help="Of the learned metric; the shipped ones else.")
]
HandOption = Annotated[
    str, typer.Option(metavar="NAME|FILE", help="Such as armar3_right, or a hand's description.")
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
    attempts: Annotated[int | None, typer.Option(help="Grasps that may be tried.")] = None,
    scorer: Annotated[
        str | None, typer.Option(help="learned, conventional, rate, epsilon or nominal")
    ] = None,
    weights: WeightsOption = None,
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
    log: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Signals of the run, as CSV.")
    ] = None,
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
        attempts=attempts,
        scorer=scorer,
        weights=None if weights is None else str(weights),
        contact=contact,
        hand=hand or None,
        mass_kg=mass,
        scale=scale,
        objects=None if objects_ is None else str(objects_),
    )
    lifted = grasp_and_report(
        chosen, out, host=host if show else None, record=record, as_json=as_json, log=log
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
    weights: WeightsOption = None,
    seed: Annotated[int, typer.Option(min=0, help="Of every random choice.")] = 0,
    top: Annotated[int, typer.Option(min=1, help="How many grasps are told.")] = 10,
    out: Annotated[Path, typer.Option(metavar="DIR", help="For results.")] = Path("out/plan"),
    as_json: JsonOption = False,
) -> None:
    """Rate grasps for a point cloud of yours, without simulation."""
    from vh_drake.experiments.plan_command import PlanRequest, grasp_rows, plan_from_files

    own = "" if weights is None else str(weights)
    request = PlanRequest(cloud, contacts, table, camera, hand, seed, top, own)
    report = plan_from_files(request, out)
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


@app.command()
def teach(
    file: Annotated[
        Path, typer.Argument(metavar="[FILE]", help="Of key points; loaded where it exists.")
    ] = Path("out/teach/key_points.yaml"),
    object_: Annotated[
        str, typer.Option("--object", metavar="NAME|FILE", help="What lies on the table.")
    ] = "banana",
    seed: Annotated[int | None, typer.Option(min=0, help="Draws the object's pose.")] = None,
    contact: Annotated[str, typer.Option(help="hydroelastic or point")] = "point",
    hand: HandOption = "",
    scenario: Annotated[Path | None, typer.Option(metavar="FILE", help="A YAML scenario.")] = None,
    host: Annotated[str, typer.Option(help="Address of the page.")] = "localhost",
) -> None:
    """Teach a grasp: jog the simulated hand on a page, set key points, play and save them."""
    from vh_drake.experiments.teach_command import teach as serve
    from vh_drake.scenes.scenario import overridden

    chosen = overridden(scenario, seed=seed, object=object_, contact=contact, hand=hand or None)
    serve(chosen, file, host=host, tell=lambda line: print(line, flush=True))


@app.command()
def explore(
    object_: Annotated[
        str, typer.Argument(metavar="OBJECT", help="A name of the library, or a mesh file.")
    ],
    strategy: Annotated[
        str,
        typer.Option(help="igef, gp_variance, random, uncertainty_cost or potential_field"),
    ] = "igef",
    touches: Annotated[int | None, typer.Option(help="At most; until the goal else.")] = None,
    goal: Annotated[float, typer.Option(help="Share of the surface to be explored.")] = 0.8,
    seed: Annotated[int, typer.Option(help="Of the first approach.")] = 0,
    scale: Annotated[float, typer.Option(help="Multiplies the mesh's coordinates.")] = 1.0,
    objects_: Annotated[
        Path | None, typer.Option("--objects", metavar="DIR", help="Where OBJECT is a name.")
    ] = None,
    record: Annotated[bool, typer.Option("--record/--no-record", help="recording.html")] = True,
    out: Annotated[Path, typer.Option(metavar="DIR", help="For results.")] = Path("out/explore"),
    as_json: JsonOption = False,
) -> None:
    """Explore an object by touch alone, with a fingertip, until enough of it is known."""
    from vh_drake.experiments.explore_command import ExploreRequest, explore_object

    request = ExploreRequest(object_, objects_, scale, strategy, touches, goal, seed)
    report = explore_object(request, out, record=record)
    if as_json:
        print(json.dumps(report, indent=2))
    else:
        _print_facts({k: v for k, v in report.items() if not isinstance(v, dict | list)}, False)
        print(f"files in {out}")
    if not report["reached"]:
        raise typer.Exit(FAILED)


ObjectsOption = Annotated[
    Path | None, typer.Option("--objects", metavar="DIR", help="Meshes, with or without a table.")
]
RunsOption = Annotated[int | None, typer.Option(help="Repetitions of each object or condition.")]
ScenesOption = Annotated[int | None, typer.Option(help="How many scenes in all.")]
ContactOption = Annotated[str | None, typer.Option(help="hydroelastic or point")]
SplitOption = Annotated[str | None, typer.Option(help="Of objects.csv: test or train.")]
StrategiesOption = Annotated[
    str | None, typer.Option(help="Of exploration, comma-separated, or all.")
]
SeedOption = Annotated[int, typer.Option(help="Of every random choice.")]
WorkersOption = Annotated[int, typer.Option(help="Processes; 0 takes every core.")]
OutOption = Annotated[Path | None, typer.Option(metavar="DIR", help="For results; out/NAME else.")]


@app.command()
def reproduce(
    name: Annotated[str, typer.Argument(metavar="[NAME]", help="None lists them all.")] = "",
    objects_: ObjectsOption = None,
    runs: RunsOption = None,
    scenes: ScenesOption = None,
    contact: ContactOption = None,
    split: SplitOption = None,
    weights: WeightsOption = None,
    strategies: StrategiesOption = None,
    seed: SeedOption = 0,
    workers: WorkersOption = 0,
    out: OutOption = None,
    as_json: JsonOption = False,
) -> None:
    """Reproduce a table or figure of the dissertation, or a table of ours beyond it."""
    from vh_drake.catalog import REPRODUCTIONS, Options

    options = Options(
        objects=objects_,
        runs=runs,
        scenes=scenes,
        contact=contact,
        split=split,
        weights=weights,
        strategies=strategies,
        seed=seed,
        workers=workers,
        out=out or Path("out") / name,
    )
    _run_from(REPRODUCTIONS, "reproduction", name, options, as_json)


@app.command()
def bench(
    name: Annotated[str, typer.Argument(metavar="[NAME]", help="None lists them all.")] = "",
    objects_: ObjectsOption = None,
    runs: RunsOption = None,
    split: SplitOption = None,
    seed: SeedOption = 0,
    workers: WorkersOption = 1,
    out: OutOption = None,
    as_json: JsonOption = False,
) -> None:
    """Measure speed and agreement beside other implementations.

    One worker unless you ask for more: times are told of an idle machine.
    """
    from vh_drake.catalog import BENCHES, Options

    options = Options(
        objects=objects_,
        runs=runs,
        split=split,
        seed=seed,
        workers=workers,
        out=out or Path("out") / f"bench-{name}",
    )
    _run_from(BENCHES, "benchmark", name, options, as_json)


def _run_from(
    entries: "Mapping[str, Entry]", kind: str, name: str, options: "Options", as_json: bool
) -> None:
    from vh_drake.catalog import run_entry

    if not name:
        rows = [{"name": key, "what": entry.help} for key, entry in entries.items()]
        print_result(rows, as_json=as_json, columns=("name", "what"))
        return
    report = run_entry(kind, entries, name, options)
    if as_json:
        print(json.dumps(report.content(), indent=2))
        return
    summary = [
        {"metric": key, "value": _number(value), "thesis": _number(report.thesis.get(key))}
        for key, value in report.summary.items()
    ]
    print_result(summary, as_json=False, columns=("metric", "value", "thesis"))
    print(f"files in {options.out}")


def _number(value: Any) -> Any:
    return f"{value:.4g}" if isinstance(value, float) else value


dataset = typer.Typer(help="Labelled scenes that a grasp metric learns from.", no_args_is_help=True)
app.add_typer(dataset, name="dataset")

FolderArgument = Annotated[Path, typer.Argument(metavar="DIR", help="Of a data set.")]


@dataset.command("generate")
def dataset_generate(
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Empty, or half done.")],
    scenes: Annotated[int, typer.Option(help="How many.")] = 1000,
    objects_: ObjectsOption = None,
    shapes: Annotated[int, typer.Option(help="Drawn shapes that come along.")] = 80,
    library: Annotated[bool, typer.Option(help="Whether embedded objects come along.")] = True,
    candidates: Annotated[int, typer.Option(help="Of each scene.")] = 160,
    scheduler: Annotated[
        str | None, typer.Option(metavar="URL", help="Of a Dask cluster, tcp://...")
    ] = None,
    seed: SeedOption = 0,
    workers: WorkersOption = 0,
    as_json: JsonOption = False,
) -> None:
    """Draw scenes, plan grasps and label them; a killed run goes on where it stopped."""
    from contextlib import nullcontext

    from vh_drake.learning.dataset import dask_executor, generate, make_spec
    from vh_drake.learning.generating import GeneratorSettings

    spec = make_spec(
        scenes,
        folder=objects_,
        shapes=shapes,
        library=library,
        seed=seed,
        settings=GeneratorSettings(candidates=candidates),
    )
    with dask_executor(scheduler) if scheduler else nullcontext() as executor:
        told = generate(out, spec, workers=workers, executor=executor, title="scenes")
    _print_facts(told, as_json)


@dataset.command("info")
def dataset_info(folder: FolderArgument, as_json: JsonOption = False) -> None:
    """Tell how large a data set is and what is in it."""
    from vh_drake.learning.dataset import info

    _print_facts(info(folder), as_json)


@dataset.command("verify")
def dataset_verify(folder: FolderArgument) -> None:
    """Check every file of a data set; status 1 where something is wrong."""
    from vh_drake.learning.dataset import verify

    problems = verify(folder)
    for problem in problems:
        print(problem)
    if problems:
        raise typer.Exit(FAILED)
    print(f"{folder}: whole")


@dataset.command("lift")
def dataset_lift(
    folder: FolderArgument,
    scenes: Annotated[int, typer.Option(help="How many, of all objects in turn.")] = 400,
    objects_: ObjectsOption = None,
    workers: WorkersOption = 0,
    as_json: JsonOption = False,
) -> None:
    """Carry out grasps of a data set with the hand alone; a killed run goes on."""
    from vh_drake.scenes.lifts import lift_facts, lift_grasps

    lifts = lift_grasps(folder, objects_, scenes, workers=workers, title="lifting")
    _print_facts(lift_facts(lifts), as_json)


@app.command()
def train(
    data: Annotated[
        list[Path], typer.Option("--dataset", metavar="DIR", help="One or more data sets.")
    ],
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="For weights and curves.")],
    epochs: Annotated[int, typer.Option(help="At most.")] = 3,
    seed: SeedOption = 0,
    workers: WorkersOption = 0,
    as_json: JsonOption = False,
) -> None:
    """Train the learned grasp metric; a killed run goes on where it stopped."""
    from vh_drake.learning.train_command import train_metric
    from vh_drake.learning.training import Round, TrainingSettings

    def tell(done: Round) -> None:
        print(
            f"epoch {done.epoch:g}: loss {done.train_loss:.4f}, on held-out objects "
            f"{done.held_loss:.4f}, ROC area {done.held_auc:.4f}",
            file=sys.stderr,
        )

    settings = TrainingSettings(epochs=epochs, seed=seed)
    metric = train_metric(data, out, settings, workers=workers, tell=tell)
    _print_facts(metric.card["held_out"], as_json)


@app.command("train-lifts")
def train_lifts(
    data: Annotated[
        list[Path], typer.Option("--dataset", metavar="DIR", help="With grasps carried out.")
    ],
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="For the model.")],
    weights: WeightsOption = None,
    seed: SeedOption = 0,
    workers: WorkersOption = 0,
    as_json: JsonOption = False,
) -> None:
    """Fit the model that foretells lifts to grasps that were carried out."""
    from vh_drake.learning.lift_training import LiftTrainingSettings, figures, train_lift_model

    model = train_lift_model(
        data,
        out,
        weights=weights,
        settings=LiftTrainingSettings(seed=seed),
        workers=workers,
        title="inputs",
    )
    _print_facts(figures(model), as_json)


@app.command()
def evaluate(
    data: Annotated[Path, typer.Option("--dataset", metavar="DIR", help="A labelled data set.")],
    weights: WeightsOption = None,
    seed: SeedOption = 0,
    workers: WorkersOption = 0,
    out: Annotated[Path, typer.Option(metavar="DIR", help="For results.")] = Path("out/evaluate"),
    as_json: JsonOption = False,
) -> None:
    """Compare the learned metric with its baselines on a data set."""
    from vh_drake.experiments.evaluate_command import evaluate as evaluate_data

    report = evaluate_data(data, weights, out, seed=seed, workers=workers)
    report.save(out)
    if as_json:
        print(json.dumps(report.content(), indent=2))
    else:
        _print_facts(report.summary, as_json)
        print(f"files in {out}")


def _print_facts(facts: Mapping[str, Any], as_json: bool) -> None:
    if as_json:
        print(json.dumps(dict(facts), indent=2))
        return
    rows = [{"what": key, "value": _number(value)} for key, value in facts.items()]
    print_result(rows, as_json=False, columns=("what", "value"))
