"""A hand on a straight slide that feels for an object: the contact estimation by itself."""

import dataclasses as dc

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.math import SpatialAcceleration, SpatialVelocity
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlant, MultibodyPlantConfig
from pydrake.multibody.tree import (
    PdControllerGains,
    PrismaticJoint,
    RigidBody,
    SpatialInertia,
    WeldJoint,
)
from pydrake.systems.framework import (
    BasicVector,
    Context,
    Diagram,
    DiagramBuilder,
    DiscreteValues,
)
from pydrake.systems.primitives import ConstantVectorSource

from vh_drake.exploration.touch_motion import fingertip_frame
from vh_drake.hand.model import HandModel
from vh_drake.objects.drake_model import ContactModel, add_object
from vh_drake.objects.model import ObjectModel
from vh_drake.scenes.decision import touching_skin
from vh_drake.scenes.plant import add_table
from vh_drake.scenes.scenario import Table
from vh_drake.scenes.wrist import hand_inertia
from vh_drake.systems.collectable import CollectableSystem
from vh_drake.systems.ft_contact_estimator import FtContactEstimator
from vh_drake.systems.wrist_sensor import WristSensor

WAIT_S, TARE_S = 0.3, 0.1  # before the hand moves, and before F_0 is stored
_STEP_S = 0.002
_GAINS = PdControllerGains(p=2e4, d=1e3)
_CARRIAGE = SpatialInertia.SolidSphereWithMass(5.0, 0.05)


