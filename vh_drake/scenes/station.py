"""The robot as its hardware would look: commands in, sensors out."""

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem

from vh_drake.control.kinematics import ArmKinematics
from vh_drake.hand.model import HandModel, read_hand_model
from vh_drake.objects.model import ObjectModel
from vh_drake.scenes.camera import make_depth_camera
from vh_drake.scenes.plant import World, add_world
from vh_drake.scenes.scenario import Scenario
from vh_drake.scenes.tendon_drive import add_tendon_drive
from vh_drake.systems.cartesian_velocity_controller import CartesianVelocityController
from vh_drake.systems.collectable import Collectable
from vh_drake.systems.gravity_compensation import GravityCompensation
from vh_drake.systems.hand_state import HandState
from vh_drake.systems.joint_velocity_integrator import JointVelocityIntegrator
from vh_drake.systems.nullspace_controller import NullspaceController
from vh_drake.systems.wrist_sensor import WristSensor

CAMERA_BODY = "upper_neck"
CAMERA_PITCH_RAD = np.deg2rad(52.0)
CAMERA_YAW_RAD = np.deg2rad(-30.0)
P_NECK_CAMERA = (0.0, 0.26, 0.21)


def camera_pose_in_neck() -> RigidTransform:
    """Optical frame (+z forward, +y down) in the head's frame: towards the table's near right."""
    # The neck's axes are x left, y up, z forward.
    forward_left_up = RotationMatrix(np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]]))
    look = RollPitchYaw(0.0, CAMERA_PITCH_RAD, CAMERA_YAW_RAD).ToRotationMatrix()
    optical = RotationMatrix(np.array([[0.0, 0, 1], [-1, 0, 0], [0, -1, 0]]))
    return RigidTransform(forward_left_up @ look @ optical, P_NECK_CAMERA)


class Station(Diagram, metaclass=Collectable):
    """Plant, sensors and low-level control; the ports exist on the real robot.

    | port              | direction | type           | unit       | meaning                       |
    |-------------------|-----------|----------------|------------|-------------------------------|
    | spatial_velocity  | in        | vector (6)     | rad/s, m/s | wanted [w; v] of H in W       |
    | motor_command     | in        | vector (k)     | -          | wanted travel of the motors   |
    | cloud             | out       | Cloud          | m          | what the head camera sees     |
    | depth_image       | out       | ImageDepth32F  | m          | the same as an image          |
    | commanded_state   | out       | vector (16)    | rad, rad/s | of the arm's servos           |
    | commanded_pose    | out       | RigidTransform | m          | X_WH of it                    |
    | joint_state       | out       | vector (16)    | rad, rad/s | measured                      |
    | hand_pose         | out       | RigidTransform | m          | X_WH of it                    |
    | hand_velocity     | out       | vector (6)     | rad/s, m/s | [w; v] of H in W              |
    | hand_acceleration | out       | vector (6)     | *          | its rate, rad/s², m/s²        |
    | wrist_wrench      | out       | vector (6)     | N m, N     | [torque; force] about Ho in H |
    | motor_fraction    | out       | vector (k)     | -          | measured travel of the motors |
    | tendon_force      | out       | vector (f)     | N          | in each finger's tendon       |
    | finger_joints     | out       | vector (n)     | rad        | estimated from the motors     |
    | ground_truth      | out       | vector         | SI         | plant state; for judges only  |
    | query_object      | out       | QueryObject    | -          | geometry; for pictures only   |
    """

    world: World
    hand: HandModel
    kinematics: ArmKinematics


