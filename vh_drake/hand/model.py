"""Any described hand as plain arrays: kinematics, springs, and a model of spheres."""

import dataclasses as dc
from functools import cached_property, lru_cache
from pathlib import Path

import numpy as np
from pydrake.geometry import SceneGraphInspector
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlant, MultibodyPlantConfig
from pydrake.multibody.tree import (
    BodyIndex,
    ForceElementIndex,
    Frame,
    PrismaticJoint,
    RevoluteJoint,
    RevoluteSpring,
    RigidBody,
)
from pydrake.systems.framework import Context, DiagramBuilder

from vh_drake.errors import BadInput, UnknownName
from vh_drake.geometry.meshes import Mask
from vh_drake.hand.description import HandDescription
from vh_drake.hand.kinematics import HandArrays, link_poses, sphere_centers
from vh_drake.hand.spheres import cover
from vh_drake.hand.tendon import SprungJoints
from vh_drake.types import Array, IntArray

_OPPOSES_BELOW = 0.5  # Cosine between a tip's velocity at the open stop and `closing`


@dc.dataclass(frozen=True, eq=False)
class HandModel:
    """A hand with n joints and f fingers; frames and units as in `HandDescription`.

    Joints are numbered finger by finger from the palm outwards. Link 0 is the base H, and
    joint j moves link j + 1. Other joints of the model file rest at their default.
    """

    description: HandDescription
    arrays: HandArrays
    joints: tuple[str, ...]  # (n,)
    links: tuple[str, ...]  # (n + 1,) the base first
    lower: Array  # (n,) open stops [rad or m]
    upper: Array  # (n,) closed stops [rad or m]
    stiffness: Array  # (n,) of the torsion springs [N m/rad]
    preload: Array  # (n,) pretension of the springs where the joint is open [rad]
    motor_of_finger: IntArray  # (f,) index into description.motors
    mass_kg: float
    p_HCom: Array  # (3,) centre of mass of the open hand, in H [m]
    I_H: Array  # (3, 3) its rotational inertia about H's origin [kg m^2]

    @property
    def num_fingers(self) -> int:
        """Number of fingers, thumbs included."""
        return len(self.motor_of_finger)

    @cached_property
    def finger_of_link(self) -> IntArray:
        """(n + 1,) finger of each link, -1 for the base."""
        counts = np.diff(self.arrays.first_joint)
        return np.concatenate([[-1], np.repeat(np.arange(self.num_fingers), counts)])

    @cached_property
    def tip_spheres(self) -> IntArray:
        """(f,) of each finger's last link, the sphere that is farthest from its joint."""
        first = self.arrays.first_sphere
        lengths = np.linalg.norm(self.arrays.sphere_center, axis=1)
        ends = [int(end) for end in self.arrays.first_joint[1:]]
        return np.array([first[e] + np.argmax(lengths[first[e] : first[e + 1]]) for e in ends])

    @cached_property
    def opposing(self) -> IntArray:
        """(f,) 1 for thumbs: fingers whose tips don't set out along `closing`."""
        step = 0.02 * (self.upper - self.lower)
        motion = self.tips(self.lower + step) - self.tips(self.lower)
        motion /= np.linalg.norm(motion, axis=1, keepdims=True)
        closing = np.asarray(self.description.closing)
        opposing: IntArray = (motion @ _unit(closing) < _OPPOSES_BELOW).astype(np.int64)
        return opposing

    @cached_property
    def thumb_links(self) -> Mask:
        """(n + 1,) which links belong to a thumb."""
        finger = self.finger_of_link
        thumb: Mask = (finger >= 0) & (self.opposing[np.maximum(finger, 0)] == 1)
        return thumb

    def joint_angles(self, motor_fraction: Array) -> Array:
        """Free-space joint angles (..., n) where motors have gone fractions 0..1 (..., motors).

        The springs share out the tendon, see `vh_drake.hand.tendon`.
        """
        fraction = np.asarray(motor_fraction, dtype=np.float64)
        angles = np.empty((*fraction.shape[:-1], len(self.joints)))
        for motor, own, springs in self._driven:
            angles[..., own] = self.lower[own] + springs.angles_at_fraction(fraction[..., motor])
        return angles

    @cached_property
    def _driven(self) -> tuple[tuple[int, IntArray, SprungJoints], ...]:
        """Motors with the joints that they close."""
        motor_of_joint = self.motor_of_finger[self.finger_of_link[1:]]
        driven = []
        for motor in range(len(self.description.motors)):
            own = np.flatnonzero(motor_of_joint == motor)
            if len(own):
                range_ = self.upper[own] - self.lower[own]
                springs = SprungJoints(self.stiffness[own], self.preload[own], range_)
                driven.append((motor, own, springs))
        return tuple(driven)

    def link_poses(self, angles: Array) -> Array:
        """Poses X_HL (n + 1, 4, 4) of all links at joint angles (n,)."""
        poses = np.tile(np.eye(4), (len(self.links), 1, 1))
        poses[:, :3] = link_poses(self.arrays, np.eye(4), np.ascontiguousarray(angles))
        return poses

    def spheres(self, angles: Array) -> tuple[Array, Array]:
        """Centres (m, 3) in H and radii (m,) of the sphere model at joint angles (n,) [m]."""
        poses = link_poses(self.arrays, np.eye(4), np.ascontiguousarray(angles))
        return sphere_centers(self.arrays, poses), self.arrays.sphere_radius

    def tips(self, angles: Array) -> Array:
        """Centres (f, 3) of the fingertips' spheres in H at joint angles (n,) [m]."""
        centers: Array = self.spheres(angles)[0][self.tip_spheres]
        return centers

    def motor_fractions(self, fingers: float, thumbs: float) -> Array:
        """(motors,) fractions that give `thumbs` to motors of thumbs alone, else `fingers`."""
        fractions = np.full(len(self.description.motors), fingers)
        for motor in range(len(fractions)):
            own = self.opposing[self.motor_of_finger == motor]
            if len(own) and own.all():
                fractions[motor] = thumbs
        return fractions