class SlideDrive(CollectableSystem):
    """Moves the slide at a speed until something is touched, and tells pose and velocity.

    .. pydrake_system::

        name: SlideDrive
        input_ports:
        - contact
        - body_poses
        - body_velocities
        - body_accelerations
        output_ports:
        - slide
        - tare
        - hand_pose
        - hand_velocity
        - hand_acceleration

    | port               | direction | type                      | unit       | meaning          |
    |--------------------|-----------|---------------------------|------------|------------------|
    | contact            | in        | vector (1)                | -          | 1: touched       |
    | body_poses         | in        | list[RigidTransform]      | m          | of the plant     |
    | body_velocities    | in        | list[SpatialVelocity]     | rad/s, m/s | of the plant     |
    | body_accelerations | in        | list[SpatialAcceleration] | *          | of the plant     |
    | slide              | out       | vector (2)                | m, m/s     | wanted state     |
    | tare               | out       | vector (1)                | -          | 1 after TARE_S   |
    | hand_pose          | out       | RigidTransform            | m          | X_WH             |
    | hand_velocity      | out       | vector (6)                | rad/s, m/s | [w; v] of H in W |
    | hand_acceleration  | out       | vector (6)                | *          | rad/s², m/s²     |

    Args:
        hand: index of the hand's base.
        speed_m_s: of the approach.
    """

    def __init__(self, hand: int, speed_m_s: float) -> None:
        super().__init__()
        self._speed = speed_m_s
        self._contact = self.DeclareVectorInputPort("contact", 1)
        poses = self.DeclareAbstractInputPort("body_poses", Value[list[RigidTransform]]([]))
        speeds = self.DeclareAbstractInputPort("body_velocities", Value[list[SpatialVelocity]]([]))
        rates = self.DeclareAbstractInputPort(
            "body_accelerations", Value[list[SpatialAcceleration]]([])
        )
        self.DeclareDiscreteState(2)
        self.DeclarePeriodicDiscreteUpdateEvent(_STEP_S, 0.0, self._advance)
        state = {self.xd_ticket()}
        self.DeclareVectorOutputPort("slide", 2, self._calc_slide, prerequisites_of_calc=state)
        self.DeclareVectorOutputPort(
            "tare",
            1,
            lambda context, output: output.SetAtIndex(0, float(context.get_time() > TARE_S)),
            prerequisites_of_calc={self.time_ticket()},
        )
        self.DeclareAbstractOutputPort(
            "hand_pose",
            lambda: Value(RigidTransform()),
            lambda context, output: output.set_value(poses.Eval(context)[hand]),
            prerequisites_of_calc={poses.ticket()},
        )
        self.DeclareVectorOutputPort(
            "hand_velocity",
            6,
            lambda context, output: output.SetFromVector(speeds.Eval(context)[hand].get_coeffs()),
            prerequisites_of_calc={speeds.ticket()},
        )
        self.DeclareVectorOutputPort(
            "hand_acceleration",
            6,
            lambda context, output: output.SetFromVector(rates.Eval(context)[hand].get_coeffs()),
            prerequisites_of_calc={rates.ticket()},
        )

    def _advance(self, context: Context, values: DiscreteValues) -> None:
        moves = context.get_time() >= WAIT_S and self._contact.Eval(context)[0] == 0
        speed = self._speed if moves else 0.0
        x = context.get_discrete_state_vector().GetAtIndex(0)
        values.set_value([x + _STEP_S * speed, speed])

    def _calc_slide(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(context.get_discrete_state_vector().CopyToVector())


@dc.dataclass(frozen=True)
class SlidingHand:
    """The diagram and what an observer needs of it."""

    diagram: Diagram
    plant: MultibodyPlant
    base: RigidBody  # of the hand
    object: RigidBody
    estimator: FtContactEstimator


def make_sliding_hand(
    hand: HandModel,
    model: ObjectModel,
    X_TO: RigidTransform,
    *,
    pad_height_m: float,
    speed_m_s: float,
    seed: int,
    contact: ContactModel = "hydroelastic",
) -> SlidingHand:
    """The open hand, fingers down, comes along +x over a table; its pad starts at x = 0.

    Args:
        hand: on the slide.
        model: of the object.
        X_TO: where it stands; T lies on the table's top, parallel to the world.
        pad_height_m: of the touching pad over the table.
        speed_m_s: of the approach.
        seed: of the sensor's noise.
        contact: model.
    """
    builder = DiagramBuilder()
    config = MultibodyPlantConfig(
        time_step=_STEP_S,
        contact_model="hydroelastic_with_fallback" if contact == "hydroelastic" else contact,
        discrete_contact_approximation="lagged",
    )
    plant, _ = AddMultibodyPlant(config, builder)
    table = Table(center=[0.1, 0.0], size=[1.0, 1.0])
    add_table(plant, table)
    body = add_object(plant, model, contact=contact)
    plant.SetDefaultFloatingBaseBodyPose(body, RigidTransform([0.0, 0.0, table.height_m]) @ X_TO)
    (instance,) = Parser(plant).AddModels(hand.description.model)
    carriage = plant.AddModelInstance("carriage")
    mount = plant.AddRigidBody("carriage", carriage, _CARRIAGE)
    slide = plant.AddJoint(
        PrismaticJoint("slide", plant.world_frame(), mount.body_frame(), [1.0, 0.0, 0.0])
    )
    plant.AddJointActuator("slide", slide).set_controller_gains(_GAINS)
    base = plant.GetBodyByName(hand.description.base, instance)
    X_MH = _hand_pose(hand, table.height_m + pad_height_m)
    wrist = plant.AddJoint(WeldJoint("wrist", mount.body_frame(), base.body_frame(), X_MH))
    plant.Finalize()
    inertia = hand_inertia(
        plant, plant.CreateDefaultContext(), base, plant.GetBodyIndices(instance)
    )
    sensor = builder.AddSystem(WristSensor(plant, wrist, seed=seed))
    estimator = builder.AddSystem(FtContactEstimator(touching_skin(hand), inertia))
    drive = builder.AddSystem(SlideDrive(int(base.index()), speed_m_s))
    still = builder.AddSystem(ConstantVectorSource(np.zeros(2 * plant.num_actuators(instance))))
    ahead = builder.AddSystem(ConstantVectorSource([1.0, 0.0, 0.0]))
    for source, target in (
        (plant.get_reaction_forces_output_port(), sensor.get_input_port()),
        (plant.get_body_poses_output_port(), drive.GetInputPort("body_poses")),
        (plant.get_body_spatial_velocities_output_port(), drive.GetInputPort("body_velocities")),
        (
            plant.get_body_spatial_accelerations_output_port(),
            drive.GetInputPort("body_accelerations"),
        ),
        (estimator.GetOutputPort("contact"), drive.GetInputPort("contact")),
        (drive.GetOutputPort("slide"), plant.get_desired_state_input_port(carriage)),
        (still.get_output_port(), plant.get_desired_state_input_port(instance)),
        (sensor.get_output_port(), estimator.GetInputPort("wrist_wrench")),
        (drive.GetOutputPort("hand_pose"), estimator.GetInputPort("hand_pose")),
        (drive.GetOutputPort("hand_velocity"), estimator.GetInputPort("hand_velocity")),
        (drive.GetOutputPort("hand_acceleration"), estimator.GetInputPort("hand_acceleration")),
        (drive.GetOutputPort("tare"), estimator.GetInputPort("tare")),
        (ahead.get_output_port(), estimator.GetInputPort("approach_direction")),
    ):
        builder.Connect(source, target)
    return SlidingHand(builder.Build(), plant, base, body, estimator)


def _hand_pose(hand: HandModel, height_m: float) -> RigidTransform:
    """X_WH with the pad of the longest finger over the origin, facing +x, its tip down."""
    X_WT = RigidTransform(
        RotationMatrix(np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])),
        [0.0, 0.0, height_m],
    )
    return X_WT @ RigidTransform(fingertip_frame(hand)).inverse()
