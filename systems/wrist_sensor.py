"""The force-torque sensor in the wrist as a LeafSystem."""

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Joint
from pydrake.systems.framework import BasicVector, Context

from vh_drake.errors import BadInput
from vh_drake.sensing.hand_load import shifted_wrench
from vh_drake.sensing.wrist_noise import WristNoiseSettings, wrist_noise
from vh_drake.systems.collectable import CollectableSystem


class WristSensor(CollectableSystem):
    """Measures the load that the hand puts on the arm through the joint between them.

    .. pydrake_system::

        name: WristSensor
        input_ports:
        - reaction_forces
        output_ports:
        - wrist_wrench

    | port            | direction | type               | unit   | meaning                       |
    |-----------------|-----------|--------------------|--------|-------------------------------|
    | reaction_forces | in        | list[SpatialForce] | N m, N | of the plant, a joint each    |
    | wrist_wrench    | out       | vector (6)         | N m, N | [torque; force] about Ho in H |

    Sign: a hand that hangs at rest shows its weight, f_H = m g_H, and what pushes the hand
    adds as it pushes. (The plant gives the opposite, the arm's force on the hand.)

    Noise is a function of seed and time, so the system has no state.

    Args:
        plant: finalized; kept only for what it says now.
        joint: between arm and hand, the hand its child; H is the child body's frame.
        settings: of the noise.
        seed: of the noise.

    Raises:
        BadInput: the plant is not finalized.
    """

    def __init__(
        self,
        plant: MultibodyPlant,
        joint: Joint,
        settings: WristNoiseSettings | None = None,
        seed: int = 0,
    ) -> None:
        super().__init__()
        if not plant.is_finalized():
            raise BadInput("WristSensor needs a finalized plant; call plant.Finalize() before")
        self._ordinal = list(plant.GetJointIndices()).index(joint.index())
        X_HJ: RigidTransform = joint.frame_on_child().GetFixedPoseInBodyFrame()
        self._R_HJ = np.ascontiguousarray(X_HJ.rotation().matrix())
        self._p_HJ = np.array(X_HJ.translation())
        self._settings = settings or WristNoiseSettings()
        self._seed = seed
        self._reactions = self.DeclareAbstractInputPort(
            "reaction_forces", Value[list[SpatialForce]]([SpatialForce()])
        )
        self.DeclareVectorOutputPort(
            "wrist_wrench",
            6,
            self._calc_wrench,
            prerequisites_of_calc={self._reactions.ticket(), self.time_ticket()},
        )

    def _calc_wrench(self, context: Context, output: BasicVector) -> None:
        reactions = self._reactions.Eval(context)
        if self._ordinal >= len(reactions):
            raise BadInput(
                f"WristSensor reads joint {self._ordinal} and got {len(reactions)} reaction "
                "forces; connect the port of the plant that it was made with"
            )
        reaction = reactions[self._ordinal]
        on_hand = shifted_wrench(
            self._R_HJ, self._p_HJ, reaction.rotational(), reaction.translational()
        )
        noise = wrist_noise(context.get_time(), self._seed, self._settings)
        output.SetFromVector(noise - on_hand)
