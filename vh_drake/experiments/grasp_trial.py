"""One trial of the whole job, watched by a judge who sees the ground truth."""

import dataclasses as dc
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from pydrake.geometry import Meshcat
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, Diagram, DiagramBuilder

from vh_drake.errors import NoGraspTried, TooLarge
from vh_drake.experiments.judge import (
    Judge,
    TrueTouch,
    rounded,
    surface_error_mm,
    touch_report,
)
from vh_drake.experiments.signal_log import SignalLog
from vh_drake.grasping.story import GraspRecord, Story
from vh_drake.hand.description import load_hand
from vh_drake.hand.model import read_hand_model
from vh_drake.hand.shipped import hand_file
from vh_drake.objects.loading import load_object
from vh_drake.objects.model import ObjectModel
from vh_drake.result_files import write_json
from vh_drake.scenes.decision import Decision, make_decision
from vh_drake.scenes.placing import draw_object_pose, place_object
from vh_drake.scenes.rating import scorer_in_use
from vh_drake.scenes.recording import start_recording, write_recording
from vh_drake.scenes.scenario import Scenario, check_scenario
from vh_drake.scenes.showing import add_publishers, add_robot_visualizer
from vh_drake.scenes.station import Station, make_station
from vh_drake.scenes.visuo_haptic import join
from vh_drake.types import Array, ObjectView, Surface

WATCH_S = 0.01
LONGEST_S, LONGEST_ATTEMPT_S = 45.0, 45.0  # simulated: the first look and touch; each attempt
LIFTED_M = 0.14  # least height of the object's lowest point over the table while held
HELD_S = 3.0

OnPhase = Callable[[str, float], None]


@dc.dataclass(frozen=True)
class TrialResult:
    """Numbers that depend on the seed alone, and those that depend on the machine."""

    result: dict[str, object]
    timing: dict[str, object]
    warnings: tuple[str, ...] = ()  # what went wrong beside the trial

    @property
    def lifted(self) -> bool:
        """Whether the object was lifted and held."""
        return bool(self.result["lifted"])


@dc.dataclass
class _Hold:
    """The object while the lifted hand stands still."""

    heights_m: list[float] = dc.field(default_factory=list)
    X_HO: list[RigidTransform] = dc.field(default_factory=list)


@dc.dataclass
class _Watch:
    """What the judge noted on the way."""

    truths: list[TrueTouch | None] = dc.field(default_factory=list)
    displacements_mm: list[float] = dc.field(default_factory=list)
    last_touch: TrueTouch | None = None
    X_WO_before: RigidTransform | None = None
    surface_error_mm: float | None = None
    surface_error_before_mm: float | None = None
    holds: list["_Hold"] = dc.field(default_factory=list)  # one an attempt
    stages: dict[str, "_Spent"] = dc.field(default_factory=dict)


@dc.dataclass
class _Spent:
    """Seconds that a stage took."""

    wall_s: float = 0.0
    processor_s: float = 0.0
    simulated_s: float = 0.0

    def add(self, since: "_Clock", simulated_s: float) -> None:
        """What passed since a moment."""
        self.wall_s += time.perf_counter() - since.wall
        self.processor_s += time.process_time() - since.processor
        self.simulated_s += simulated_s


@dc.dataclass(frozen=True)
class _Clock:
    """A moment, by the clock on the wall and by this process's use of processors."""

    wall: float = dc.field(default_factory=time.perf_counter)
    processor: float = dc.field(default_factory=time.process_time)


@dc.dataclass(frozen=True)
class Trial:
    """A diagram with its object in place, ready to run."""

    scenario: Scenario
    model: ObjectModel
    diagram: Diagram
    station: Station
    decision: Decision
    context: Context
    X_WO: RigidTransform


