"""Whether a motion of the arm is free of collisions: with the robot itself, and with the table."""

import dataclasses as dc
from pathlib import Path

import numpy as np
from pydrake.geometry import Box, CollisionFilterDeclaration, GeometrySet
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import (
    AddMultibodyPlant,
    CoulombFriction,
    MultibodyPlant,
    MultibodyPlantConfig,
)
from pydrake.multibody.tree import PrismaticJoint, SpatialInertia
from pydrake.systems.framework import DiagramBuilder

from vh_drake.control.kinematics import (
    SUFFIX,
    TORSO_JOINT,
    ArmKinematics,
    Side,
    arm_joint_names,
    home_configuration,
)
from vh_drake.geometry.robot_model import add_armar6
from vh_drake.types import Array

DEEPER_M = 0.005  # than shapes may overlap: the hand skims the table
STEP_RAD = 0.05  # between looks at a motion, of the fastest joint
_THICK_M = 0.05
# They meet the hand in its wrist.
_WRIST_STEMS = ("t67", "t78", "t8")


@dc.dataclass(frozen=True)
class TableTop:
    """The table as far as it is known: where it lies. Its height is seen."""

    center: tuple[float, float] = (0.85, -0.2)  # x, y [m]
    size: tuple[float, float] = (0.6, 1.4)  # along x, y [m]


@dc.dataclass(frozen=True)
class Collision:
    """The first one of a motion."""

    index: int  # of the joint positions
    bodies: tuple[str, str]


class ArmCollisions:
    """An arm with its open hand, among torso, head, platform, the other arm and a table.

    Neighbouring links and such as overlap at home don't count.

    Args:
        kinematics: of the arm.
        hand_model: model file of its hand.
        hand_base: link of the hand that is welded to the wrist.
        table: where it lies.
    """

    def __init__(
        self,
        kinematics: ArmKinematics,
        hand_model: str | Path,
        hand_base: str,
        table: TableTop | None = None,
    ) -> None:
        self._kinematics = kinematics
        builder = DiagramBuilder()
        # Of what AddMultibodyPlantSceneGraph makes, Drake 1.51 never frees a part.
        config = MultibodyPlantConfig(time_step=0.0)
        self._plant, self._scene_graph = AddMultibodyPlant(config, builder)
        _add_robot(self._plant, kinematics, str(hand_model), hand_base)
        _add_table(self._plant, table or TableTop())
        self._plant.Finalize()
        self._diagram = builder.Build()
        self._filter(hand_base)
        self._root = self._diagram.CreateDefaultContext()
        self._own = self._plant.GetMyMutableContextFromRoot(self._root)
        self._arm = [
            self._plant.GetJointByName(name).position_start() for name in kinematics.joint_names
        ]
        self._height = self._plant.GetJointByName("table_height").position_start()
        self._ignored: frozenset[tuple[str, str]] = frozenset()
        self._ignored = frozenset(self._overlaps(kinematics.home, -1.0))

    def first(self, q: Array, table_height_m: float) -> Collision | None:
        """The first collision on the way through joint positions (n, 8) [rad], if any.

        Args:
            q: rows that follow each other closely; the last one is always looked at.
            table_height_m: of the table's top over the floor.
        """
        for index in self._looks(np.asarray(q, float)):
            found = self._overlaps(q[index], table_height_m)
            if found:
                return Collision(index, found[0])
        return None

    def _looks(self, q: Array) -> list[int]:
        """Rows among which no joint turns by more than a step where that can be had."""
        looks, last = [0], q[0]
        for index in range(1, len(q)):
            if np.abs(q[index] - last).max() > STEP_RAD:
                looks.append(index)
                last = q[index]
        return looks if looks[-1] == len(q) - 1 else [*looks, len(q) - 1]

    def _overlaps(self, q: Array, table_height_m: float) -> list[tuple[str, str]]:
        positions = self._plant.GetPositions(self._own)
        positions[self._arm], positions[self._height] = q, table_height_m
        self._plant.SetPositions(self._own, positions)
        query = self._plant.get_geometry_query_input_port().Eval(self._own)
        pairs = [
            (self._body(pair.id_A), self._body(pair.id_B))
            for pair in query.ComputePointPairPenetration()
            if pair.depth > DEEPER_M
        ]
        named = [(min(pair), max(pair)) for pair in pairs]
        return sorted({pair for pair in named if pair not in self._ignored})

    def _body(self, geometry: object) -> str:
        inspector = self._scene_graph.model_inspector()
        name: str = self._plant.GetBodyFromFrameId(inspector.GetFrameId(geometry)).name()
        return name

    def _filter(self, hand_base: str) -> None:
        """The open hand meets itself and the wrist; what stands still can't collide."""
        plant, manager = self._plant, self._scene_graph.collision_filter_manager()
        instance = plant.GetBodyByName(hand_base).model_instance()
        hand = [plant.GetBodyFrameIdOrThrow(i) for i in plant.GetBodyIndices(instance)]
        suffix = SUFFIX[self._kinematics.side]
        wrist = [
            plant.GetBodyFrameIdOrThrow(plant.GetBodyByName(f"arm_{stem}_{suffix}").index())
            for stem in _WRIST_STEMS
        ]
        robot = plant.GetBodyByName("torso").model_instance()
        still = [
            plant.GetBodyFrameIdOrThrow(i)
            for i in plant.GetBodyIndices(robot)
            if plant.IsAnchored(plant.get_body(i))
        ]
        table = plant.GetBodyFrameIdOrThrow(plant.GetBodyByName("table").index())
        declaration = CollisionFilterDeclaration()
        declaration.ExcludeWithin(GeometrySet(hand))
        declaration.ExcludeBetween(GeometrySet(hand), GeometrySet(wrist))
        declaration.ExcludeWithin(GeometrySet([*still, table]))
        manager.Apply(declaration)


def _add_robot(
    plant: MultibodyPlant, kinematics: ArmKinematics, hand_model: str, hand_base: str
) -> None:
    """All but the arm stands still."""
    other: Side = "left" if kinematics.side == "right" else "right"
    fixed = dict(zip(arm_joint_names(other), home_configuration(other), strict=True))
    fixed[TORSO_JOINT] = kinematics.torso_position_m
    add_armar6(plant, fixed_joints=fixed, visuals=False)
    (hand,) = Parser(plant, "hand").AddModels(hand_model)
    wrist = plant.GetFrameByName(f"hand_fixed_{SUFFIX[kinematics.side]}")
    plant.WeldFrames(wrist, plant.GetFrameByName(hand_base, hand))


def _add_table(plant: MultibodyPlant, table: TableTop) -> None:
    """A slab that goes up and down, its top at the joint's position."""
    instance = plant.AddModelInstance("table")
    inertia = SpatialInertia.SolidSphereWithMass(1.0, 0.1)
    body = plant.AddRigidBody("table", instance, inertia)
    joint = PrismaticJoint("table_height", plant.world_frame(), body.body_frame(), [0.0, 0.0, 1.0])
    plant.AddJoint(joint)
    X_BT = RigidTransform([*table.center, -_THICK_M / 2])
    slab = Box(*table.size, _THICK_M)
    plant.RegisterCollisionGeometry(body, X_BT, slab, "top", CoulombFriction(0.0, 0.0))
