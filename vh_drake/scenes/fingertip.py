"""A fingertip as a body in a Drake diagram that follows planned curves until it touches.

It is the counterpart of `vh_drake.exploration.kinematic_tip`, with dynamics, servos and
hydroelastic contact. What it touches is read from the plant's contact results, or felt by the
tactile sensor with its noise.
"""

import dataclasses as dc

import numpy as np
from pydrake.geometry import (
    AddCompliantHydroelasticProperties,
    AddContactMaterial,
    AddRigidHydroelasticProperties,
    ProximityProperties,
    Sphere,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import (
    AddMultibodyPlant,
    ContactResults,
    CoulombFriction,
    MultibodyPlant,
    MultibodyPlantConfig,
)
from pydrake.multibody.tree import (
    ModelInstanceIndex,
    PdControllerGains,
    PrismaticJoint,
    RigidBody,
    SpatialInertia,
)
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, EventStatus
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from vh_drake.errors import BadInput
from vh_drake.exploration.trajectory import arc_length, position, velocity
from vh_drake.geometry.meshes import TriMesh
from vh_drake.objects.drake_model import mesh_shape
from vh_drake.sensing.tactile import TactileSettings
from vh_drake.systems.tactile_normal_sensor import TactileNormalSensor
from vh_drake.systems.touched_body import TouchedBody
from vh_drake.types import Array, Immutable

STEP_S = 0.001
_MASS_KG = 0.05
_GAINS = PdControllerGains(p=5e3, d=50.0)
_MODULUS_PA = 1e7  # of the tip: a tenth of a newton presses it in by less than 0.1 mm
_HINT_M = 0.0005  # of the tip's mesh
_FRICTION = CoulombFriction(0.8, 0.8)
_SAMPLES = 100  # of a curve
_AXES = np.eye(3)


@dc.dataclass(frozen=True)
class FingertipSettings:
    """The tip and its motion."""

    radius_m: float = 0.005
    speed_m_s: float = 0.02
    beyond_m: float = 0.005  # how far it goes straight on behind the last curve
    threshold_n: float = 0.05  # of the force against the motion that counts as contact


@dc.dataclass(frozen=True, eq=False)
class FingertipScene:
    """The diagram and the handles that an observer needs."""

    diagram: Diagram
    plant: MultibodyPlant
    tip: RigidBody
    pad: TouchedBody
    sensor: TactileNormalSensor | None
    way: PiecewisePolynomial  # of the tip's centre over time [m]
    settings: FingertipSettings


@dc.dataclass(frozen=True, eq=False)
class FingertipTouch(Immutable):
    """How a motion ended; expressed in W."""

    touched: bool
    time_s: float
    p_WTip: Array  # (3,) centre of the ball [m]
    p_WC: Array  # (3,) contact [m]
    n_WC: Array  # (3,) outward unit normal of the object there


def make_fingertip(
    mesh: TriMesh,
    curves: Array,
    n_WT: Array,
    settings: FingertipSettings | None = None,
    *,
    tactile: TactileSettings | None = None,
    seed: int = 0,
) -> FingertipScene:
    """A ball on three driven slides beside a fixed object.

    Args:
        mesh: the object, watertight, in W [m].
        curves: (k, 4, 3) control points of the ball's centre, one curve after the other [m].
        n_WT: (3,) outward normal expected at the target; the tip's z axis lies against it.
        settings: of tip and motion.
        tactile: where given, the tip carries the tactile sensor, which then says what touches.
        seed: of the sensor's noise and drift.

    Raises:
        BadInput: radius or speed is not positive, or the curves have no length.
    """
    s = settings or FingertipSettings()
    way = centre_way(curves, s)
    builder = DiagramBuilder()
    config = MultibodyPlantConfig(
        time_step=STEP_S, contact_model="hydroelastic", discrete_contact_approximation="lagged"
    )
    plant, _ = AddMultibodyPlant(config, builder)
    _add_object(plant, mesh)
    instance, tip = _add_tip(plant, way.value(0.0)[:, 0], n_WT, s.radius_m)
    plant.Finalize()
    pad = builder.AddNamedSystem("pad", TouchedBody(plant, tip))
    command = builder.AddSystem(TrajectorySource(way, output_derivative_order=1))
    sensor = None
    for source, target in (
        (command.get_output_port(), plant.get_desired_state_input_port(instance)),
        (plant.get_contact_results_output_port(), pad.GetInputPort("contact_results")),
        (plant.get_body_poses_output_port(), pad.GetInputPort("body_poses")),
    ):
        builder.Connect(source, target)
    if tactile is not None:
        sensor = builder.AddNamedSystem("sensor", TactileNormalSensor(tactile, seed))
        builder.Connect(pad.GetOutputPort("contact_force"), sensor.GetInputPort("contact_force"))
        builder.Connect(pad.GetOutputPort("body_pose"), sensor.GetInputPort("sensor_pose"))
    return FingertipScene(builder.Build(), plant, tip, pad, sensor, way, s)


def centre_way(curves: Array, settings: FingertipSettings) -> PiecewisePolynomial:
    """The ball's centre over time, at constant speed and straight on behind the last curve.

    Raises:
        BadInput: radius or speed is not positive, or the curves have no length.
    """
    s = settings
    if not (s.radius_m > 0 and s.speed_m_s > 0):
        raise BadInput(f"radius_m={s.radius_m:g}, speed_m_s={s.speed_m_s:g}: choose above 0")
    if len(curves) == 0 or not arc_length(curves).sum() > 1e-6:
        raise BadInput("no curve, or curves without length; give where the fingertip shall go")
    taus = np.linspace(0.0, 1.0, _SAMPLES)
    p = np.concatenate([[position(curve, tau) for tau in taus] for curve in curves])
    end = velocity(curves[-1], 1.0)
    p = np.vstack([p, p[-1] + s.beyond_m * end / max(float(np.linalg.norm(end)), 1e-12)])
    steps = np.linalg.norm(np.diff(p, axis=0), axis=1)
    p = p[np.concatenate([[True], steps > 1e-7])]  # curves share their ends
    times = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1))])
    return PiecewisePolynomial.FirstOrderHold(times / s.speed_m_s, p.T)