def load_trial_object(scenario: Scenario) -> ObjectModel:
    """The object of a scenario; all that a user may have got wrong shows here, before any effect.

    Raises:
        BadInput: scenario, object or hand are unusable.
    """
    check_scenario(scenario)
    read_hand_model(load_hand(hand_file(scenario.hand)))
    folder = Path(scenario.objects) if scenario.objects else None
    model = load_object(
        scenario.object, mass_kg=scenario.mass_kg, scale=scenario.scale, folder=folder
    )
    return model if scenario.friction is None else dc.replace(model, friction=scenario.friction)


def make_trial(
    scenario: Scenario, model: ObjectModel | None = None, *, meshcat: Meshcat | None = None
) -> Trial:
    """Builds the diagram and draws the object's pose.

    Args:
        scenario: what is simulated.
        model: of `load_trial_object`, where that was called before.
        meshcat: where to show it.

    Raises:
        BadInput: scenario, object or hand are unusable.
    """
    model = model or load_trial_object(scenario)
    builder = DiagramBuilder()
    station = builder.AddSystem(make_station(scenario, model))
    decision = builder.AddSystem(make_decision(scenario))
    join(builder, station, decision)
    if meshcat is not None:
        add_robot_visualizer(builder, station.GetOutputPort("query_object"), meshcat)
        add_publishers(builder, decision, meshcat, station.hand)
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    X_WO = draw_object_pose(scenario, model)
    place_object(station, context, X_WO)
    return Trial(scenario, model, diagram, station, decision, context, X_WO)


def run_trial(
    scenario: Scenario,
    model: ObjectModel | None = None,
    *,
    out: Path | None = None,
    meshcat: Meshcat | None = None,
    record: bool = False,
    on_phase: OnPhase | None = None,
    log: Path | None = None,
) -> TrialResult:
    """Look, touch, fuse, plan, rate, grasp, lift and hold; again where the hand lost it.

    Args:
        scenario: what is simulated.
        model: of `load_trial_object`, where that was called before.
        out: folder for result.json, timing.json and, with `record`, recording.html.
        meshcat: where to show it; needed for a recording.
        record: write a recording.
        on_phase: told the phase and the simulated time whenever the phase changes.
        log: CSV file for the signals, 100 rows a simulated second.

    Raises:
        BadInput: scenario, object or hand are unusable.
    """
    start = _Clock()
    trial = make_trial(scenario, model, meshcat=meshcat)
    simulator = Simulator(trial.diagram, trial.context)
    if meshcat is not None and record:
        start_recording(meshcat)
    judge = Judge(trial.station, trial.model, trial.context)
    watch = _Watch()
    watch.stages.setdefault("build", _Spent()).add(start, 0.0)
    signals = None if log is None else SignalLog(trial.station, trial.decision)
    story = _run(trial, simulator, judge, watch, on_phase, signals)
    if log is not None and signals is not None:
        signals.save(log)
    whole = _Spent()
    whole.add(start, simulator.get_context().get_time())
    done = TrialResult(_result(trial, story, watch), _timing(watch, whole))
    if out is None:
        return done
    write_json(out / "result.json", done.result)
    write_json(out / "timing.json", done.timing)
    recording = meshcat if record else None
    return dc.replace(done, warnings=_write_recording(recording, out / "recording.html"))


def _write_recording(meshcat: Meshcat | None, path: Path) -> tuple[str, ...]:
    """A recording that is too large says so and spoils no trial."""
    if meshcat is None:
        return ()
    try:
        write_recording(meshcat, path)
    except TooLarge as error:
        return (str(error),)
    return ()


