"""What vh_drake must know of a hand beside its model file; a user's hand brings the same."""

import dataclasses as dc
import math
from pathlib import Path

from vh_drake.errors import BadInput
from vh_drake.yaml_files import load_typed

MOST_PROBLEMS = 10  # That one message names.


@dc.dataclass
class Finger:
    """A chain of links that one motor closes."""

    name: str = ""
    # From the palm outwards; joint i moves link i.
    links: list[str] = dc.field(default_factory=list)
    joints: list[str] = dc.field(default_factory=list)
    # The joint that pulls this finger's tendon; fingers may share one.
    motor: str = ""
    # The place that touches first when the hand feels for an object: in the frame of the
    # last link [m], with the outward normal there.
    p_pad: list[float] = dc.field(default_factory=list)
    n_pad: list[float] = dc.field(default_factory=list)


@dc.dataclass
class Motor:
    """A prismatic joint whose travel is a tendon's shortening."""

    joint: str = ""
    closed_m: float = 0.0  # travel that closes its fingers fully in free space [m]
    force_n: float = 0.0  # largest pull [N]
    # Share of its travel after which it stops where the hand closes on nothing, as fingers meet
    # each other; 0: unknown.
    empty: float = 0.0


@dc.dataclass
class Pressing:
    """Travel of a hand that gathers with its fingertips along the table and then presses on it.

    Shares of the motors' travel, first of the fingers, then of the thumb.
    """

    gathered: list[float] = dc.field(default_factory=list)
    pressed: list[float] = dc.field(default_factory=list)  # around the object, before it is held
    held_thumb: float = 0.0  # of the thumb, as the fingers pull


@dc.dataclass
class HandDescription:
    """A hand model's links, joints, motors, tool centre points and directions.

    Directions and points are expressed in the base frame H unless said otherwise.
    """

    name: str = ""
    model: str = ""  # model file, relative to the description's folder
    base: str = ""  # link that the wrist carries; its frame is H
    fingers: list[Finger] = dc.field(default_factory=list)
    motors: list[Motor] = dc.field(default_factory=list)
    tcps: dict[str, list[float]] = dc.field(default_factory=dict)  # "power" must be there [m]
    approach: list[float] = dc.field(default_factory=list)  # towards the object, open hand
    closing: list[float] = dc.field(default_factory=list)  # in which the fingers close
    palm: list[float] = dc.field(default_factory=list)  # out of the palm
    along: list[float] = dc.field(default_factory=list)  # from wrist to fingertips
    # How it collects what lies on a table; without it, it does not press on the table.
    pressing: Pressing | None = None


def load_hand(path: str | Path) -> HandDescription:
    """Reads a hand description and checks that it is whole.

    Args:
        path: YAML file in the schema of `HandDescription`.

    Returns:
        The description, its `model` made absolute.

    Raises:
        BadInput: the file is missing, malformed or incomplete, or the model lies
            outside the description's folder.
    """
    path = Path(path)
    hand = load_typed(HandDescription, path)
    problems = [
        *_finger_problems(hand),
        *_motor_problems(hand),
        *_vector_problems(hand),
        *_pressing_problems(hand.pressing),
    ]
    if problems:
        raise BadInput(f"{path}: " + "; ".join(problems[:MOST_PROBLEMS]))
    hand.model = str(_model_file(hand.model, path))
    return hand


def _model_file(model: str, path: Path) -> Path:
    """The model file beside the description; nothing outside its folder is touched."""
    folder = path.parent.resolve()
    try:
        file = (folder / model).resolve()
        inside, there = file.is_relative_to(folder), file.is_file()
    except (OSError, ValueError) as error:  # Too long, or characters that no file has.
        raise BadInput(f"{path}: {model[:80]!r} can't be the name of a model file") from error
    if not inside or Path(model).is_absolute():
        raise BadInput(
            f"{path}: model {model!r} lies outside the description's folder or is absolute; "
            "give a path relative to the description"
        )
    if not there:
        raise BadInput(f"{path}: no model file {model!r} beside it")
    return file


def _finger_problems(hand: HandDescription) -> list[str]:
    motors = {motor.joint for motor in hand.motors}
    problems = [
        f"finger {finger.name!r}: {text}"
        for finger in hand.fingers
        for wrong, text in (
            (not finger.links, "no links"),
            (len(finger.links) != len(finger.joints), "as many links as joints are needed"),
            (finger.motor not in motors, f"motor {finger.motor!r} is not among the motors"),
            (not _is_vector(finger.p_pad), "p_pad needs 3 finite values"),
            (not _is_vector(finger.n_pad), "n_pad needs 3 finite values"),
        )
        if wrong
    ]
    return problems or ([] if hand.fingers else ["no fingers"])


def _motor_problems(hand: HandDescription) -> list[str]:
    return [
        f"motor {motor.joint!r}: {name} is {value:g}, but must be positive and finite"
        for motor in hand.motors
        for name, value in (("closed_m", motor.closed_m), ("force_n", motor.force_n))
        if not (math.isfinite(value) and value > 0.0)
    ] + [
        f"motor {motor.joint!r}: empty is {motor.empty:g}, but must be a share in 0..1"
        for motor in hand.motors
        if not 0.0 <= motor.empty <= 1.0
    ]


def _vector_problems(hand: HandDescription) -> list[str]:
    directions = {
        "approach": hand.approach,
        "closing": hand.closing,
        "palm": hand.palm,
        "along": hand.along,
    }
    points = {"power": [], **hand.tcps}
    vectors = directions | {f"tcps.{name}": value for name, value in points.items()}
    return [
        f"{name} needs 3 finite values" for name, value in vectors.items() if not _is_vector(value)
    ] + [f"{name} has no length" for name, value in directions.items() if value and not any(value)]


def _pressing_problems(pressing: Pressing | None) -> list[str]:
    if pressing is None:
        return []
    pairs = {"gathered": pressing.gathered, "pressed": pressing.pressed}
    shares = {**pairs, "held_thumb": [pressing.held_thumb, 0.0]}
    return [
        f"pressing.{name} must be {'a share' if name == 'held_thumb' else 'two shares'} in 0..1"
        for name, values in shares.items()
        if len(values) != 2 or not all(0.0 <= value <= 1.0 for value in values)
    ]


def _is_vector(values: list[float]) -> bool:
    return len(values) == 3 and all(math.isfinite(value) for value in values)
