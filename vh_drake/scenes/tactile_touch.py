"""A finger with the tactile normal sensor that is pressed on a tilted plate."""

import dataclasses as dc

import numpy as np
from pydrake.geometry import (
    AddContactMaterial,
    AddRigidHydroelasticProperties,
    Box,
    ProximityProperties,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import (
    AddMultibodyPlant,
    CoulombFriction,
    MultibodyPlant,
    MultibodyPlantConfig,
)
from pydrake.multibody.tree import (
    ModelInstanceIndex,
    PdControllerGains,
    PrismaticJoint,
    SpatialInertia,
)
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, Diagram, DiagramBuilder
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from vh_drake.errors import BadInput
from vh_drake.geometry.model_files import models_folder
from vh_drake.sensing.tactile import N_SPAD, PERIOD_S, TactileSettings
from vh_drake.systems.tactile_normal_sensor import TactileNormalSensor
from vh_drake.systems.touched_body import TouchedBody
from vh_drake.types import Array

STEP_S = 0.001
FACE_M = 0.018  # from the middle of the relaxed spring to the pad's face
PAD_M = 0.014  # width of the pad
_GAINS = PdControllerGains(p=2e4, d=500.0)
_FINGER = SpatialInertia.SolidSphereWithMass(0.5, 0.02)
_PLATE_M = (0.2, 0.2, 0.02)


@dc.dataclass(frozen=True, eq=False)
class TactileTouch:
    """The diagram and the handles that an observer needs."""

    diagram: Diagram
    plant: MultibodyPlant
    sensor: TactileNormalSensor
    pad: TouchedBody


@dc.dataclass(frozen=True, eq=False)
class TouchRecord:
    """What happened, one row a period of the sensor."""

    time_s: Array  # (n,)
    force_n: Array  # (n,) on the pad, normal to it, pushing positive
    R_WS: Array  # (n, 3, 3)
    acceleration_m_s2: Array  # (n,) of the sensor's middle, its magnitude, gravity left out
    filtered_pa: Array  # (n,) as the sensor said
    normal_W: Array  # (n, 3) likewise


def press_heights(depths_m: Array, *, lift_m: float, press_s: float, rest_s: float) -> Array:
    """Times and heights (2, k) of a finger that goes down to depths and up again in turn.

    Heights are those of the pad's face over the plate's middle, were the spring not there.
    """
    times, heights = [0.0, rest_s], [lift_m, lift_m]
    for depth in depths_m:
        times += [times[-1] + press_s, times[-1] + 1.2 * press_s, times[-1] + 2.2 * press_s]
        heights += [-depth, -depth, lift_m]
        times.append(times[-1] + rest_s)
        heights.append(lift_m)
    return np.array([times, heights])


def make_tactile_touch(
    heights: Array,
    *,
    tilt_rad: float = 0.0,
    heading_rad: float = 0.0,
    friction: float = 1.0,
    settings: TactileSettings | None = None,
    seed: int = 0,
) -> TactileTouch:
    """The finger over a plate through the world's origin.

    Args:
        heights: times and heights (2, k), see `press_heights`.
        tilt_rad: of the plate against the horizontal.
        heading_rad: direction in which it falls, about the vertical.
        friction: of the plate.
        settings: of the sensor.
        seed: of its noise and drift.

    Raises:
        BadInput: the tilt is 80 degrees or more.
    """
    if not 0.0 <= tilt_rad < np.deg2rad(80.0):
        raise BadInput(f"a tilt of {np.rad2deg(tilt_rad):g} degrees; choose 0 to below 80")
    builder = DiagramBuilder()
    config = MultibodyPlantConfig(
        time_step=STEP_S,
        contact_model="hydroelastic_with_fallback",
        discrete_contact_approximation="lagged",
    )
    plant, _ = AddMultibodyPlant(config, builder)
    Parser(plant).AddModels(models_folder() / "tactile_sensor" / "tactile_sensor.sdf")
    finger = _add_finger(plant, heights[1, 0])
    _add_plate(plant, plate_rotation(tilt_rad, heading_rad), friction)
    plant.Finalize()
    body = plant.GetBodyByName("tactile_sensor")
    pad = builder.AddNamedSystem("pad", TouchedBody(plant, body))
    sensor = builder.AddNamedSystem("sensor", TactileNormalSensor(settings, seed))
    height = PiecewisePolynomial.FirstOrderHold(heights[0], heights[1:] + FACE_M)
    finger_height = builder.AddSystem(TrajectorySource(height, 1))
    for source, target in (
        (plant.get_contact_results_output_port(), pad.GetInputPort("contact_results")),
        (plant.get_body_poses_output_port(), pad.GetInputPort("body_poses")),
        (pad.GetOutputPort("contact_force"), sensor.GetInputPort("contact_force")),
        (pad.GetOutputPort("body_pose"), sensor.GetInputPort("sensor_pose")),
        (finger_height.get_output_port(), plant.get_desired_state_input_port(finger)),
    ):
        builder.Connect(source, target)
    return TactileTouch(builder.Build(), plant, sensor, pad)


def plate_rotation(tilt_rad: float, heading_rad: float) -> RotationMatrix:
    """Of the plate in W; its normal is the third column."""
    return RotationMatrix.MakeZRotation(heading_rad) @ RotationMatrix.MakeYRotation(tilt_rad)


def record_touch(touch: TactileTouch, duration_s: float) -> TouchRecord:
    """Run a scene from its start and record it once a period of the sensor."""
    simulator = Simulator(touch.diagram)
    root = simulator.get_mutable_context()
    plant = touch.plant.GetMyContextFromRoot(root)
    sensor = touch.sensor.GetMyContextFromRoot(root)
    pad = touch.pad.GetMyContextFromRoot(root)
    velocities: list[Array] = []
    rows: list[tuple[float, float, Array, float, Array]] = []
    for k in range(1, round(duration_s / PERIOD_S) + 1):
        simulator.AdvanceTo(k * PERIOD_S)
        X_WS = touch.pad.GetOutputPort("body_pose").Eval(pad)
        force_W = touch.pad.GetOutputPort("contact_force").Eval(pad)
        R_WS = X_WS.rotation().matrix()
        velocities.append(_velocity(touch.plant, plant))
        filtered = touch.sensor.GetOutputPort("filtered_pressure").Eval(sensor)[0]
        normal = np.array(touch.sensor.GetOutputPort("normal").Eval(sensor))
        rows.append((k * PERIOD_S, -float(force_W @ (R_WS @ N_SPAD)), R_WS, filtered, normal))
    columns = [np.array(column) for column in zip(*rows, strict=True)]
    change = np.diff(np.array(velocities), axis=0, prepend=np.zeros((1, 3)))
    acceleration = np.linalg.norm(change, axis=1) / PERIOD_S
    return TouchRecord(columns[0], columns[1], columns[2], acceleration, *columns[3:])


def _velocity(plant: MultibodyPlant, context: Context) -> Array:
    """Of the middle of the sensor's body (3,) [m/s]."""
    velocity: SpatialVelocity = plant.GetBodyByName("tactile_sensor").EvalSpatialVelocityInWorld(
        context
    )
    return np.array(velocity.translational())


def _add_finger(plant: MultibodyPlant, start_m: float) -> ModelInstanceIndex:
    """A body on a vertical slide that carries the sensor."""
    finger = plant.AddModelInstance("finger")
    body = plant.AddRigidBody("finger", finger, _FINGER)
    slide = plant.AddJoint(
        PrismaticJoint("press", plant.world_frame(), body.body_frame(), [0.0, 0.0, 1.0])
    )
    slide.set_default_translation(start_m + FACE_M)
    plant.AddJointActuator("press", slide).set_controller_gains(_GAINS)
    plant.set_gravity_enabled(finger, False)
    plant.WeldFrames(body.body_frame(), plant.GetFrameByName("tactile_base"))
    return finger


def _add_plate(plant: MultibodyPlant, R_WP: RotationMatrix, friction: float) -> None:
    """Rigid; its upper face goes through the origin."""
    properties = ProximityProperties()
    AddContactMaterial(friction=CoulombFriction(friction, friction), properties=properties)
    AddRigidHydroelasticProperties(_PLATE_M[0], properties)
    X_WP = RigidTransform(R_WP, R_WP.matrix() @ [0.0, 0.0, -_PLATE_M[2] / 2])
    world = plant.world_body()
    plant.RegisterCollisionGeometry(world, X_WP, Box(*_PLATE_M), "plate", properties)
    plant.RegisterVisualGeometry(
        world, X_WP, Box(*_PLATE_M), "plate", np.array([0.72, 0.58, 0.42, 1.0])
    )
