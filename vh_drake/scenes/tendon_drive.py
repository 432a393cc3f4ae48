"""A hand's motors in a plant, driven by `TendonHand`."""

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import MatrixGain

from vh_drake.hand.description import HandDescription
from vh_drake.hand.model import HandModel
from vh_drake.systems.tendon_hand import Command, TendonHand


def add_tendon_drive(
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    instance: ModelInstanceIndex,
    hand: HandModel,
    command: Command = "position",
) -> None:
    """Drive the motors of a hand; the rest of the hand's state is not measured.

    Exports `motor_command`, and `motor_fraction`, `tendon_force` and `finger_joints`, as
    `TendonHand` has them.

    Args:
        builder: of the diagram that the plant is in.
        plant: finalized.
        instance: of the hand in it.
        hand: what the drive knows of it.
        command: travel or pull.
    """
    drive = builder.AddNamedSystem("tendon_hand", TendonHand(hand, command))
    encoders = _motor_encoders(plant, instance, hand.description)
    state = builder.AddNamedSystem("motor_encoders", encoders)
    builder.Connect(plant.get_state_output_port(instance), state.get_input_port())
    builder.Connect(state.get_output_port(), drive.GetInputPort("motor_state"))
    builder.Connect(
        plant.get_net_actuation_output_port(instance), drive.GetInputPort("motor_force")
    )
    builder.Connect(
        drive.GetOutputPort("motor_set_point"), plant.get_desired_state_input_port(instance)
    )
    builder.ExportInput(drive.GetInputPort("motor_command"), "motor_command")
    for port in ("motor_fraction", "tendon_force", "finger_joints"):
        builder.ExportOutput(drive.GetOutputPort(port), port)


def _motor_encoders(
    plant: MultibodyPlant, instance: ModelInstanceIndex, description: HandDescription
) -> MatrixGain:
    """Picks positions and velocities of the motors out of the hand's state."""
    joints = [plant.GetJointByName(motor.joint, instance) for motor in description.motors]
    own = plant.GetJointIndices(instance)
    positions = [
        plant.get_joint(i).position_start() for i in own if plant.get_joint(i).num_positions()
    ]
    velocities = [
        plant.get_joint(i).velocity_start() for i in own if plant.get_joint(i).num_velocities()
    ]
    rows = [joint.position_start() - min(positions) for joint in joints]
    rows += [len(positions) + joint.velocity_start() - min(velocities) for joint in joints]
    return MatrixGain(np.eye(len(positions) + len(velocities))[rows])
