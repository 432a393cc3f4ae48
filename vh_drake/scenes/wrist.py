"""Mass properties of what hangs on the wrist sensor, read from the plant."""

from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, RigidBody
from pydrake.systems.framework import Context

from vh_drake.sensing.hand_load import HandInertia


def hand_inertia(
    plant: MultibodyPlant, context: Context, base: RigidBody, bodies: list[BodyIndex]
) -> HandInertia:
    """What the contact estimation must know of the hand to take its weight off.

    Args:
        plant: finalized.
        context: of the plant; the fingers' posture in it counts.
        base: the hand's base, whose frame is H.
        bodies: all bodies of the hand, the base among them.

    Returns:
        Mass, centre of mass and rotational inertia about H's origin, in H.
    """
    inertia = plant.CalcSpatialInertia(context, base.body_frame(), bodies)
    return HandInertia(
        inertia.get_mass(),
        inertia.get_com(),
        inertia.CalcRotationalInertia().CopyToFullMatrix3(),
    )