def _run(
    trial: Trial,
    simulator: Simulator,
    judge: Judge,
    watch: _Watch,
    on_phase: OnPhase | None,
    signals: SignalLog | None,
) -> Story:
    """Advance until the behaviour has finished."""
    simulator.Initialize()
    context = trial.decision.GetMyContextFromRoot(trial.context)
    phase, tick, finished = "", 0, False
    while not finished:
        before = _Clock()
        tick += 1
        simulator.AdvanceTo(tick * WATCH_S)  # The very times of the systems' events
        story: Story = trial.decision.GetOutputPort("story").Eval(context)
        _note(trial, judge, watch, story, phase, context)
        now_phase = trial.decision.GetOutputPort("phase").Eval(context)
        if signals is not None:
            signals.note(simulator.get_context(), now_phase)
        watch.stages.setdefault((phase or "look").split(":")[0], _Spent()).add(before, WATCH_S)
        if now_phase != phase:
            phase = now_phase
            if on_phase is not None:
                on_phase(phase, simulator.get_context().get_time())
        finished = story.finished or tick * WATCH_S >= longest_s(trial.scenario)
    return story


def longest_s(scenario: Scenario) -> float:
    """Simulated time after which a trial is stopped [s]."""
    return LONGEST_S + scenario.attempts * LONGEST_ATTEMPT_S


THINKING = ("build", "look", "estimate", "plan a touch", "plan grasps")


def _note(
    trial: Trial, judge: Judge, watch: _Watch, story: Story, phase: str, context: Context
) -> None:
    """The judge's notes of this moment."""
    if phase == "touch: feel":
        if watch.X_WO_before is None:
            watch.X_WO_before = judge.object_pose()
        watch.last_touch = judge.touch() or watch.last_touch
    elif phase.startswith("retreat") and len(watch.truths) < len(story.touches):
        watch.truths.append(watch.last_touch)
    elif phase == "estimate" and watch.X_WO_before is not None:
        moved = judge.object_pose().translation() - watch.X_WO_before.translation()
        watch.displacements_mm.append(1000.0 * float(np.linalg.norm(moved)))
        watch.X_WO_before, watch.last_touch = None, None
    elif phase == "plan a touch" and watch.surface_error_before_mm is None:
        watch.surface_error_before_mm = _surface_error(trial, judge, context)
    elif phase == "plan grasps" and watch.surface_error_mm is None:
        watch.surface_error_mm = _surface_error(trial, judge, context)
    elif phase == "grasp: hold":
        hold = watch.holds[-1]
        hold.heights_m.append(judge.lowest_point() - trial.scenario.table.height_m)
        hold.X_HO.append(judge.object_in_hand())
    while len(watch.holds) < len(story.grasps):
        watch.holds.append(_Hold())


def _surface_error(trial: Trial, judge: Judge, context: Context) -> float | None:
    surface: Surface = trial.decision.GetOutputPort("surface").Eval(context)
    if len(surface.faces) == 0:
        return None
    return round(surface_error_mm(surface, trial.model.mesh, judge.object_pose()), 3)


def _result(trial: Trial, story: Story, watch: _Watch) -> dict[str, object]:
    """result.json: the same bytes for the same seed."""
    context = trial.decision.GetMyContextFromRoot(trial.context)
    view: ObjectView = trial.decision.GetOutputPort("view").Eval(context)
    touches = [
        touch_report(
            record,
            watch.truths[i] if i < len(watch.truths) else None,
            trial.model.mesh,
            view.p_WCamera,
            watch.displacements_mm[i] if i < len(watch.displacements_mm) else 0.0,
        )
        for i, record in enumerate(story.touches)
    ]
    scenario, attempts = trial.scenario, _attempts(story, watch)
    return {
        "object": trial.model.name,
        "mass_kg": trial.model.mass_kg,
        "mass_source": trial.model.mass_source,
        "object_report": list(trial.model.report),
        "seed": scenario.seed,
        "scorer": scorer_in_use(scenario.scorer, trial.station.hand, scenario.weights),
        "contact_model": scenario.contact,
        "object_pose": rounded(trial.X_WO.GetAsMatrix4()),
        "points_seen": len(view.p_WO),
        "touches": touches,
        "surface_error_before_touch_mm": watch.surface_error_before_mm,
        "surface_error_mm": watch.surface_error_mm,
        "candidates": story.grasps[-1].candidates if story.grasps else {},
        "attempts": attempts,
        "grasp": attempts[-1]["grasp"] if attempts else None,
        **(attempts[-1]["lift"] if attempts else NOT_LIFTED),
        "failure": story.failure or _failure(trial, story, attempts),
    }


