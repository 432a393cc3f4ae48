"""The simulated world: ARMAR-6 with its hand, a table, an object."""

import dataclasses as dc
from pathlib import Path

import numpy as np
from pydrake.geometry import (
    AddCompliantHydroelasticProperties,
    AddContactMaterial,
    Box,
    CollisionFilterDeclaration,
    GeometrySet,
    ProximityProperties,
    SceneGraph,
)
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import (
    AddMultibodyPlant,
    CoulombFriction,
    MultibodyPlant,
    MultibodyPlantConfig,
)
from pydrake.multibody.tree import (
    BodyIndex,
    Joint,
    JointIndex,
    ModelInstanceIndex,
    PdControllerGains,
    RigidBody,
)
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from vh_drake.control.kinematics import (
    TORSO_JOINT,
    TORSO_POSITION_M,
    arm_joint_names,
    home_configuration,
)
from vh_drake.geometry.robot_model import add_armar6
from vh_drake.hand.description import HandDescription, load_hand
from vh_drake.hand.mirror import mirrored_sdf
from vh_drake.hand.shipped import hand_file
from vh_drake.objects.drake_model import ContactModel, add_object
from vh_drake.objects.model import ObjectModel
from vh_drake.scenes.scenario import Scenario, Table

# Stiffness [N m/rad] and damping [N m s/rad] of the arm's joints, from the clavicle to the hand.
ARM_GAINS = (
    *((2000.0, 200.0),) * 4,
    *((1000.0, 80.0),) * 2,
    *((500.0, 30.0),) * 2,
)
HAND_LINK, LEFT_HAND_LINK = "hand_fixed_r1", "hand_fixed_r0"
TABLE_MODULUS_PA = 1e7
DISSIPATION_S_M = 5.0
TABLE_THICKNESS_M = 0.05


@dc.dataclass(frozen=True)
class World:
    """The plant and what finds in it the parts that the rest of the diagram needs.

    Parts by their index: a handle would keep the plant, which keeps this, for ever.
    """

    plant: MultibodyPlant
    scene_graph: SceneGraph
    robot: ModelInstanceIndex
    hand: ModelInstanceIndex
    wrist_index: JointIndex
    object_index: BodyIndex
    description: HandDescription
    left_hand: ModelInstanceIndex | None = None  # the mirrored hand, where there is one

    @property
    def wrist(self) -> Joint:
        """Between arm and hand."""
        return self.plant.get_joint(self.wrist_index)

    @property
    def object(self) -> RigidBody:
        """What is to be grasped."""
        return self.plant.get_body(self.object_index)


def add_world(builder: DiagramBuilder, scenario: Scenario, model: ObjectModel) -> World:
    """Add plant and scene graph with robot, table and object to `builder`, finalized."""
    contact: ContactModel = "hydroelastic" if scenario.contact == "hydroelastic" else "point"
    config = MultibodyPlantConfig(
        time_step=scenario.time_step_s,
        contact_model="hydroelastic_with_fallback" if contact == "hydroelastic" else contact,
        discrete_contact_approximation="lagged",
        # Wrench and acceleration are of one step either way; a plant that keeps its last step
        # copies the whole diagram's state in each.
        use_sampled_output_ports=False,
    )
    plant, scene_graph = AddMultibodyPlant(config, builder)
    robot = _add_robot(plant, left_hand=scenario.left_hand)
    description = load_hand(hand_file(scenario.hand))
    hand, wrist = _add_hand(plant, description)
    left_hand = _add_left_hand(plant, description) if scenario.left_hand else None
    add_table(plant, scenario.table)
    body = add_object(plant, model, contact=contact)
    plant.Finalize()
    _filter_hand_against_arm(plant, scene_graph, robot, hand)
    if left_hand is not None:
        _filter_hand_against_arm(plant, scene_graph, robot, left_hand)
        _hold_open(builder, plant, left_hand)
    return World(plant, scene_graph, robot, hand, wrist, body.index(), description, left_hand)


def default_hand() -> Path:
    """The description of the right hand of ARMAR-6."""
    return hand_file()


