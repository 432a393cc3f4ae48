import numpy as np
import pytest

from vh_drake.errors import BadInput
from vh_drake.hand.tendon import SprungJoints

# Table 4.4: K in N mm/deg, pretension in deg.
K = np.rad2deg([0.67e-3, 0.82e-3, 0.82e-3])
THETA_0 = np.deg2rad([30, 30, 35])
FINGER = SprungJoints(K, THETA_0, np.full(3, np.pi / 2))


def test_free_joints_share_the_tendon_by_their_springs():
    angles = FINGER.angles_at_fraction(0.4)
    assert ((angles > 0) & (angles < np.pi / 2)).all()
    torques = K * (angles + THETA_0)  # Equal levers: equal force is equal torque.
    np.testing.assert_allclose(torques, torques[0])


@pytest.mark.parametrize("fraction", np.linspace(0, 1, 11))
def test_joint_angles_add_up_to_the_pulled_tendon(fraction):
    total = FINGER.angles_at_fraction(fraction).sum()
    assert total == pytest.approx(fraction * 3 * np.pi / 2)


def test_a_joint_at_its_stop_leaves_the_tendon_to_the_others():
    angles = FINGER.angles_at_fraction(0.9)
    assert angles[0] == pytest.approx(np.pi / 2)
    assert (angles[1:] < np.pi / 2).all()


def test_beyond_the_travel_the_joints_rest_at_their_stops():
    np.testing.assert_allclose(FINGER.angles_at_fraction(-1.0), 0)
    np.testing.assert_allclose(FINGER.angles_at_fraction(2.0), np.pi / 2)


def test_angles_are_given_for_many_fractions_at_once():
    fractions = np.linspace(0, 1, 6).reshape(2, 3)
    angles = FINGER.angles_at_fraction(fractions)
    assert angles.shape == (2, 3, 3)
    np.testing.assert_allclose(angles[1, 2], FINGER.angles_at_fraction(fractions[1, 2]))


def test_a_joint_without_spring_is_refused():
    with pytest.raises(BadInput, match="stiffness"):
        SprungJoints(np.array([0.0]), np.array([0.5]), np.array([1.0]))
