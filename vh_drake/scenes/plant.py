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
from pydrake.multibody.tree import Joint, ModelInstanceIndex, PdControllerGains, RigidBody
from pydrake.systems.framework import DiagramBuilder

from vh_drake.control.kinematics import (
    TORSO_JOINT,
    TORSO_POSITION_M,
    arm_joint_names,
    home_configuration,
)
from vh_drake.geometry.model_files import models_folder
from vh_drake.geometry.robot_model import add_armar6
from vh_drake.hand.description import HandDescription, load_hand
from vh_drake.objects.drake_model import add_object
from vh_drake.objects.model import ObjectModel
from vh_drake.scenes.scenario import Scenario, Table

# Stiffness [N m/rad] and damping [N m s/rad] of the arm's joints, from the clavicle to the hand.
ARM_GAINS = (
    *((2000.0, 200.0),) * 4,
    *((1000.0, 80.0),) * 2,
    *((500.0, 30.0),) * 2,
)
TABLE_MODULUS_PA = 1e7
DISSIPATION_S_M = 5.0
TABLE_THICKNESS_M = 0.05


@dc.dataclass(frozen=True)
class World:
    """The plant and the handles that the rest of the diagram needs."""

    plant: MultibodyPlant
    scene_graph: SceneGraph
    robot: ModelInstanceIndex
    hand: ModelInstanceIndex
    wrist: Joint  # between arm and hand
    object: RigidBody
    description: HandDescription


def add_world(builder: DiagramBuilder, scenario: Scenario, model: ObjectModel) -> World:
    """Add plant and scene graph with robot, table and object to `builder`, finalized."""
    config = MultibodyPlantConfig(
        time_step=scenario.time_step_s,
        contact_model=(
            "hydroelastic_with_fallback" if scenario.contact == "hydroelastic" else "point"
        ),
        discrete_contact_approximation="lagged",
    )
    plant, scene_graph = AddMultibodyPlant(config, builder)
    robot = _add_robot(plant)
    description = load_hand(scenario.hand or default_hand())
    hand, wrist = _add_hand(plant, description)
    add_table(plant, scenario.table)
    body = add_object(plant, model, contact=scenario.contact)
    plant.Finalize()
    _filter_hand_against_arm(plant, scene_graph, robot, hand)
    return World(plant, scene_graph, robot, hand, wrist, body, description)


def default_hand() -> Path:
    """The description of the right hand of ARMAR-6."""
    return models_folder() / "armar6_hand" / "armar6_hand.yaml"


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
    for i, (dx, dy) in enumerate(((-1, -1), (-1, 1), (1, -1), (1, 1))):
        p = [x + dx * (sx / 2 - 0.03), y + dy * (sy / 2 - 0.03), leg_height / 2]
        leg = Box(0.05, 0.05, leg_height)
        color = np.array([0.35, 0.35, 0.37, 1.0])
        plant.RegisterVisualGeometry(world, RigidTransform(p), leg, f"table_leg_{i}", color)


def _add_robot(plant: MultibodyPlant) -> ModelInstanceIndex:
    """ARMAR-6 with its torso and left arm at rest and servos in its right arm."""
    fixed = dict(zip(arm_joint_names("left"), home_configuration("left"), strict=True))
    robot = add_armar6(plant, fixed_joints=fixed | {TORSO_JOINT: TORSO_POSITION_M})
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
) -> tuple[ModelInstanceIndex, Joint]:
    (hand,) = Parser(plant, "right").AddModels(description.model)
    wrist = plant.WeldFrames(
        plant.GetFrameByName("hand_fixed_r1"), plant.GetFrameByName(description.base, hand)
    )
    return hand, wrist


def _filter_hand_against_arm(
    plant: MultibodyPlant,
    scene_graph: SceneGraph,
    robot: ModelInstanceIndex,
    hand: ModelInstanceIndex,
) -> None:
    """The hand meets the forearm in its wrist; both never reach the rest of the robot."""
    sets = [
        GeometrySet(
            [
                plant.GetBodyFrameIdOrThrow(index)
                for index in plant.GetBodyIndices(instance)
            ]
        )
        for instance in (robot, hand)
    ]
    declaration = CollisionFilterDeclaration().ExcludeBetween(*sets)
    scene_graph.collision_filter_manager().Apply(declaration)
