import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import RevoluteJoint, SpatialInertia, UnitInertia

from vh_drake.scenes.wrist import hand_inertia


def point_mass(mass, p_B):
    return SpatialInertia(mass, p_B, UnitInertia.PointMass(p_B))


def test_point_masses_of_two_bodies_add_up_about_the_base():
    plant = MultibodyPlant(0.0)
    p_palm, p_tip = np.array([0.02, 0.0, -0.05]), np.array([0.0, 0.0, 0.1])
    palm = plant.AddRigidBody("palm", point_mass(0.7, p_palm))
    tip = plant.AddRigidBody("tip", point_mass(0.2, p_tip))
    plant.AddJoint(RevoluteJoint("j", palm.body_frame(), tip.body_frame(), [0.0, 1.0, 0.0]))
    plant.Finalize()
    context = plant.CreateDefaultContext()
    plant.GetJointByName("j").set_angle(context, np.pi / 2)
    found = hand_inertia(plant, context, palm, [palm.index(), tip.index()])
    p_tip_H = np.array([0.1, 0.0, 0.0])
    masses, points = [0.7, 0.2], [p_palm, p_tip_H]
    I_H = sum(m * (p @ p * np.eye(3) - np.outer(p, p)) for m, p in zip(masses, points, strict=True))
    assert abs(found.mass - 0.9) < 1e-12
    np.testing.assert_allclose(found.p_HCom, (0.7 * p_palm + 0.2 * p_tip_H) / 0.9, atol=1e-12)
    np.testing.assert_allclose(found.I_H, I_H, atol=1e-12)