def touch(scene: FingertipScene) -> FingertipTouch:
    """Run a scene from its start until the fingertip touches, or its way ends.

    A contact counts where it presses against the motion, so that the tip may leave what it touches
    in the beginning. With a tactile sensor its flag counts, and place and normal are those of the
    tip's surface along the measured orientation.
    """
    simulator = Simulator(scene.diagram)
    felt = _sensor_says if scene.sensor is not None else _results_say
    found: list[tuple[Array, Array]] = []

    def look(root: Context) -> EventStatus:
        contact = felt(scene, root)
        if contact is None:
            return EventStatus.DidNothing()
        found.append(contact)
        return EventStatus.ReachedTermination(scene.diagram, "touched")

    simulator.set_monitor(look)
    simulator.AdvanceTo(scene.way.end_time())
    root = simulator.get_context()
    p_WTip = _tip_pose(scene, root).translation()
    p_WC, n_WC = found[0] if found else (p_WTip, np.zeros(3))
    return FingertipTouch(bool(found), root.get_time(), p_WTip, p_WC, n_WC)


def _results_say(scene: FingertipScene, root: Context) -> tuple[Array, Array] | None:
    """Place and normal of the contact that presses most against the motion."""
    context = scene.plant.GetMyContextFromRoot(root)
    results: ContactResults = scene.plant.get_contact_results_output_port().Eval(context)
    direction = _direction(scene, root)
    own = set(scene.plant.GetCollisionGeometriesForBody(scene.tip))
    most, found = scene.settings.threshold_n, None
    for i in range(results.num_hydroelastic_contacts()):
        info = results.hydroelastic_contact_info(i)
        surface = info.contact_surface()  # F_Ac_W acts on the body of geometry M
        sign = 1.0 if surface.id_M() in own else -1.0
        pressing = -sign * float(np.asarray(info.F_Ac_W().translational()) @ direction)
        if pressing > most:
            most, found = pressing, np.asarray(surface.centroid())
    if found is None:
        return None
    away = _tip_pose(scene, root).translation() - found
    return found, away / float(np.linalg.norm(away))


