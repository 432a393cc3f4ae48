"""What a run is made of; loaded from YAML, every field with a default."""

import dataclasses as dc
import typing
from operator import attrgetter
from pathlib import Path

from vh_drake.errors import BadInput, UnknownName
from vh_drake.grasping.approach import CLOSINGS
from vh_drake.grasping.planner_settings import (
    APPROACHES,
    PLANNERS,
    PlannerSettings,
    check_planner_settings,
)
from vh_drake.scenes.camera import CameraSettings
from vh_drake.sensing.wrist_noise import WristNoiseSettings
from vh_drake.yaml_files import load_typed

CONTACT_MODELS = ("hydroelastic", "point")
# For many trials in point contact. At 4 ms the contact forces, which Drake regularizes by the
# step, let what is light and round slip out of the hand.
POINT_STEP_S = 0.0025
SCORERS = ("learned", "conventional", "rate", "epsilon", "nominal")
# Least and largest value of each number.
RANGES = {
    "seed": (0, 2**31 - 1),
    "mass_kg": (1e-3, 100.0),
    "scale": (1e-6, 1e6),
    "friction": (0.0, 2.0),
    "time_step_s": (1e-4, 0.01),
    "touches": (0, 5),
    "attempts": (1, 10),
    "table.height_m": (0.5, 1.3),
    "table.friction": (0.0, 2.0),
    "placement.radius_m": (0.0, 0.3),
    "camera.width": (16, 4096),
    "camera.height": (16, 4096),
    "camera.fov_y_rad": (0.1, 2.5),
    "camera.min_depth_m": (0.01, 10.0),
    "camera.max_depth_m": (0.02, 100.0),
    "camera.calibration_shift_m": (0.0, 0.1),
    "camera.calibration_turn_deg": (0.0, 30.0),
    "camera.noise.axial_m": (0.0, 0.1),
    "camera.noise.axial_per_m": (0.0, 0.1),
    "camera.noise.grazing": (0.0, 0.1),
    "camera.noise.disparity_step_px": (0.0, 8.0),
    "camera.noise.focal_baseline_m": (1.0, 1e4),
    "camera.noise.edge_m": (1e-4, 1.0),
    "camera.noise.lateral_px": (0.0, 20.0),
    "camera.noise.edge_dropout": (0.0, 1.0),
    "camera.noise.max_incidence_deg": (1.0, 89.9),
    "wrist.force_std_n": (0.0, 10.0),
    "wrist.torque_std_nm": (0.0, 1.0),
    "wrist.force_drift_n": (0.0, 10.0),
    "wrist.torque_drift_nm": (0.0, 1.0),
}
# The same of both values of a pair, x and y.
PAIR_RANGES = {
    "table.center": (-5.0, 5.0),
    "table.size": (0.05, 10.0),
    "placement.center": (-5.0, 5.0),
}
_LONGEST_TEXT = 4096


@dc.dataclass
class Table:
    """A flat table in front of the robot."""

    height_m: float = 0.9  # of its top over the floor
    center: list[float] = dc.field(default_factory=lambda: [0.85, -0.2])  # x, y [m]
    size: list[float] = dc.field(default_factory=lambda: [0.6, 1.4])  # along x, y [m]
    friction: float = 0.5


@dc.dataclass
class Placement:
    """Where the object may stand; the seed draws the rest."""

    center: list[float] = dc.field(default_factory=lambda: [0.7, -0.3])  # x, y [m]
    radius_m: float = 0.06


