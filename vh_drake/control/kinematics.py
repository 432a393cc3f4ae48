"""Kinematics of one arm of ARMAR-6: pose and Jacobian of the hand, limits, gravity torques."""

from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame, RevoluteJoint, SpatialInertia
from pydrake.systems.framework import Context

from vh_drake.control import kernels
from vh_drake.errors import UnknownName
from vh_drake.geometry.robot_model import add_armar6
from vh_drake.types import Array

Side = Literal["right", "left"]
Point = Sequence[float] | Array  # (3,)

JOINT_STEMS = ("t12", "t23", "t34", "t45", "t56", "t67", "t78", "t8")
SUFFIX: dict[Side, str] = {"right": "r1", "left": "r0"}
TORSO_JOINT = "torso_joint"

# The height from which the hand reaches most headings over a table of 0.9 m.
TORSO_POSITION_M = 0.0
# The power grasp's centre at (0.42, -0.5, 1.15), fingers 50 degrees to the left and 46 degrees
# down: from here the controllers reach nearly every pose around (0.7, -0.3, 1.0) that the arm
# has, it is at rest under null-space control, and the hand stays 17 cm off the head camera's
# line of sight to an object there.
HOME_RIGHT = np.array([-0.042, -0.248, 1.575, 3.063, 2.158, 4.768, -0.364, 0.203])

HAND_MASS_KG = 0.985765
HAND_COM_H = (0.015, 0.0, -0.025)  # p_HHcm [m]


def arm_joint_names(side: Side) -> list[str]:
    """The eight joints from the clavicle to the hand."""
    if side not in SUFFIX:
        raise UnknownName("arm", side, list(SUFFIX))
    return [f"arm_{stem}_joint_{SUFFIX[side]}" for stem in JOINT_STEMS]


def mirrored(q: Array) -> Array:
    """The configuration (8,) of the other arm that mirrors q at the robot's x-z plane."""
    signs = np.array([-1.0, -1.0, 1.0, -1.0, 1.0, -1.0, -1.0, 1.0])
    offset = np.zeros(8)
    offset[JOINT_STEMS.index("t45")] = np.pi
    return signs * q + offset


def home_configuration(side: Side) -> Array:
    """Joint positions (8,) [rad] from which the arm starts."""
    arm_joint_names(side)
    return HOME_RIGHT.copy() if side == "right" else mirrored(HOME_RIGHT)


class ArmKinematics:
    r"""One arm on a robot whose torso and other arm stand still.

    The hand pose is the product of exponentials of the joints' screws, read once from
    the robot model at q = 0 (Lynch and Park 2017, eq. 4.14), the Jacobian holds the
    screws where the joints have carried them (eq. 5.11):

    .. math:: X_{WH} = e^{[S_1] q_1} \cdots e^{[S_8] q_8} X_{WH}(0)

    Args:
        side: "right" or "left".
        torso_position_m: position of the torso joint, -0.365 (low) to 0 (high).
        payload_kg: what the hand carries besides itself, for the gravity torques.
        p_HPayload: centre of mass of the payload in the hand frame (3,) [m].
        hand_kg: mass of the hand.
        p_HHand: its centre of mass (3,) [m].
    """

    def __init__(
        self,
        side: Side = "right",
        *,
        torso_position_m: float = TORSO_POSITION_M,
        payload_kg: float = 0.0,
        p_HPayload: Point = (-0.03, 0.0, 0.0),
        hand_kg: float = HAND_MASS_KG,
        p_HHand: Point = HAND_COM_H,
    ) -> None:
        self.side: Side = side
        self.joint_names = arm_joint_names(side)
        self.torso_position_m = torso_position_m
        loads = {"hand": (hand_kg, p_HHand), "payload": (payload_kg, p_HPayload)}
        plant = _arm_plant(side, torso_position_m, loads)
        joints = [plant.GetJointByName(name) for name in self.joint_names]
        self.lower = np.array([joint.position_lower_limit() for joint in joints])  # (8,) [rad]
        self.upper = np.array([joint.position_upper_limit() for joint in joints])  # (8,) [rad]
        self.velocity_limits = np.array([joint.velocity_upper_limit() for joint in joints])
        self.acceleration_limits = np.array(  # (8,) [rad/s^2]
            [joint.acceleration_upper_limits()[0] for joint in joints]
        )
        # Rows: lower, upper [rad], velocity [rad/s], acceleration [rad/s^2]; (4, 8).
        self.limits = np.stack(
            [self.lower, self.upper, self.velocity_limits, self.acceleration_limits]
        )
        self.home = home_configuration(side)  # (8,) [rad]
        self._axes, self._points, self._X_WH0 = _screws_at_zero(plant, joints, SUFFIX[side])
        self._loads = _loads_at_zero(plant, joints)

    def pose(self, q: Array) -> Array:
        """X_WH (4, 4) of the hand frame at joint positions q (8,)."""
        return self.pose_and_jacobian(q)[0]

    def jacobian(self, q: Array) -> Array:
        """J (6, 8): joint velocities to angular, then linear velocity of H in W."""
        return self.pose_and_jacobian(q)[1]

    def pose_and_jacobian(self, q: Array) -> tuple[Array, Array]:
        """Both at once, for the price of one."""
        X_WH, J = kernels.forward(*self.screws, np.ascontiguousarray(q, dtype=float))
        return X_WH, J

    def acceleration(self, q: Array, velocity: Array, acceleration: Array) -> Array:
        """Rates (6,) [rad/s^2, m/s^2] of the hand's angular, then linear velocity in W.

        Args:
            q: joint positions (8,) [rad].
            velocity: of the joints (8,) [rad/s].
            acceleration: of the joints (8,) [rad/s^2].
        """
        joints = (np.ascontiguousarray(x, dtype=float) for x in (q, velocity, acceleration))
        rates: Array = kernels.spatial_acceleration(*self.screws, *joints)
        return rates

    def gravity_torques(self, q: Array) -> Array:
        """Joint torques (8,) [N m] that hold arm, hand and payload still at q (8,)."""
        q = np.ascontiguousarray(q, dtype=float)
        torques: Array = kernels.holding_torques(*self.screws[:2], *self._loads, q)
        return torques

    def clamped(self, q: Array) -> Array:
        """The nearest joint positions (8,) within the limits."""
        return np.minimum(np.maximum(q, self.lower), self.upper)

    @property
    def screws(self) -> tuple[Array, Array, Array]:
        """Axes (8, 3), points (8, 3) [m] and the hand pose (4, 4) at q = 0, in W."""
        return self._axes, self._points, self._X_WH0


