"""The wrist feels a foam brick before it has been pushed away, in simulated physics."""

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.geometry import (
    AddCompliantHydroelasticProperties,
    AddContactMaterial,
    AddRigidHydroelasticProperties,
    Box,
    ProximityProperties,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import PdControllerGains, PrismaticJoint, SpatialInertia, WeldJoint
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.primitives import ConstantVectorSource

import vh_drake
from vh_drake.scenes.wrist import hand_inertia
from vh_drake.sensing.contact_point import capsule_skin
from vh_drake.systems.ft_contact_estimator import FtContactEstimator
from vh_drake.systems.wrist_sensor import WristSensor

HAND = f"{vh_drake.__path__[0]}/models/armar6_hand/armar6_hand.sdf"
SPEED, TARE_S, WAIT_S = 0.03, 0.8, 0.3  # [m/s], [s], [s]
SIZE = (0.05, 0.08, 0.05)  # of the brick [m]
GAP = 0.05  # between fingertip and brick at the start [m]


class Commands(LeafSystem):
    """A steady approach along x, one tare on the way, and the hand's pose and velocity."""

    def __init__(self, hand: int) -> None:
        super().__init__()
        poses = self.DeclareAbstractInputPort("poses", Value[list[RigidTransform]]([]))
        speeds = self.DeclareAbstractInputPort("speeds", Value[list[SpatialVelocity]]([]))

        def slide(context, output):
            moving = max(0.0, context.get_time() - WAIT_S)
            output.SetFromVector([SPEED * moving, SPEED * (moving > 0.0)])

        self.DeclareVectorOutputPort("slide", 2, slide)
        self.DeclareVectorOutputPort(
            "tare", 1, lambda c, out: out.SetFromVector([float(c.get_time() > TARE_S)])
        )
        self.DeclareAbstractOutputPort(
            "pose",
            lambda: Value(RigidTransform()),
            lambda c, out: out.set_value(poses.Eval(c)[hand]),
        )
        self.DeclareVectorOutputPort(
            "velocity", 6, lambda c, out: out.SetFromVector(speeds.Eval(c)[hand].get_coeffs())
        )


def properties(*, soft: bool) -> ProximityProperties:
    made = ProximityProperties()
    AddContactMaterial(friction=CoulombFriction(0.5, 0.5), dissipation=5.0, properties=made)
    if soft:
        AddCompliantHydroelasticProperties(0.02, 1e7, made)
    else:
        AddRigidHydroelasticProperties(0.02, made)
    return made


def add_bodies(plant, mass):
    """The hand on a slide, palm ahead and fingers down, before a brick on a table."""
    hand = Parser(plant).AddModels(HAND)[0]
    mount_model = plant.AddModelInstance("mount")
    mount = plant.AddRigidBody("mount", mount_model, SpatialInertia.SolidSphereWithMass(5.0, 0.05))
    slide = plant.AddJoint(
        PrismaticJoint("slide", plant.world_frame(), mount.body_frame(), [1.0, 0.0, 0.0])
    )
    plant.AddJointActuator("slide", slide).set_controller_gains(PdControllerGains(p=2e4, d=1e3))
    palm = plant.GetBodyByName("hand_palm", hand)
    X_MH = RigidTransform(RotationMatrix.MakeYRotation(2.4), [0.0, 0.0, 0.14])
    wrist = plant.AddJoint(WeldJoint("wrist", mount.body_frame(), palm.body_frame(), X_MH))
    inertia = SpatialInertia.SolidBoxWithMass(mass, *SIZE)
    brick = plant.AddRigidBody("brick", plant.AddModelInstance("brick"), inertia)
    plant.RegisterCollisionGeometry(
        brick, RigidTransform(), Box(*SIZE), "brick", properties(soft=False)
    )
    plant.RegisterCollisionGeometry(
        plant.world_body(),
        RigidTransform([0, 0, -0.05]),
        Box(3, 3, 0.1),
        "table",
        properties(soft=True),
    )
    plant.Finalize()
    return hand, mount_model, palm, wrist, brick


def build(mass):
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, 0.002)
    hand, mount_model, palm, wrist, brick = add_bodies(plant, mass)
    context = plant.CreateDefaultContext()
    tip = plant.GetBodyByName("middle_distal").body_frame()
    axis_T = np.array([[0.0, 0.0, 0.0], [-0.0005, 0.0, 0.029]]).T
    axis_H = plant.CalcPointsPositions(context, tip, axis_T, palm.body_frame()).T
    inertia = hand_inertia(plant, context, palm, plant.GetBodyIndices(hand))
    sensor = builder.AddSystem(WristSensor(plant, wrist, seed=1))
    estimator = builder.AddSystem(FtContactEstimator(capsule_skin(*axis_H, 0.0086), inertia))
    commands = builder.AddSystem(Commands(int(palm.index())))
    still = builder.AddSystem(ConstantVectorSource(np.zeros(2 * plant.num_actuators(hand))))
    ahead = builder.AddSystem(ConstantVectorSource([1.0, 0.0, 0.0]))
    for source, target in (
        (plant.get_reaction_forces_output_port(), sensor.get_input_port()),
        (plant.get_body_poses_output_port(), commands.GetInputPort("poses")),
        (plant.get_body_spatial_velocities_output_port(), commands.GetInputPort("speeds")),
        (commands.GetOutputPort("slide"), plant.get_desired_state_input_port(mount_model)),
        (still.get_output_port(), plant.get_desired_state_input_port(hand)),
        (sensor.get_output_port(), estimator.GetInputPort("wrist_wrench")),
        (commands.GetOutputPort("pose"), estimator.GetInputPort("hand_pose")),
        (commands.GetOutputPort("velocity"), estimator.GetInputPort("hand_velocity")),
        (commands.GetOutputPort("tare"), estimator.GetInputPort("tare")),
        (ahead.get_output_port(), estimator.GetInputPort("approach_direction")),
    ):
        builder.Connect(source, target)
    p_WT = plant.CalcPointsPositions(context, tip, axis_T[:, 1:], plant.world_frame()).ravel()
    place = np.array([p_WT[0] + 0.0086 + 0.5 * SIZE[0] + GAP, p_WT[1], 0.5 * SIZE[2]])
    return builder.Build(), plant, brick, estimator, place


@pytest.mark.parametrize("mass", [0.028, 0.066])
def test_a_light_object_is_felt_before_it_has_moved_two_millimetres(mass):
    diagram, plant, brick, estimator, place = build(mass)
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    plant_context = plant.GetMyMutableContextFromRoot(context)
    plant.SetFreeBodyPose(plant_context, brick, RigidTransform(place))
    mine = estimator.GetMyContextFromRoot(context)
    while not estimator.GetOutputPort("contact").Eval(mine)[0] and context.get_time() < 3.0:
        simulator.AdvanceTo(context.get_time() + 0.01)
    found = estimator.GetOutputPort("contact_point").Eval(mine)
    moved = plant.EvalBodyPoseInWorld(plant_context, brick).translation() - place
    assert context.get_time() > WAIT_S + GAP / SPEED  # not before they meet
    assert len(found) == 1
    assert np.linalg.norm(moved) < 0.002
    face_x = place[0] + moved[0] - 0.5 * SIZE[0]
    assert abs(found.p_WC[0, 0] - face_x) < 0.004
    assert abs(found.p_WC[0, 1] - place[1]) < 0.008
    assert np.rad2deg(np.arccos(-found.n_WC[0, 0])) < 20.0
