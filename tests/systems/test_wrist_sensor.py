import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import ExternallyAppliedSpatialForce, MultibodyPlant
from pydrake.multibody.tree import FixedOffsetFrame, SpatialInertia, UnitInertia, WeldJoint

from vh_drake.errors import BadInput
from vh_drake.sensing.wrist_noise import WristNoiseSettings
from vh_drake.systems.wrist_sensor import WristSensor

QUIET = WristNoiseSettings(0.0, 0.0, 0.0, 0.0)
MASS, P_COM = 0.985765, np.array([0.015, 0.0, -0.025])
X_WJ = RigidTransform(RollPitchYaw(0.4, -0.9, 0.3), [0.5, -0.2, 1.1])
X_HJ = RigidTransform(RollPitchYaw(0.2, 0.5, -0.7), [0.02, 0.01, -0.1])


def hanging_hand() -> tuple[MultibodyPlant, WristSensor]:
    """A hand of known mass that is welded to the world through an offset frame."""
    plant = MultibodyPlant(0.002)
    plant.SetUseSampledOutputPorts(False)  # They would need a step before they show forces.
    inertia = SpatialInertia(
        MASS, P_COM, UnitInertia.SolidSphere(0.05).ShiftFromCenterOfMass(P_COM)
    )
    hand = plant.AddRigidBody("hand", inertia)
    frame_J = plant.AddFrame(FixedOffsetFrame("J", hand, X_HJ))
    joint = plant.AddJoint(WeldJoint("wrist", plant.world_frame(), frame_J, X_WJ))
    plant.Finalize()
    return plant, WristSensor(plant, joint, QUIET)


def wrench_of(plant, sensor, force_W=None, p_H=None):
    plant_context = plant.CreateDefaultContext()
    if force_W is not None:
        push = ExternallyAppliedSpatialForce()
        push.body_index = plant.GetBodyByName("hand").index()
        push.p_BoBq_B = p_H
        push.F_Bq_W = SpatialForce(np.zeros(3), force_W)
        plant.get_applied_spatial_force_input_port().FixValue(plant_context, [push])
    reactions = plant.get_reaction_forces_output_port().Eval(plant_context)
    context = sensor.CreateDefaultContext()
    sensor.get_input_port().FixValue(context, Value[list[SpatialForce]](reactions))
    return sensor.get_output_port().Eval(context)


def test_a_hanging_hand_shows_its_weight_about_the_hand_s_origin():
    plant, sensor = hanging_hand()
    R_WH = (X_WJ @ X_HJ.inverse()).rotation().matrix()
    weight_H = R_WH.T @ [0.0, 0.0, -9.81 * MASS]
    expected = np.concatenate([np.cross(P_COM, weight_H), weight_H])
    np.testing.assert_allclose(wrench_of(plant, sensor), expected, atol=1e-9)


def test_what_pushes_the_hand_adds_as_it_pushes():
    plant, sensor = hanging_hand()
    R_WH = (X_WJ @ X_HJ.inverse()).rotation().matrix()
    force_W, p_H = np.array([0.3, -0.2, 0.5]), np.array([0.03, -0.01, 0.14])
    change = wrench_of(plant, sensor, force_W, p_H) - wrench_of(plant, sensor)
    force_H = R_WH.T @ force_W
    np.testing.assert_allclose(change, [*np.cross(p_H, force_H), *force_H], atol=1e-9)


def reading(sensor, time_s, forces=None, *, caching=True):
    context = sensor.CreateDefaultContext()
    context.SetTime(time_s)
    if not caching:
        context.DisableCaching()
    value = Value[list[SpatialForce]]([SpatialForce.Zero()] if forces is None else forces)
    sensor.get_input_port().FixValue(context, value)
    return sensor.get_output_port().Eval(context).copy()


def noisy_sensor(seed=0):
    plant, _ = hanging_hand()
    return WristSensor(plant, plant.GetJointByName("wrist"), seed=seed)


def test_noise_depends_on_seed_and_time_alone():
    sensor = noisy_sensor()
    np.testing.assert_array_equal(reading(sensor, 0.5), reading(sensor, 0.5, caching=False))
    assert not np.array_equal(reading(sensor, 0.5), reading(sensor, 0.502))
    assert not np.array_equal(reading(sensor, 0.5), reading(noisy_sensor(1), 0.5))


def test_forces_of_another_plant_are_refused():
    with pytest.raises(BadInput, match="got 0 reaction forces"):
        reading(noisy_sensor(), 0.0, [])


def test_an_unfinished_plant_is_refused():
    plant = MultibodyPlant(0.002)
    with pytest.raises(BadInput, match="Finalize"):
        WristSensor(plant, None)