def _sensor_says(scene: FingertipScene, root: Context) -> tuple[Array, Array] | None:
    """Place and normal as the tactile sensor feels them."""
    if scene.sensor is None:
        return None
    context = scene.sensor.GetMyContextFromRoot(root)
    if scene.sensor.GetOutputPort("contact").Eval(context)[0] < 0.5:
        return None
    R_WS: RotationMatrix = scene.sensor.GetOutputPort("orientation").Eval(context)
    n_WC = R_WS.col(2)  # the pad faces -z
    return _tip_pose(scene, root).translation() - scene.settings.radius_m * n_WC, n_WC


def _direction(scene: FingertipScene, root: Context) -> Array:
    """Unit vector (3,) in which the tip shall move."""
    v = scene.way.EvalDerivative(root.get_time(), 1)[:, 0]
    direction: Array = v / max(float(np.linalg.norm(v)), 1e-12)
    return direction


def _tip_pose(scene: FingertipScene, root: Context) -> RigidTransform:
    pose: RigidTransform = scene.pad.GetOutputPort("body_pose").Eval(
        scene.pad.GetMyContextFromRoot(root)
    )
    return pose


def _add_object(plant: MultibodyPlant, mesh: TriMesh) -> None:
    """Rigid and fixed, with the same triangles as for a kinematic fingertip."""
    properties = ProximityProperties()
    AddContactMaterial(friction=_FRICTION, properties=properties)
    AddRigidHydroelasticProperties(0.01, properties)  # unused by meshes
    shape, X_WO, world = mesh_shape(mesh, "object"), RigidTransform(), plant.world_body()
    plant.RegisterCollisionGeometry(world, X_WO, shape, "object", properties)
    plant.RegisterVisualGeometry(world, X_WO, shape, "object", np.array([0.85, 0.55, 0.2, 1.0]))


def _add_tip(
    plant: MultibodyPlant, p_WTip: Array, n_WT: Array, radius_m: float
) -> tuple[ModelInstanceIndex, RigidBody]:
    """A compliant ball on slides along x, y and z."""
    instance = plant.AddModelInstance("fingertip")
    plant.set_gravity_enabled(instance, False)
    carrier = plant.world_frame()
    for name, axis, start in zip("xyz", _AXES, p_WTip, strict=True):
        inertia = SpatialInertia.SolidSphereWithMass(_MASS_KG / 3.0, radius_m)
        body = plant.AddRigidBody(f"slide_{name}", instance, inertia)
        joint = plant.AddJoint(PrismaticJoint(name, carrier, body.body_frame(), axis))
        joint.set_default_translation(float(start))
        plant.AddJointActuator(name, joint).set_controller_gains(_GAINS)
        carrier = body.body_frame()
    inertia = SpatialInertia.SolidSphereWithMass(_MASS_KG, radius_m)
    tip = plant.AddRigidBody("fingertip", instance, inertia)
    R_WS = RotationMatrix.MakeFromOneVector(n_WT, axis_index=2)  # the pad of S faces -z
    plant.WeldFrames(carrier, tip.body_frame(), RigidTransform(R_WS, np.zeros(3)))
    properties = ProximityProperties()
    AddContactMaterial(friction=_FRICTION, properties=properties)
    AddCompliantHydroelasticProperties(_HINT_M, _MODULUS_PA, properties)
    ball = Sphere(radius_m)
    plant.RegisterCollisionGeometry(tip, RigidTransform(), ball, "ball", properties)
    plant.RegisterVisualGeometry(tip, RigidTransform(), ball, "ball", np.array([0.3, 0.3, 0.3, 1]))
    return instance, tip
