"""Loading ARMAR-6 into a plant: some of its joints fixed, dressed in its real meshes."""

from collections.abc import Container, Mapping
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
from pydrake.common.eigen_geometry import AngleAxis
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex

from vh_drake.errors import BadInput, UnknownName
from vh_drake.geometry.armar_visuals import armar_visuals
from vh_drake.geometry.model_files import add_models, models_folder
from vh_drake.types import Array

DRAKE_NAMESPACE = "http://drake.mit.edu"
ElementTree.register_namespace("drake", DRAKE_NAMESPACE)


def add_armar6(
    plant: MultibodyPlant,
    *,
    fixed_joints: Mapping[str, float] | None = None,
    visuals: bool = True,
    bare_links: Container[str] = (),
) -> ModelInstanceIndex:
    """Add ARMAR-6 without hands to `plant`, its platform welded to the world.

    Hands are welded to `hand_fixed_r1` (right) and `hand_fixed_r0` (left) by the caller.

    Args:
        plant: a plant before `Finalize`.
        fixed_joints: joint name: position [m or rad]; these joints become welds at that
            position and lose their actuators, which splits the robot into cheaper trees.
        visuals: show the meshes of the PyPI package `armar` where that is installed.
        bare_links: links that keep their own shapes even so.

    Raises:
        UnknownName: a name in `fixed_joints` is no moving joint.
        BadInput: a position in `fixed_joints` lies outside the joint's limits.
    """
    robot = ElementTree.fromstring((models_folder() / "armar6" / "armar6.urdf").read_text())
    for name, position in (fixed_joints or {}).items():
        fix_joint(robot, name, position)
    if visuals:
        dressed = {name: v for name, v in armar_visuals().items() if name not in bare_links}
        replace_visuals(robot, dressed)
    parser = Parser(plant)
    add_models(parser)
    (instance,) = parser.AddModelsFromString(ElementTree.tostring(robot, "unicode"), "urdf")
    return instance


def fix_joint(robot: Element, name: str, position: float) -> None:
    """Turn a moving joint of a URDF into a weld at `position` [m or rad]."""
    moving = {
        joint.get("name", ""): joint
        for joint in robot.iterfind("joint")
        if joint.get("type") in ("revolute", "prismatic")
    }
    if name not in moving:
        raise UnknownName("joint", name, list(moving))
    joint = moving[name]
    _check_limits(joint, position)
    _set_origin(joint, _origin(joint) @ _joint_transform(joint, position))
    joint.set("type", "fixed")
    for tag in ("axis", "limit", "dynamics"):
        _remove(joint, joint.findall(tag))
    _remove(robot, [t for t in robot.iterfind("transmission") if _drives(t, name)])


def replace_visuals(robot: Element, visuals: Mapping[str, Element]) -> None:
    """Show link name: visual element in place of the link's own visual shapes."""
    for link in robot.iterfind("link"):
        visual = visuals.get(link.get("name", ""))
        if visual is not None:
            _remove(link, link.findall("visual"))
            link.append(visual)


def _check_limits(joint: Element, position: float) -> None:
    limit = joint.find("limit")
    assert limit is not None
    lower, upper = float(limit.get("lower", "")), float(limit.get("upper", ""))
    if not lower <= position <= upper:
        raise BadInput(
            f"joint {joint.get('name')!r} cannot be fixed at {position:g}: "
            f"choose a position from {lower:g} to {upper:g}"
        )


def _origin(joint: Element) -> RigidTransform:
    """Pose of the child frame at position zero, in the parent frame."""
    origin = joint.find("origin")
    assert origin is not None
    return RigidTransform(
        RollPitchYaw(_vector(origin.get("rpy", "0 0 0"))), _vector(origin.get("xyz", "0 0 0"))
    )


def _joint_transform(joint: Element, position: float) -> RigidTransform:
    axis_element = joint.find("axis")
    assert axis_element is not None
    axis = _vector(axis_element.get("xyz", "1 0 0"))
    if joint.get("type") == "prismatic":
        return RigidTransform(axis * position)
    return RigidTransform(RotationMatrix(AngleAxis(position, axis)))


def _set_origin(joint: Element, transform: RigidTransform) -> None:
    origin = joint.find("origin")
    assert origin is not None
    origin.set("xyz", _text(transform.translation()))
    origin.set("rpy", _text(RollPitchYaw(transform.rotation()).vector()))


def _drives(transmission: Element, joint_name: str) -> bool:
    return any(joint.get("name") == joint_name for joint in transmission.iterfind("joint"))


def _remove(parent: Element, children: list[Element]) -> None:
    for child in children:
        parent.remove(child)


def _vector(text: str) -> Array:
    return np.array([float(number) for number in text.split()])


def _text(vector: Array) -> str:
    return " ".join(repr(float(number)) for number in vector)
