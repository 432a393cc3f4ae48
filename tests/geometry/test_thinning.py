import itertools

import numpy as np
import pytest
from scipy import ndimage
from skimage.measure import euler_number

from vh_drake.geometry.thinning import thinned

CORNERS = np.ones((3, 3, 3))


def drawn(voxels, shape):
    line = np.zeros(shape, bool)
    line[tuple(voxels.T)] = True
    return line


@pytest.mark.parametrize("sides", list(itertools.permutations((10, 45, 7))))
@pytest.mark.parametrize("more", [0, 1])
def test_a_bar_thins_to_the_line_along_its_middle_whichever_way_it_lies(sides, more):
    voxels = thinned(np.ones(np.array(sides) + more, bool))
    long = int(np.argmax(sides))
    assert np.ptp(voxels[:, long]) >= 45 - 10 - 5
    middle = (np.array(sides) + more - 1) / 2
    others = np.delete(np.arange(3), long)
    assert np.abs(voxels - middle)[:, others].max() <= 1


def test_a_ball_thins_to_a_voxel_or_two_in_its_middle():
    nodes = np.stack(np.meshgrid(*[np.arange(-10, 11)] * 3, indexing="ij"), axis=-1)
    voxels = thinned((nodes**2).sum(axis=-1) < 64)
    assert len(voxels) <= 2
    np.testing.assert_allclose(voxels, 10, atol=1)


@pytest.mark.parametrize("seed", range(12))
def test_parts_and_holes_stay_as_many_as_they_were(seed):
    noise = ndimage.gaussian_filter(np.random.default_rng(seed).standard_normal([24] * 3), 2.0)
    solid = noise > 0.3 * noise.std()
    line = drawn(thinned(solid), solid.shape)
    assert not (line & ~solid).any()
    assert ndimage.label(line, CORNERS)[1] == ndimage.label(solid, CORNERS)[1]
    assert euler_number(line, connectivity=3) == euler_number(solid, connectivity=3)
    assert line.sum() < 0.2 * solid.sum()


def test_nothing_thins_to_nothing():
    assert thinned(np.zeros((4, 4, 4), bool)).shape == (0, 3)
