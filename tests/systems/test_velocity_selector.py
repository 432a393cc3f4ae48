import numpy as np
import pytest
from leaf import Leaf

from vh_drake.systems.velocity_selector import VelocitySelector

POSITION, TRAJECTORY = np.arange(6.0), -np.arange(6.0)


@pytest.mark.parametrize("caching", [True, False])
def test_the_selector_follows_its_switch_either_way(caching):
    leaf = Leaf(
        VelocitySelector(),
        caching=caching,
        position_control=POSITION,
        trajectory=TRAJECTORY,
        follow=0.0,
    )
    np.testing.assert_array_equal(leaf.get("spatial_velocity"), POSITION)
    leaf.fix(follow=1.0)
    np.testing.assert_array_equal(leaf.get("spatial_velocity"), TRAJECTORY)
    leaf.fix(trajectory=2 * TRAJECTORY)
    np.testing.assert_array_equal(leaf.get("spatial_velocity"), 2 * TRAJECTORY)


def test_only_the_chosen_driver_needs_to_be_there():
    leaf = Leaf(VelocitySelector(), position_control=POSITION, follow=0.0)
    np.testing.assert_array_equal(leaf.get("spatial_velocity"), POSITION)
