"""What vh_drake must know of a hand beside its model file; a user's hand brings the same."""

import dataclasses as dc
from pathlib import Path

from pydrake.common.yaml import yaml_load_typed

from vh_drake.errors import BadInput


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
    if not path.is_file():
        raise BadInput(f"no hand description at {path}")
    try:
        hand = yaml_load_typed(schema=HandDescription, filename=str(path))
    except Exception as error:  # The parser raises many types; all mean a malformed file.
        raise BadInput(f"{path} is not a hand description: {error}") from error
    model = (path.parent / hand.model).resolve()
    if not model.is_relative_to(path.parent.resolve()):
        raise BadInput(f"{path}: model {hand.model!r} lies outside the description's folder")
    if not model.is_file():
        raise BadInput(f"{path}: no model file {hand.model!r} beside it")
    hand.model = str(model)
    _check(hand, path)
    return hand


def _check(hand: HandDescription, path: Path) -> None:
    motors = {motor.joint for motor in hand.motors}
    problems = [
        f"finger {finger.name!r}: {text}"
        for finger in hand.fingers
        for wrong, text in (
            (len(finger.links) != len(finger.joints), "as many links as joints are needed"),
            (not finger.links, "no links"),
            (finger.motor not in motors, f"motor {finger.motor!r} is not among the motors"),
            (len(finger.p_pad) != 3 or len(finger.n_pad) != 3, "p_pad and n_pad need 3 values"),
        )
        if wrong
    ]
    vectors = {"approach": hand.approach, "closing": hand.closing, "palm": hand.palm,
               "along": hand.along, "tcps.power": hand.tcps.get("power", [])}
    problems += [f"{name} needs 3 values" for name, v in vectors.items() if len(v) != 3]
    problems += ["no fingers"] if not hand.fingers else []
    if problems:
        raise BadInput(f"{path}: " + "; ".join(problems))