def read_hand_model(description: HandDescription) -> HandModel:
    """Read a described hand through Drake; the same one while description and file stay alike.

    Raises:
        BadInput: the model file can't be parsed, or a joint is neither revolute nor prismatic,
            or is unbounded.
        UnknownName: a link or joint of the description is not in the model.
    """
    return _read(_Described(description, repr(description), _modified(Path(description.model))))


@dc.dataclass(frozen=True)
class _Described:
    description: HandDescription = dc.field(compare=False)
    text: str
    modified_ns: int  # of the model file


def _modified(path: Path) -> int:
    return path.stat().st_mtime_ns if path.is_file() else 0


@lru_cache(maxsize=8)
def _read(described: _Described) -> HandModel:
    description = described.description
    plant, inspector, context = _parse(description)
    joints = tuple(name for finger in description.fingers for name in finger.joints)
    moved = tuple(name for finger in description.fingers for name in finger.links)
    links = (description.base, *moved)
    bodies = [_body(plant, name) for name in links]
    handles = [_joint(plant, name) for name in joints]
    lower, upper = _limits(handles)
    stiffness, preload = _springs(plant, handles, lower)
    arrays = _arrays(plant, inspector, context, bodies, handles, description)
    slides: Array = arrays.prismatic.astype(np.float64) * np.maximum(np.abs(lower), np.abs(upper))
    motors = [motor.joint for motor in description.motors]
    own = plant.GetBodyIndices(bodies[0].model_instance())
    inertia = plant.CalcSpatialInertia(context, bodies[0].body_frame(), own)
    return HandModel(
        description=description,
        arrays=arrays._replace(sphere_lever=_levers(arrays, slides)),
        joints=joints,
        links=links,
        lower=lower,
        upper=upper,
        stiffness=stiffness,
        preload=preload,
        motor_of_finger=np.array([motors.index(f.motor) for f in description.fingers]),
        mass_kg=inertia.get_mass(),
        p_HCom=inertia.get_com(),
        I_H=inertia.CalcRotationalInertia().CopyToFullMatrix3(),
    )


def _parse(
    description: HandDescription,
) -> tuple[MultibodyPlant, SceneGraphInspector, Context]:
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlant(MultibodyPlantConfig(), builder)
    try:
        Parser(plant).AddModels(Path(description.model))
        plant.Finalize()
    except Exception as error:  # The parser raises many types; all mean an unusable file.
        raise BadInput(f"can't read the hand model {description.model}: {error}") from error
    builder.Build()  # Drake never frees what is added to a builder that builds nothing.
    return plant, scene_graph.model_inspector(), plant.CreateDefaultContext()