def make_station(scenario: Scenario, model: ObjectModel) -> Station:
    """The simulated robot before its table.

    The object's pose is set in a Context by `vh_drake.scenes.placing`.
    """
    builder = DiagramBuilder()
    world = add_world(builder, scenario, model)
    hand = read_hand_model(world.description)
    kinematics = ArmKinematics("right", hand_kg=hand.mass_kg, p_HHand=hand.p_HCom)
    _add_arm(builder, world.plant, world, kinematics)
    add_tendon_drive(builder, world.plant, world.hand, hand)
    _add_sensors(builder, world, scenario)
    station = Station()
    builder.ExportOutput(world.plant.get_state_output_port(), "ground_truth")
    builder.ExportOutput(world.scene_graph.get_query_output_port(), "query_object")
    builder.BuildInto(station)
    station.set_name("station")
    station.world, station.hand, station.kinematics = world, hand, kinematics
    return station


def _connect(
    builder: DiagramBuilder, source: LeafSystem, output: str, sink: LeafSystem, port: str
) -> None:
    builder.Connect(source.GetOutputPort(output), sink.GetInputPort(port))


def _add_arm(
    builder: DiagramBuilder, plant: MultibodyPlant, world: World, kinematics: ArmKinematics
) -> None:
    """Spatial velocity -> joint velocities -> servo set points, gravity held up by a model."""
    cartesian = builder.AddNamedSystem(
        "cartesian_velocity_controller", CartesianVelocityController(kinematics)
    )
    nullspace = builder.AddNamedSystem("nullspace_controller", NullspaceController(kinematics))
    integrator = builder.AddNamedSystem(
        "joint_velocity_integrator", JointVelocityIntegrator(kinematics)
    )
    gravity = builder.AddNamedSystem("gravity_compensation", GravityCompensation(kinematics))
    commanded = builder.AddNamedSystem("commanded_hand", HandState(kinematics))
    measured = builder.AddNamedSystem("measured_hand", HandState(kinematics))
    builder.ExportInput(cartesian.GetInputPort("spatial_velocity"), "spatial_velocity")
    _connect(builder, cartesian, "joint_velocity", nullspace, "joint_velocity")
    _connect(builder, nullspace, "joint_velocity", integrator, "joint_velocity")
    for sink in (cartesian, nullspace, commanded, gravity):
        _connect(builder, integrator, "desired_state", sink, "joint_state")
    desired = integrator.GetOutputPort("desired_state")
    builder.Connect(desired, plant.get_desired_state_input_port(world.robot))
    builder.Connect(gravity.GetOutputPort("torque"), plant.get_actuation_input_port(world.robot))
    joint_state = plant.get_state_output_port(world.robot)
    builder.Connect(joint_state, measured.GetInputPort("joint_state"))
    builder.Connect(
        plant.get_generalized_acceleration_output_port(world.robot),
        measured.GetInputPort("joint_acceleration"),
    )
    builder.ExportOutput(desired, "commanded_state")
    builder.ExportOutput(joint_state, "joint_state")
    builder.ExportOutput(commanded.GetOutputPort("hand_pose"), "commanded_pose")
    builder.ExportOutput(measured.GetOutputPort("hand_pose"), "hand_pose")
    builder.ExportOutput(measured.GetOutputPort("hand_velocity"), "hand_velocity")
    builder.ExportOutput(measured.GetOutputPort("hand_acceleration"), "hand_acceleration")


def _add_sensors(builder: DiagramBuilder, world: World, scenario: Scenario) -> None:
    plant = world.plant
    wrist = builder.AddNamedSystem(
        "wrist_sensor", WristSensor(plant, world.wrist, scenario.wrist, scenario.seed)
    )
    builder.Connect(plant.get_reaction_forces_output_port(), wrist.GetInputPort("reaction_forces"))
    builder.ExportOutput(wrist.GetOutputPort("wrist_wrench"), "wrist_wrench")
    neck = plant.GetBodyFrameIdOrThrow(plant.GetBodyByName(CAMERA_BODY).index())
    camera = make_depth_camera(
        builder, world.scene_graph, neck, camera_pose_in_neck(), scenario.camera, scenario.seed
    )
    builder.ExportOutput(camera.GetOutputPort("cloud"), "cloud")
    builder.ExportOutput(camera.GetOutputPort("depth_image"), "depth_image")
