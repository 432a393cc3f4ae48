import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from trimesh.creation import box

from vh_drake.sensing.camera_correction import corrected, left_covariance, moved, table_error
from vh_drake.sensing.segmentation import SegmentationSettings, segment
from vh_drake.types import Cloud, ObjectView, Plane

sys.path.insert(0, str(Path(__file__).parent))
from synthetic_views import TABLE_Z, on_table, table, view

KNOWN = Plane(offset=TABLE_Z)
SETTINGS = SegmentationSettings(known_height_m=TABLE_Z)


def misplaced(cloud, rotvec, shift):
    """The cloud as a camera believes it that is wrong by a turn about itself and a shift."""
    R = Rotation.from_rotvec(rotvec).as_matrix()
    p_WCamera = cloud.p_WCamera + shift
    p_WC = (cloud.p_WC - cloud.p_WCamera) @ R.T + p_WCamera
    return Cloud(p_WC, p_WCamera, cloud.n_WFrustum @ R.T)


def seen_plane(p_W):
    centre = p_W.mean(axis=0)
    normal = np.linalg.eigh(np.cov((p_W - centre).T))[1][:, 0]
    normal *= np.sign(normal[2])
    return Plane(normal, float(normal @ centre))


def table_cloud():
    xy = np.random.default_rng(3).uniform([0.45, -0.7], [1.1, 0.1], (500, 2))
    return Cloud(np.column_stack([xy, np.full(500, TABLE_Z)]), np.array([0.21, 0.0, 1.82]))


@pytest.mark.parametrize("rotvec", [(0.04, -0.03, 0.0), (0.0, 0.05, 0.0), (-0.02, 0.0, 0.0)])
@pytest.mark.parametrize("rise_m", [0.0, 0.012, -0.008])
def test_the_table_tells_tilt_and_height_exactly(rotvec, rise_m):
    truth = table_cloud()
    cloud = misplaced(truth, rotvec, np.array([0.0, 0.0, rise_m]))
    error = table_error(seen_plane(cloud.p_WC), KNOWN, cloud.p_WCamera)
    assert error.tilt_rad == pytest.approx(np.linalg.norm(rotvec), abs=1e-9)
    assert error.rise_m == pytest.approx(rise_m, abs=1e-9)
    back = corrected(cloud, error, KNOWN)
    np.testing.assert_allclose(back.p_WC, truth.p_WC, atol=1e-9)
    np.testing.assert_allclose(back.p_WCamera, truth.p_WCamera, atol=1e-9)


def test_what_the_table_can_not_tell_is_as_large_as_its_covariance_says():
    rng = np.random.default_rng(0)
    p_WO, truth = np.array([[0.7, -0.3, 0.95]]), table_cloud()
    left, told = [], []
    for turn, shift in zip(*rng.standard_normal((2, 400, 3)), strict=True):
        # As 10 mm with 3 degrees in all, each axis alike.
        rotvec, p = np.deg2rad(3.0) / np.sqrt(3) * turn, 0.01 / np.sqrt(3) * shift
        cloud = misplaced(Cloud(np.vstack([truth.p_WC, p_WO]), truth.p_WCamera), rotvec, p)
        error = table_error(seen_plane(cloud.p_WC[:-1]), KNOWN, cloud.p_WCamera)
        back = corrected(cloud, error, KNOWN)
        left.append(p_WO[0] - back.p_WC[-1])
        told.append(left_covariance(error, KNOWN, back.p_WCamera, back.p_WC[-1]))
    truth_m2 = np.mean([np.outer(x, x) for x in left], axis=0)
    values = [np.linalg.eigvalsh(c)[1:] for c in (truth_m2, np.mean(told, axis=0))]
    np.testing.assert_allclose(values[1], values[0], rtol=0.25)
    assert abs(np.array(left)[:, 2]).max() < 1e-3


@pytest.fixture(scope="module")
def looked():
    return view([table(), on_table(box((0.175, 0.09, 0.045)))])


def test_a_known_table_makes_up_for_a_tilted_camera(looked):
    true = segment(looked, SETTINGS)
    wrong = misplaced(looked, (0.03, -0.035, 0.0), np.array([0.0, 0.0, 0.008]))
    seen = segment(wrong, SETTINGS)
    assert seen.table.offset == TABLE_Z
    assert np.linalg.norm(segment(wrong).p_WO.mean(axis=0) - true.p_WO.mean(axis=0)) > 0.03
    np.testing.assert_allclose(seen.p_WO.mean(axis=0), true.p_WO.mean(axis=0), atol=1e-3)
    assert np.linalg.eigvalsh(seen.shift_covariance)[-1] > 0.01**2


def test_noise_alone_corrects_nothing(looked):
    seen, plain = segment(looked, SETTINGS), segment(looked)
    np.testing.assert_array_equal(seen.p_WO, plain.p_WO)
    assert not seen.shift_covariance.any()


def test_a_view_moves_with_its_camera():
    view = ObjectView(np.ones((2, 3)), np.ones((2, 3)), KNOWN, np.zeros(3))
    there = moved(view, np.array([0.01, 0.0, 0.0]), np.eye(3))
    np.testing.assert_allclose(there.p_WO - view.p_WO, [[0.01, 0, 0]] * 2)
    np.testing.assert_allclose(there.p_WCamera, [0.01, 0, 0])
    np.testing.assert_array_equal(there.n_WO, view.n_WO)
    np.testing.assert_array_equal(there.shift_covariance, np.eye(3))