NOT_LIFTED = {"lifted": False, "height_m": 0.0, "hold_s": 0.0, "slip_mm": None, "slip_deg": None}


def _attempts(story: Story, watch: _Watch) -> list[dict[str, dict[str, object]]]:
    """Every grasp that was tried, and what came of it."""
    holds = [*watch.holds, *[_Hold()] * (len(story.grasps) - len(watch.holds))]
    return [
        {"grasp": _grasp_report(grasp), "lift": _lift_report(hold)}
        for grasp, hold in zip(story.grasps, holds, strict=True)
    ]


def _grasp_report(grasp: GraspRecord) -> dict[str, object]:
    return {
        "X_WH": rounded(grasp.X_WH),
        "motion": grasp.motion,
        "planner": grasp.planner,
        "score": round(grasp.score, 5),
        "unreachable_better_ones": grasp.rank,
        "robot_feels_it_held": grasp.held,
        "felt_weight_n": round(grasp.weight_n, 3),
    }


def _lift_report(hold: _Hold) -> dict[str, object]:
    """Height, hold and slip; the object counts as lifted only if it never sank while held."""
    held = len(hold.heights_m) * WATCH_S
    if not hold.heights_m:
        return dict(NOT_LIFTED)
    high = np.array(hold.heights_m) >= LIFTED_M
    slip = hold.X_HO[0].inverse() @ hold.X_HO[-1]
    return {
        "lifted": bool(high.all() and held >= HELD_S),
        "height_m": round(float(np.min(hold.heights_m)), 4),
        "hold_s": round(float(np.argmin(high) if not high.all() else len(high)) * WATCH_S, 2),
        "slip_mm": round(1000.0 * _slip_distance(hold), 3),
        "slip_deg": round(float(np.rad2deg(slip.rotation().ToAngleAxis().angle())), 3),
    }


def _slip_distance(hold: _Hold) -> float:
    """How far the object moved in the hand during the hold [m]."""
    moved: Array = hold.X_HO[-1].translation() - hold.X_HO[0].translation()
    return float(np.linalg.norm(moved))


def _failure(trial: Trial, story: Story, attempts: list[dict[str, dict[str, object]]]) -> str:
    if not story.finished:
        return f"not done after {longest_s(trial.scenario):g} simulated seconds"
    if attempts and attempts[-1]["lift"]["lifted"]:
        return ""
    return "the object was not lifted, or it slipped while held"


def _timing(watch: _Watch, whole: _Spent) -> dict[str, object]:
    """timing.json: seconds of wall clock and processor, which differ from run to run.

    The real-time factor counts the stages in which the robot moves: simulated seconds by those
    on the wall, and by those of the processor, which other work on the machine does not change.
    """
    moving = [spent for name, spent in watch.stages.items() if name not in THINKING]
    simulated = sum(spent.simulated_s for spent in moving)
    wall = sum(spent.wall_s for spent in moving)
    processor = sum(spent.processor_s for spent in moving)
    return {
        **_rounded_spent(whole),
        "real_time_factor": round(simulated / max(wall, 1e-9), 3),
        "real_time_factor_processor": round(simulated / max(processor, 1e-9), 3),
        "stages": {name: _rounded_spent(spent) for name, spent in watch.stages.items()},
    }


def _rounded_spent(spent: _Spent) -> dict[str, float]:
    return {name: round(value, 3) for name, value in vars(spent).items()}


def raise_failure(result: dict[str, object]) -> None:
    """Turns a trial that never tried a grasp into the error that says why.

    Raises:
        NoGraspTried: nothing was seen, or the arm can do nothing with it.
    """
    failure = str(result["failure"])
    if result["grasp"] is None and failure:
        raise NoGraspTried(failure)