def _body(plant: MultibodyPlant, name: str) -> RigidBody:
    if not plant.HasBodyNamed(name):
        names = [plant.get_body(BodyIndex(i)).name() for i in range(plant.num_bodies())]
        raise UnknownName("link of the hand", name, names)
    body: RigidBody = plant.GetBodyByName(name)
    return body


def _joint(plant: MultibodyPlant, name: str) -> RevoluteJoint | PrismaticJoint:
    if not plant.HasJointNamed(name):
        names = [plant.get_joint(index).name() for index in plant.GetJointIndices()]
        raise UnknownName("joint of the hand", name, names)
    joint = plant.GetJointByName(name)
    if not isinstance(joint, RevoluteJoint | PrismaticJoint):
        raise BadInput(f"joint {name!r} of the hand must be revolute or prismatic")
    return joint


def _limits(joints: list[RevoluteJoint | PrismaticJoint]) -> tuple[Array, Array]:
    lower = np.array([joint.position_lower_limits()[0] for joint in joints])
    upper = np.array([joint.position_upper_limits()[0] for joint in joints])
    for joint, low, high in zip(joints, lower, upper, strict=True):
        if not (np.isfinite([low, high]).all() and low < high):
            raise BadInput(
                f"joint {joint.name()!r} has limits {low:g} to {high:g}; set finite ones"
            )
    return lower, upper


def _springs(
    plant: MultibodyPlant, joints: list[RevoluteJoint | PrismaticJoint], lower: Array
) -> tuple[Array, Array]:
    """Stiffness and pretension of each joint; joints without a spring share evenly."""
    stiffness, preload = np.ones(len(joints)), np.zeros(len(joints))
    places = {joint.index(): i for i, joint in enumerate(joints)}
    for index in range(plant.num_force_elements()):
        spring = plant.get_force_element(ForceElementIndex(index))
        if isinstance(spring, RevoluteSpring) and spring.joint().index() in places:
            i = places[spring.joint().index()]
            stiffness[i] = spring.default_stiffness()
            preload[i] = lower[i] - spring.default_nominal_angle()
    return stiffness, preload


def _arrays(
    plant: MultibodyPlant,
    inspector: SceneGraphInspector,
    context: Context,
    bodies: list[RigidBody],
    joints: list[RevoluteJoint | PrismaticJoint],
    description: HandDescription,
) -> HandArrays:
    carriers = _carriers(plant, bodies)
    X_WB = {i: plant.EvalBodyPoseInWorld(context, plant.get_body(i)) for i in carriers}
    parents, X_PL = [], []
    for joint in joints:
        parent = carriers[joint.parent_body().index()]
        X_WP = X_WB[bodies[parent].index()]
        X_WF = X_WB[joint.parent_body().index()] @ _pose_in_body(joint.frame_on_parent())
        parents.append(parent)
        X_PL.append(_joint_terms(joint, X_WP.inverse() @ X_WF))
    centers, radii, first_sphere = _spheres(plant, inspector, bodies, carriers, X_WB)
    counts = [len(finger.joints) for finger in description.fingers]
    return HandArrays(
        parent=np.array(parents, dtype=np.int64),
        X_PL=np.array(X_PL),
        prismatic=np.array([isinstance(j, PrismaticJoint) for j in joints], dtype=np.int64),
        first_joint=np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
        sphere_center=centers,
        sphere_radius=radii,
        first_sphere=first_sphere,
        sphere_lever=np.zeros((len(radii), len(joints))),
    )


def _carriers(plant: MultibodyPlant, bodies: list[RigidBody]) -> dict[BodyIndex, int]:
    """The link that carries each body of the hand: itself, or the next one inwards."""
    carriers = {body.index(): i for i, body in enumerate(bodies)}
    inward = {}
    for index in plant.GetJointIndices():
        joint = plant.get_joint(index)
        inward[joint.child_body().index()] = joint.parent_body().index()
    for start in inward:
        at, path = start, []
        while at not in carriers and at in inward:
            path.append(at)
            at = inward[at]
        carriers.update({i: carriers[at] for i in path if at in carriers})
    return carriers