@dc.dataclass
class Scenario:
    """One robot, one table, one unknown object."""

    # Draws the object's pose and every sensor's noise.
    seed: int = 0
    # A name of the library, a mesh file, or a name within the folder `objects`.
    object: str = "fruit_drink"
    objects: str = ""
    # None takes the known mass.
    mass_kg: typing.Optional[float] = None  # noqa: UP045 (yaml_load_typed reads this form only)
    scale: float = 1.0
    # Of the object, on everything; None takes the object's own.
    friction: typing.Optional[float] = None  # noqa: UP045
    # "hydroelastic" or "point".
    contact: str = "hydroelastic"
    time_step_s: float = 0.002
    # A shipped hand's name or a description file; empty is the right hand of ARMAR-6.
    hand: str = ""
    # Whether the mirrored articulated hand is on the left arm.
    left_hand: bool = False
    # Touches before planning.
    touches: int = 1
    # Those that propose grasps: "surface", "skeleton".
    planners: list[str] = dc.field(default_factory=lambda: list(PLANNERS))
    # From where grasps come: "collect" from the top, "side".
    approaches: list[str] = dc.field(default_factory=lambda: list(APPROACHES[:2]))
    # One of SCORERS; hands that the metric has not learnt with: "conventional".
    scorer: str = "learned"
    # Of the learned metric, with its lift model beside them; empty takes the shipped ones.
    weights: str = ""
    # How the hand closes: "closed_loop" or "open_loop".
    closing: str = "closed_loop"
    # How many grasps may be tried.
    attempts: int = 3
    table: Table = dc.field(default_factory=Table)
    placement: Placement = dc.field(default_factory=Placement)
    camera: CameraSettings = dc.field(default_factory=CameraSettings)
    wrist: WristNoiseSettings = dc.field(default_factory=WristNoiseSettings)


def load_scenario(path: str | Path) -> Scenario:
    """Reads a scenario.

    Raises:
        BadInput: the file is missing, too large, malformed, or holds values out of range.
    """
    scenario = load_typed(Scenario, path)
    try:
        check_scenario(scenario)
    except BadInput as error:
        raise BadInput(f"{path}: {error}") from error
    return scenario


def check_scenario(scenario: Scenario) -> None:
    """Refuses values that no run can use; whether the object exists shows when it is loaded.

    Raises:
        BadInput: a value is out of range or not finite; the message names it and the range.
    """
    for kind, name, choices in (
        ("contact model", scenario.contact, CONTACT_MODELS),
        ("scorer", scenario.scorer, SCORERS),
        ("closing", scenario.closing, CLOSINGS),
    ):
        if name not in choices:
            raise UnknownName(kind, name[:80], list(choices))
    check_planner_settings(
        PlannerSettings(planners=scenario.planners, approaches=scenario.approaches)
    )
    _check_texts(scenario)
    for name, (low, high) in RANGES.items():
        _check_range(name, attrgetter(name)(scenario), low, high)
    for name, (low, high) in PAIR_RANGES.items():
        pair = attrgetter(name)(scenario)
        if len(pair) != 2:
            raise BadInput(f"{name} needs 2 values, x and y; it has {len(pair)}")
        for value in pair:
            _check_range(name, value, low, high)
    camera = scenario.camera
    if camera.min_depth_m >= camera.max_depth_m:
        raise BadInput(
            f"camera.min_depth_m is {camera.min_depth_m:g}; choose less than "
            f"camera.max_depth_m, {camera.max_depth_m:g}"
        )


def _check_texts(scenario: Scenario) -> None:
    """Names and paths that no file system refuses outright."""
    if not scenario.object:
        raise BadInput("object is empty; name one of the library or a mesh file")
    for name in ("object", "objects", "hand", "weights"):
        text = getattr(scenario, name)
        if len(text) > _LONGEST_TEXT or not text.isprintable():
            raise BadInput(f"{name} {text[:80]!r} can't be a name or a path")


def _check_range(name: str, value: float | None, low: float, high: float) -> None:
    if value is not None and not low <= value <= high:  # NaN fails both comparisons.
        shown = f"{value:g}" if abs(value) < 1e300 or isinstance(value, float) else "huge"
        raise BadInput(f"{name} is {shown}; choose a value from {low:g} to {high:g}")


def overridden(path: Path | None, **values: object) -> Scenario:
    """The scenario of a file, or the default one, with the values that are not None.

    Raises:
        BadInput: the file or a value is unusable.
    """
    scenario = Scenario() if path is None else load_scenario(path)
    for name, value in values.items():
        if value is not None:
            setattr(scenario, name, value)
    check_scenario(scenario)
    return scenario
