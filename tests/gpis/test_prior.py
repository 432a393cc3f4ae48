import numpy as np
import pytest
from views import P_CAMERA, TABLE, ball, box, view_of

from vh_drake.gpis.prior import (
    PriorSettings,
    column_tops,
    depth_image,
    point_spacing,
    prior_shape,
    sample,
    shadow,
    signed_distance,
)
from vh_drake.types import ContactSet, ObjectView, ScalarGrid


def grid(low=(0.6, -0.4, 0.87), high=(0.8, -0.2, 1.07), spacing=0.005):
    low, high = np.array(low), np.array(high)
    return ScalarGrid(low, spacing, np.zeros(np.round((high - low) / spacing).astype(int) + 1))


def at(field, p):
    return sample(field, np.atleast_2d(np.asarray(p, float)))[0]


def test_spacing_of_a_regular_set_is_its_step():
    line = np.column_stack([np.arange(10) * 0.004, np.zeros(10), np.zeros(10)])
    assert point_spacing(line) == pytest.approx(0.004)
    assert point_spacing(line[:1]) == 0.0


def test_depth_image_returns_the_depth_of_what_was_seen():
    view = view_of(box())
    z, seen = depth_image(view, least_pixel_m=0.003).depth_at(view.p_WO)
    assert np.all(seen <= z + 1e-9)
    assert np.median(z - seen) < 0.005


def test_rays_that_passed_beside_the_object_are_outside():
    view = view_of(ball())
    image = depth_image(view, least_pixel_m=0.003)
    side = view.p_WO.mean(axis=0) + 0.08 * np.cross(P_CAMERA - view.p_WO.mean(axis=0), [0, 0, 1.0])
    assert np.isinf(image.depth_at(side[None])[1]).all()


def test_shadow_holds_the_whole_object_and_nothing_before_it():
    p, n = ball()
    field = grid()
    view = view_of((p, n))
    solid = ScalarGrid(
        field.origin, field.spacing, shadow(view, field, nodes_of(field)).astype(float)
    )
    assert at(solid, 0.9 * (p - p.mean(axis=0)) + p.mean(axis=0)).mean() > 0.97
    before = view.p_WO + 0.02 * (P_CAMERA - view.p_WO) / np.linalg.norm(P_CAMERA - view.p_WO[0])
    assert at(solid, before).max() < 0.5


def nodes_of(field):
    axes = [field.origin[i] + field.spacing * np.arange(field.values.shape[i]) for i in range(3)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


def test_columns_reach_up_to_the_seen_top():
    tops = column_tops(view_of(box()), grid())
    inside = tops[np.isfinite(tops)]
    assert inside.max() == pytest.approx(1.02, abs=1e-6)
    assert inside.size * 0.005**2 == pytest.approx(0.1 * 0.06, rel=0.2)


def test_prior_of_a_box_is_the_box():
    p, _ = box()
    prior = prior_shape(view_of(box()), ContactSet(), grid(), PriorSettings())
    assert np.abs(at(prior, p)).max() < 0.012
    assert at(prior, [0.7, -0.3, 0.95])[0] < -0.02
    assert at(prior, [0.78, -0.3, 0.95])[0] > 0.02


def test_signed_distance_of_a_slab_is_linear():
    solid = np.zeros((20, 20, 20), bool)
    solid[:, :, :10] = True
    distance = signed_distance(solid, 0.01)
    np.testing.assert_allclose(distance[10, 10, 6:13], 0.01 * (np.arange(6, 13) - 9.5), atol=1e-3)


def test_face_seen_from_the_side_gets_depth():
    low_camera = np.array([0.0, -0.3, 0.97])
    p, n = box(sides=(0.1, 0.1, 0.12))
    face = n[:, 0] < -0.9
    view = ObjectView(p[face], n[face], TABLE, low_camera)
    flat = prior_shape(view, ContactSet(), grid(), PriorSettings(depth_share=0.0))
    deep = prior_shape(view, ContactSet(), grid(), PriorSettings())
    middle = [0.7, -0.3, 0.96]
    assert at(flat, middle)[0] > 0.02
    assert at(deep, middle)[0] < -0.02
    assert at(deep, [0.78, -0.3, 0.96])[0] > 0.02


def test_contacts_without_a_view_get_a_ball_behind_them():
    contacts = ContactSet(np.array([[0.7, -0.3, 1.0]]), np.array([[0.0, 0.0, 1.0]]))
    prior = prior_shape(ObjectView(), contacts, grid(), PriorSettings(ball_radius_m=0.03))
    assert at(prior, [0.7, -0.3, 0.97])[0] < -0.02
    assert abs(at(prior, [0.7, -0.3, 1.0])[0]) < 0.005


def test_sampled_gradient_is_that_of_a_linear_field():
    field = grid()
    linear = ScalarGrid(field.origin, field.spacing, nodes_of(field) @ np.array([1.0, -2.0, 0.5]))
    linear = ScalarGrid(field.origin, field.spacing, linear.values.reshape(field.values.shape))
    value, gradient = sample(linear, np.array([[0.703, -0.311, 0.95]]))
    assert value[0] == pytest.approx(0.703 + 0.622 + 0.475)
    np.testing.assert_allclose(gradient, [[1.0, -2.0, 0.5]], atol=1e-9)