def _spheres(
    plant: MultibodyPlant,
    inspector: SceneGraphInspector,
    bodies: list[RigidBody],
    carriers: dict[BodyIndex, int],
    X_WB: dict[BodyIndex, RigidTransform],
) -> tuple[Array, Array, IntArray]:
    """Centres in their links, radii, and where each link's begin; sorted by link."""
    found: list[list[tuple[Array, Array]]] = [[] for _ in bodies]
    for index, link in carriers.items():
        X_LB = X_WB[bodies[link].index()].inverse() @ X_WB[index]
        for geometry in plant.GetCollisionGeometriesForBody(plant.get_body(index)):
            centers, radii = cover(inspector.GetShape(geometry))
            X_LG = X_LB @ inspector.GetPoseInFrame(geometry)
            found[link].append((X_LG.multiply(centers.T).T, radii))
    counts = [sum(len(radii) for _, radii in link) for link in found]
    if 0 in counts[1:]:
        bare = bodies[1 + counts[1:].index(0)].name()
        raise BadInput(f"link {bare!r} of the hand has no collision geometry; add some")
    first = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    flat = [pair for link in found for pair in link]
    return np.vstack([c for c, _ in flat]), np.concatenate([r for _, r in flat]), first


def _levers(arrays: HandArrays, slides: Array) -> Array:
    """Bounds (m, n) on how far a sphere moves per rad (or m) of a joint; 0 where it does not.

    From a joint's axis to the sphere, the lengths of the links between add up whatever the
    angles are. Slides lengthen them by as much as `slides` (n,).
    """
    zero = np.zeros(len(arrays.parent))
    X_HL = link_poses(arrays, np.eye(4), zero)
    origins = _joint_origins(arrays, X_HL)
    centers = sphere_centers(arrays, X_HL)
    levers = np.zeros((len(centers), len(zero)))
    for j in range(len(zero)):
        own = slice(arrays.first_sphere[j + 1], arrays.first_sphere[j + 2])
        reach, at = np.linalg.norm(centers[own] - origins[j], axis=1), j
        while True:
            levers[own, at] = 1.0 if arrays.prismatic[at] else reach
            inner = int(arrays.parent[at]) - 1
            if inner < 0:
                break
            reach = reach + slides[at] + np.linalg.norm(origins[at] - origins[inner])
            at = inner
    return levers


def _joint_origins(arrays: HandArrays, X_HL: Array) -> Array:
    """A point (n, 3) on each joint's axis, in H with all joints at 0 [m].

    It is the one nearest to the moved link's origin: where the angle's sine and cosine move
    that origin p to a + s b + c d, the axis runs through a where d is perpendicular to it.
    """
    local = arrays.X_PL[:, 0, :, 3]
    parents = X_HL[arrays.parent]
    origins: Array = np.einsum("nij,nj->ni", parents[:, :, :3], local) + parents[:, :, 3]
    return origins


def _joint_terms(joint: RevoluteJoint | PrismaticJoint, X_PF: RigidTransform) -> Array:
    """The three terms of `HandArrays.X_PL` for one joint (3, 3, 4)."""
    terms = np.zeros((3, 4, 4))
    if isinstance(joint, PrismaticJoint):
        terms[0], terms[1, :3, 3] = np.eye(4), _unit(joint.translation_axis())
    else:
        x, y, z = axis = _unit(joint.revolute_axis())
        terms[0, :3, :3], terms[0, 3, 3] = np.outer(axis, axis), 1.0
        terms[1, :3, :3] = [[0, -z, y], [z, 0, -x], [-y, x, 0]]
        terms[2, :3, :3] = np.eye(3) - np.outer(axis, axis)
    X_ML = _pose_in_body(joint.frame_on_child()).inverse().GetAsMatrix4()
    placed: Array = (X_PF.GetAsMatrix4() @ terms @ X_ML)[:, :3]
    return placed


def _unit(v: Array) -> Array:
    unit: Array = np.asarray(v, np.float64) / np.linalg.norm(v)
    return unit


def _pose_in_body(frame: Frame) -> RigidTransform:
    pose: RigidTransform = frame.GetFixedPoseInBodyFrame()
    return pose
