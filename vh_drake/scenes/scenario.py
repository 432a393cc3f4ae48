"""What a run is made of; loaded from YAML, every field with a default."""

import dataclasses as dc
import typing
from pathlib import Path

from pydrake.common.yaml import yaml_load_typed

from vh_drake.errors import BadInput, UnknownName
from vh_drake.scenes.camera import CameraSettings
from vh_drake.sensing.wrist_noise import WristNoiseSettings

CONTACT_MODELS = ("hydroelastic", "point")
SCORERS = ("conventional",)
_MAX_BYTES = 1_000_000


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
    # "hydroelastic" or "point".
    contact: str = "hydroelastic"
    time_step_s: float = 0.002
    # A hand description; empty is the right hand of ARMAR-6.
    hand: str = ""
    # Whether the mirrored articulated hand is on the left arm.
    left_hand: bool = False
    # Touches before planning.
    touches: int = 1
    scorer: str = "conventional"
    # How often another grasp may be tried.
    attempts: int = 1
    table: Table = dc.field(default_factory=Table)
    placement: Placement = dc.field(default_factory=Placement)
    camera: CameraSettings = dc.field(default_factory=CameraSettings)
    wrist: WristNoiseSettings = dc.field(default_factory=WristNoiseSettings)


def load_scenario(path: str | Path) -> Scenario:
    """Reads a scenario.

    Raises:
        BadInput: the file is missing, too large, malformed, or holds values out of range.
    """
    path = Path(path)
    if not path.is_file():
        raise BadInput(f"no scenario file at {path}")
    if path.stat().st_size > _MAX_BYTES:
        raise BadInput(f"{path} is over {_MAX_BYTES} bytes, which no scenario is")
    try:
        scenario: Scenario = yaml_load_typed(schema=Scenario, filename=str(path))
    except Exception as error:  # The parser raises many types; all mean a malformed file.
        raise BadInput(f"{path} is not a scenario: {error}") from error
    check_scenario(scenario)
    return scenario


def check_scenario(scenario: Scenario) -> None:
    """Refuses values that no run can use.

    Raises:
        BadInput: a value is out of range; the message names it and the range.
    """
    if scenario.contact not in CONTACT_MODELS:
        raise UnknownName("contact model", scenario.contact, list(CONTACT_MODELS))
    if scenario.scorer not in SCORERS:
        raise UnknownName("scorer", scenario.scorer, list(SCORERS))
    ranges = {
        "seed": (scenario.seed, 0, 2**31 - 1),
        "time_step_s": (scenario.time_step_s, 1e-4, 0.01),
        "touches": (scenario.touches, 0, 5),
        "attempts": (scenario.attempts, 1, 10),
        "table.height_m": (scenario.table.height_m, 0.5, 1.3),
        "table.friction": (scenario.table.friction, 0.0, 2.0),
        "placement.radius_m": (scenario.placement.radius_m, 0.0, 0.3),
    }
    for name, (value, low, high) in ranges.items():
        if not low <= value <= high:
            raise BadInput(f"{name} is {value:g}; choose a value from {low:g} to {high:g}")
    for name, vector in {
        "table.center": scenario.table.center,
        "table.size": scenario.table.size,
        "placement.center": scenario.placement.center,
    }.items():
        if len(vector) != 2:
            raise BadInput(f"{name} needs 2 values, x and y; it has {len(vector)}")