def _at_zero(plant: MultibodyPlant) -> Context:
    """A context with all joint positions at zero."""
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, np.zeros(plant.num_positions()))
    return context


def _screws_at_zero(
    plant: MultibodyPlant, joints: list[RevoluteJoint], suffix: str
) -> tuple[Array, Array, Array]:
    """Axes (8, 3), points (8, 3) [m] and the hand pose (4, 4), in W."""
    context = _at_zero(plant)
    frames = [joint.frame_on_parent().CalcPoseInWorld(context) for joint in joints]
    axes = [X.rotation() @ joint.revolute_axis() for X, joint in zip(frames, joints, strict=True)]
    X_WH0 = plant.GetFrameByName(f"hand_fixed_{suffix}").CalcPoseInWorld(context).GetAsMatrix4()
    return np.array(axes), np.array([X.translation() for X in frames]), X_WH0


def _loads_at_zero(
    plant: MultibodyPlant, joints: list[RevoluteJoint]
) -> tuple[Array, Array, Array]:
    """Mass (8,) [kg] and its centre (8, 3) [m] in W between each joint and the next; gravity."""
    context = _at_zero(plant)
    masses, centers = [], []
    for joint in joints:
        bodies = plant.GetBodiesWeldedTo(joint.child_body())
        own = np.array([body.get_mass(context) for body in bodies])
        at = [
            plant.EvalBodyPoseInWorld(context, body) @ body.CalcCenterOfMassInBodyFrame(context)
            for body in bodies
        ]
        masses.append(own.sum())
        centers.append(own @ np.array(at) / own.sum())
    return np.array(masses), np.array(centers), plant.gravity_field().gravity_vector()


def _arm_plant(
    side: Side, torso_position_m: float, loads: Mapping[str, tuple[float, Point]]
) -> MultibodyPlant:
    """The arm alone, with masses at its end, each at a point of the hand frame."""
    other: Side = "left" if side == "right" else "right"
    fixed = dict(zip(arm_joint_names(other), home_configuration(other), strict=True))
    plant = MultibodyPlant(0.0)
    add_armar6(plant, fixed_joints=fixed | {TORSO_JOINT: torso_position_m}, visuals=False)
    hand = plant.GetFrameByName(f"hand_fixed_{SUFFIX[side]}")
    for name, (mass_kg, p_HLoad) in loads.items():
        if mass_kg > 0.0:
            _weld_ball(plant, hand, name, mass_kg, p_HLoad)
    plant.Finalize()
    return plant


def _weld_ball(
    plant: MultibodyPlant,
    frame: Frame,
    name: str,
    mass_kg: float,
    p_FBall: Point,
) -> None:
    """A mass whose weight matters and whose shape does not."""
    inertia = SpatialInertia.SolidSphereWithMass(mass_kg, 0.05)
    ball = plant.AddRigidBody(name, frame.model_instance(), inertia)
    plant.WeldFrames(frame, ball.body_frame(), RigidTransform(np.array(p_FBall)))