def add_table(plant: MultibodyPlant, table: Table) -> None:
    """A box welded to the world, its top at the table's height, and four legs to look at."""
    x, y = table.center
    sx, sy = table.size
    friction = CoulombFriction(table.friction, table.friction)
    properties = ProximityProperties()
    AddContactMaterial(friction=friction, properties=properties, dissipation=DISSIPATION_S_M)
    AddCompliantHydroelasticProperties(TABLE_THICKNESS_M, TABLE_MODULUS_PA, properties)
    X_WT = RigidTransform([x, y, table.height_m - TABLE_THICKNESS_M / 2])
    top = Box(sx, sy, TABLE_THICKNESS_M)
    world = plant.world_body()
    plant.RegisterCollisionGeometry(world, X_WT, top, "table", properties)
    plant.RegisterVisualGeometry(world, X_WT, top, "table", np.array([0.72, 0.58, 0.42, 1.0]))
    leg_height = table.height_m - TABLE_THICKNESS_M
    if leg_height <= 0.0:  # The top lies on the floor.
        return
    for i, (dx, dy) in enumerate(((-1, -1), (-1, 1), (1, -1), (1, 1))):
        p = [x + dx * (sx / 2 - 0.03), y + dy * (sy / 2 - 0.03), leg_height / 2]
        leg = Box(0.05, 0.05, leg_height)
        color = np.array([0.35, 0.35, 0.37, 1.0])
        plant.RegisterVisualGeometry(world, RigidTransform(p), leg, f"table_leg_{i}", color)


def _add_robot(plant: MultibodyPlant, *, left_hand: bool) -> ModelInstanceIndex:
    """ARMAR-6 with its torso and left arm at rest and servos in its right arm."""
    fixed = dict(zip(arm_joint_names("left"), home_configuration("left"), strict=True))
    fixed[TORSO_JOINT] = TORSO_POSITION_M
    # The rigid left hand is a mesh of the robot's own; an articulated one takes its place.
    bare = (LEFT_HAND_LINK,) if left_hand else ()
    robot = add_armar6(plant, fixed_joints=fixed, bare_links=bare)
    names = arm_joint_names("right")
    actuators = {
        plant.get_joint_actuator(index).joint().name(): plant.get_joint_actuator(index)
        for index in plant.GetJointActuatorIndices()
    }
    for name, q, (p, d) in zip(names, home_configuration("right"), ARM_GAINS, strict=True):
        actuators[name].set_controller_gains(PdControllerGains(p=p, d=d))
        plant.GetJointByName(name).set_default_angle(q)
    return robot


def _add_hand(
    plant: MultibodyPlant, description: HandDescription
) -> tuple[ModelInstanceIndex, JointIndex]:
    (hand,) = Parser(plant, "right").AddModels(description.model)
    wrist = plant.WeldFrames(
        plant.GetFrameByName(HAND_LINK), plant.GetFrameByName(description.base, hand)
    )
    return hand, wrist.index()


def _add_left_hand(plant: MultibodyPlant, description: HandDescription) -> ModelInstanceIndex:
    """The mirror image of the right hand."""
    sdf = mirrored_sdf(Path(description.model).read_text())
    (hand,) = Parser(plant, "left").AddModelsFromString(sdf, "sdf")
    base = plant.GetFrameByName(description.base, hand)
    plant.WeldFrames(plant.GetFrameByName(LEFT_HAND_LINK), base)
    return hand


def _hold_open(builder: DiagramBuilder, plant: MultibodyPlant, hand: ModelInstanceIndex) -> None:
    """Motors without a task keep their tendons slack."""
    servos = plant.get_desired_state_input_port(hand)
    still = builder.AddNamedSystem("left_hand_open", ConstantVectorSource(np.zeros(servos.size())))
    builder.Connect(still.get_output_port(), servos)


def _filter_hand_against_arm(
    plant: MultibodyPlant,
    scene_graph: SceneGraph,
    robot: ModelInstanceIndex,
    hand: ModelInstanceIndex,
) -> None:
    """The hand meets the forearm in its wrist; both never reach the rest of the robot."""
    sets = [
        GeometrySet(
            [plant.GetBodyFrameIdOrThrow(index) for index in plant.GetBodyIndices(instance)]
        )
        for instance in (robot, hand)
    ]
    declaration = CollisionFilterDeclaration().ExcludeBetween(*sets)
    scene_graph.collision_filter_manager().Apply(declaration)
