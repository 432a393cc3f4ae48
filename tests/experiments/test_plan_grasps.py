import numpy as np
import pytest
from experiments.plan_inputs import SIDES, YAW, box_cloud, object_alone
from sensing.synthetic_views import TABLE_Z, table, view

from vh_drake.errors import BadInput, NothingSeen
from vh_drake.experiments.plan_grasps import plan_grasps, widened_workspace
from vh_drake.types import Cloud, ContactSet, Plane


@pytest.fixture(scope="module")
def cloud():
    return box_cloud()


@pytest.fixture(scope="module")
def plan(cloud):
    return plan_grasps(cloud)


def distance_to_box(p_W):
    """Signed distance (n,) of points to the true box, in closed form [m]."""
    c, sn = np.cos(YAW), np.sin(YAW)
    R_WB = np.array([[c, -sn, 0.0], [sn, c, 0.0], [0.0, 0.0, 1.0]])
    beyond = np.abs((p_W - [0.7, -0.3, TABLE_Z + SIDES[2] / 2]) @ R_WB) - np.array(SIDES) / 2
    outside = np.linalg.norm(np.maximum(beyond, 0.0), axis=1)
    return outside + np.minimum(beyond.max(axis=1), 0.0)


def test_table_and_surface_are_those_of_the_box(plan):
    assert plan.view.table.offset == pytest.approx(TABLE_Z, abs=0.002)
    distance = distance_to_box(plan.surface.vertices)
    assert np.median(np.abs(distance)) < 0.003
    assert np.abs(distance).max() < 0.03


def test_grasps_are_ranked_rigid_and_about_the_box(plan):
    assert len(plan.ranking) == len(plan.candidates) > 100
    ranked = plan.scores.score[list(plan.ranking)]
    assert (np.diff(ranked) <= 0.0).all()
    assert 0.3 < ranked[0] <= 1.0
    R = plan.candidates.X_WH[:, :3, :3]
    np.testing.assert_allclose(
        R @ R.transpose(0, 2, 1), np.tile(np.eye(3), (len(R), 1, 1)), atol=1e-9
    )
    np.testing.assert_allclose(np.linalg.det(R), 1.0)
    tcp = np.append(plan.hand.description.tcps["power"], 1.0)
    offset = (plan.candidates.X_WH @ tcp)[:, :2] - [0.7, -0.3]
    assert np.linalg.norm(offset, axis=1).max() < 0.5 * np.hypot(*SIDES[:2]) + 0.08


def test_no_open_hand_reaches_into_the_table(plan):
    centers, radii = plan.hand.spheres(plan.hand.lower)
    for X in plan.candidates.X_WH:
        assert ((centers @ X[:3, :3].T + X[:3, 3])[:, 2] - radii).min() > TABLE_Z - 0.002


def test_the_surface_comes_to_a_touched_place(cloud, plan):
    """The back of the box, which the camera does not see, is said to lie 1 cm farther away."""
    p, n = np.array([[0.7 + 0.055, -0.3, 0.92]]), np.array([[1.0, 0.0, 0.0]])
    touched = plan_grasps(
        Cloud(object_alone(cloud), cloud.p_WCamera),
        contacts=ContactSet(p, n),
        table=Plane(np.array([0.0, 0.0, 1.0]), TABLE_Z),
    )
    before, after = (
        np.linalg.norm(known.surface.vertices - p, axis=1).min() for known in (plan, touched)
    )
    assert before > 0.008
    assert after < 0.6 * before  # A prior of 5 mm, a contact of 2 mm.
    assert len(touched.candidates) > 100


def test_a_cloud_without_table_or_object_is_no_plan(cloud):
    with pytest.raises(NothingSeen, match="give its table with --table"):
        plan_grasps(Cloud(object_alone(cloud), cloud.p_WCamera))
    with pytest.raises(NothingSeen, match="no object on the table"):
        plan_grasps(view([table()]))
    with pytest.raises(BadInput, match="no points"):
        plan_grasps(Cloud())


def test_a_camera_below_the_table_is_refused(cloud):
    with pytest.raises(BadInput, match="is not over the table"):
        plan_grasps(Cloud(cloud.p_WC))


def test_a_cloud_in_millimetres_is_refused(cloud):
    with pytest.raises(BadInput, match="are they in millimetres"):
        plan_grasps(Cloud(1000.0 * cloud.p_WC, 1000.0 * cloud.p_WCamera))


def test_far_points_do_not_widen_the_search_without_bound(cloud):
    p = np.vstack([cloud.p_WC, [[900.0, -900.0, 900.0]]])
    settings = widened_workspace(Cloud(p, cloud.p_WCamera))
    assert (np.subtract(settings.workspace_max, settings.workspace_min) <= 2.0).all()
    near = widened_workspace(cloud)
    assert (cloud.p_WC > near.workspace_min).all()
    assert (cloud.p_WC < near.workspace_max).all()
