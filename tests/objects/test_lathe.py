import numpy as np
import pytest

from vh_drake.objects.lathe import box, cylinder, lathe, sphere


def test_a_turned_cone_has_its_closed_form_volume():
    cone = lathe([(0, 0), (0.03, 0), (0, 0.09)])
    assert cone.is_watertight
    assert cone.volume == pytest.approx(np.pi * 0.03**2 * 0.09 / 3, rel=5e-3)


def test_flattening_scales_the_volume():
    profile = [(0, 0), (0.03, 0), (0.03, 0.1), (0, 0.1)]
    assert lathe(profile, flatten=0.5).volume == pytest.approx(0.5 * lathe(profile).volume)


def test_plain_solids_stand_on_the_ground_with_their_volume():
    solids = {
        0.001: box((0.1, 0.1, 0.1)),
        np.pi * 0.04**2 * 0.1: cylinder(0.04, 0.1),
        4 / 3 * np.pi * 0.05**3: sphere(0.05),
    }
    for volume, solid in solids.items():
        assert solid.is_watertight
        assert solid.bounds[0, 2] == pytest.approx(0.0, abs=1e-12)
        assert solid.volume == pytest.approx(volume, rel=5e-3)
