"""A hand without its arm: on a base that goes where it is told, over a table or in free space."""

import dataclasses as dc
from collections.abc import Mapping
from typing import Literal

import numpy as np
from pydrake.geometry import SceneGraph
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlant, MultibodyPlantConfig
from pydrake.multibody.tree import (
    ModelInstanceIndex,
    PdControllerGains,
    PrismaticJoint,
    RevoluteJoint,
    RigidBody,
    SpatialInertia,
)
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import MatrixGain

from vh_drake.errors import BadInput
from vh_drake.grasping.motions import pitched_rotation
from vh_drake.hand.model import HandModel
from vh_drake.objects.drake_model import add_object
from vh_drake.objects.model import ObjectModel
from vh_drake.scenes.plant import add_table
from vh_drake.scenes.scenario import Table
from vh_drake.scenes.tendon_drive import add_tendon_drive
from vh_drake.systems.tendon_hand import Command
from vh_drake.types import Array

Contact = Literal["none", "point", "hydroelastic"]

STEP_S = 0.002
# Stiff, so that the base is where it is told to within a tenth of a millimetre under the
# hand's weight.
_SLIDE = PdControllerGains(p=2e5, d=2e3)
_HINGE = PdControllerGains(p=2e3, d=20.0)
_CARRIAGE = SpatialInertia.SolidSphereWithMass(1.0, 0.05)
_TABLE = Table(height_m=0.0, center=[0.0, 0.0], size=[1.0, 1.0])


@dc.dataclass(frozen=True)
class MovingHand:
    """The diagram and the handles that an observer needs.

    Ports of the diagram beside those of `TendonHand`:

    | port       | direction | type        | unit   | meaning                                    |
    |------------|-----------|-------------|--------|--------------------------------------------|
    | base_state | in        | vector (12) | m, rad | of H, see `base_joints`, then its rates    |
    | touch      | out       | vector (3)  | N      | sum of what touches the hand, in W         |
    | hand_state | out       | vector      | SI     | of the hand's model instance               |
    """

    diagram: Diagram
    plant: MultibodyPlant
    scene_graph: SceneGraph | None
    instance: ModelInstanceIndex
    base: ModelInstanceIndex
    object: RigidBody | None


def make_moving_hand(
    hand: HandModel,
    *,
    contact: Contact = "none",
    gravity: bool = True,
    command: Command = "position",
    stops: Mapping[str, float] | None = None,
    model: ObjectModel | None = None,
    X_WO: Array | None = None,
    table: Table | None = None,
    step_s: float = STEP_S,
) -> MovingHand:
    """The hand on a base that moves and turns it anywhere, over a table.

    Args:
        hand: what moves.
        contact: "none" leaves out table, object and all collisions, also those of fingers with
            the palm: the transmission alone.
        gravity: whether the hand has weight.
        command: what the port `motor_command` holds, see `TendonHand`.
        stops: upper limits of joints by name, in place of the model's own [rad].
        model: an object on the table.
        X_WO: its pose (4, 4); the origin by default.
        table: below; its top is at z = 0 by default.
        step_s: of the simulation [s].

    Raises:
        BadInput: an object without contact.
    """
    if model is not None and contact == "none":
        raise BadInput("an object needs contact; choose point or hydroelastic")
    builder = DiagramBuilder()
    plant, scene_graph = _plant(builder, contact, step_s)
    (instance,) = Parser(plant).AddModels(hand.description.model)
    base = _add_base(plant, hand, instance)
    for name, stop in (stops or {}).items():
        joint = plant.GetJointByName(name, instance)
        joint.set_position_limits(joint.position_lower_limits(), [stop])
    plant.set_gravity_enabled(base, False)
    plant.set_gravity_enabled(instance, gravity)
    body = None
    if contact != "none":
        add_table(plant, table or _TABLE)
        if model is not None:
            body = add_object(plant, model, contact=contact)
            X = np.eye(4) if X_WO is None else X_WO
            plant.SetDefaultFloatingBaseBodyPose(body, RigidTransform(X))
    plant.Finalize()
    add_tendon_drive(builder, plant, instance, hand, command)
    builder.ExportInput(plant.get_desired_state_input_port(base), "base_state")
    _export_touch(builder, plant, base)
    builder.ExportOutput(plant.get_state_output_port(instance), "hand_state")
    return MovingHand(builder.Build(), plant, scene_graph, instance, base, body)


def _export_touch(builder: DiagramBuilder, plant: MultibodyPlant, base: ModelInstanceIndex) -> None:
    """Contact forces along the base's slides are those on all that hangs on it."""
    slides = builder.AddNamedSystem("slides", MatrixGain(np.eye(3, 6)))
    forces = plant.get_generalized_contact_forces_output_port(base)
    builder.Connect(forces, slides.get_input_port())
    builder.ExportOutput(slides.get_output_port(), "touch")


def _plant(
    builder: DiagramBuilder, contact: Contact, step_s: float
) -> tuple[MultibodyPlant, SceneGraph | None]:
    """With a scene graph only where there is contact."""
    if contact == "none":
        return builder.AddSystem(MultibodyPlant(step_s)), None
    config = MultibodyPlantConfig(
        time_step=step_s,
        contact_model="hydroelastic_with_fallback" if contact == "hydroelastic" else contact,
        discrete_contact_approximation="lagged",
    )
    plant, scene_graph = AddMultibodyPlant(config, builder)
    return plant, scene_graph


def _add_base(
    plant: MultibodyPlant, hand: HandModel, instance: ModelInstanceIndex
) -> ModelInstanceIndex:
    """Three slides and three hinges between the world and the hand."""
    base = plant.AddModelInstance("base")
    frame = plant.world_frame()
    for name, joint_type, axis, gains in (
        ("base_x", PrismaticJoint, [1.0, 0.0, 0.0], _SLIDE),
        ("base_y", PrismaticJoint, [0.0, 1.0, 0.0], _SLIDE),
        ("base_z", PrismaticJoint, [0.0, 0.0, 1.0], _SLIDE),
        ("base_yaw", RevoluteJoint, [0.0, 0.0, 1.0], _HINGE),
        ("base_pitch", RevoluteJoint, [0.0, 1.0, 0.0], _HINGE),
        ("base_roll", RevoluteJoint, [1.0, 0.0, 0.0], _HINGE),
    ):
        carriage = plant.AddRigidBody(name, base, _CARRIAGE)
        joint = plant.AddJoint(joint_type(name, frame, carriage.body_frame(), axis))
        plant.AddJointActuator(name, joint).set_controller_gains(gains)
        frame = carriage.body_frame()
    flat = RigidTransform(RotationMatrix(pitched_rotation(hand, 0.0)), np.zeros(3))
    plant.WeldFrames(frame, plant.GetFrameByName(hand.description.base, instance), flat)
    return base
