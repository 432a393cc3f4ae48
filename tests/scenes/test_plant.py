import dataclasses as dc

import numpy as np
import pytest
from pydrake.geometry import Role
from pydrake.multibody.plant import ContactModel
from pydrake.systems.framework import DiagramBuilder

from vh_drake.control.kinematics import ArmKinematics
from vh_drake.hand.model import read_hand_model
from vh_drake.objects.loading import load_object
from vh_drake.scenes.plant import ARM_GAINS, add_world
from vh_drake.scenes.scenario import Scenario, Table

MODEL = load_object("fruit_drink")
SCENARIO = Scenario(contact="point")


def built(scenario=SCENARIO):
    builder = DiagramBuilder()
    world = add_world(builder, scenario, MODEL)
    return world, builder.Build()


@pytest.fixture(scope="module")
def world():
    return built()


def test_the_arm_starts_at_home_with_its_servos_gains(world):
    world, diagram = world
    root = diagram.CreateDefaultContext()
    context = world.plant.GetMyContextFromRoot(root)
    kinematics = ArmKinematics("right")
    np.testing.assert_allclose(
        world.plant.GetPositions(context, world.robot), kinematics.home, atol=1e-12
    )
    for name, (p, d) in zip(kinematics.joint_names, ARM_GAINS, strict=True):
        joint = world.plant.GetJointByName(name)
        (gains,) = (
            world.plant.get_joint_actuator(i).get_controller_gains()
            for i in world.plant.GetJointActuatorIndices()
            if world.plant.get_joint_actuator(i).joint().index() == joint.index()
        )
        assert (gains.p, gains.d) == (p, d)


def test_the_hand_hangs_on_the_wrist_where_the_arm_s_kinematics_says(world):
    world, diagram = world
    root = diagram.CreateDefaultContext()
    context = world.plant.GetMyContextFromRoot(root)
    palm = world.plant.GetBodyByName(world.description.base, world.hand)
    pose = world.plant.EvalBodyPoseInWorld(context, palm).GetAsMatrix4()
    kinematics = ArmKinematics("right")
    np.testing.assert_allclose(pose, kinematics.pose(kinematics.home), atol=1e-9)
    assert world.wrist.child_body().index() == palm.index()


def test_the_hand_s_mass_is_that_of_the_gravity_model(world):
    world, diagram = world
    root = diagram.CreateDefaultContext()
    context = world.plant.GetMyContextFromRoot(root)
    bare = ArmKinematics("right")
    torques = world.plant.CalcGravityGeneralizedForces(context)
    arm = [world.plant.GetJointByName(name).velocity_start() for name in bare.joint_names]
    np.testing.assert_allclose(-torques[arm], bare.gravity_torques(bare.home), atol=0.05)


def test_hand_and_arm_never_collide_with_each_other_but_with_the_table_both(world):
    world, _ = world
    inspector, plant = world.scene_graph.model_inspector(), world.plant

    def shapes(body):
        return inspector.GetGeometries(plant.GetBodyFrameIdOrThrow(body), Role.kProximity)

    def collide(bodies, others):
        return [
            not inspector.CollisionFiltered(a, b)
            for body in bodies
            for other in others
            for a in shapes(body)
            for b in shapes(other)
        ]

    hand, robot = (plant.GetBodyIndices(model) for model in (world.hand, world.robot))
    table = [plant.world_body().index()]
    assert not any(collide(hand, robot))
    assert all(collide(hand, table))
    assert all(collide(hand, [world.object.index()]))


def test_the_table_s_top_is_where_the_scenario_says():
    table = Table(height_m=0.8, center=[0.9, 0.1], size=[0.4, 0.6])
    world, diagram = built(dc.replace(SCENARIO, table=table))
    root = diagram.CreateDefaultContext()
    query = world.scene_graph.get_query_output_port().Eval(
        world.scene_graph.GetMyContextFromRoot(root)
    )
    corners = np.array([[0.71, -0.19, 0.81], [1.09, 0.39, 0.81], [0.6, 0.1, 0.79]])
    inspector = world.scene_graph.model_inspector()
    (top,) = (
        geometry
        for geometry in inspector.GetAllGeometryIds(Role.kProximity)
        if inspector.GetName(geometry).endswith("table")
    )
    found = [
        next(d.distance for d in query.ComputeSignedDistanceToPoint(corner) if d.id_G == top)
        for corner in corners
    ]
    np.testing.assert_allclose(found, [0.01, 0.01, 0.1], atol=1e-9)


def test_contact_is_computed_as_the_scenario_asks(world):
    assert world[0].plant.get_contact_model() == ContactModel.kPoint
    other, _ = built(dc.replace(SCENARIO, contact="hydroelastic"))
    assert other.plant.get_contact_model() == ContactModel.kHydroelasticWithFallback


def test_a_left_hand_has_its_own_motors_and_the_rigid_one_is_not_shown():
    with_left, _ = built(dc.replace(SCENARIO, left_hand=True))
    plant, inspector = with_left.plant, with_left.scene_graph.model_inspector()
    model = read_hand_model(with_left.description)
    assert plant.num_actuated_dofs(with_left.left_hand) == len(model.description.motors)
    frame = plant.GetBodyFrameIdOrThrow(plant.GetBodyByName("hand_fixed_r0").index())
    assert inspector.GetGeometries(frame, Role.kIllustration) == []
    palm = plant.GetBodyByName(with_left.description.base, with_left.left_hand)
    shown = inspector.GetGeometries(plant.GetBodyFrameIdOrThrow(palm.index()), Role.kIllustration)
    assert len(shown) > 0
