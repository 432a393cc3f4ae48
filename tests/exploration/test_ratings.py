import numpy as np
import pytest

from vh_drake.exploration.ratings import (
    IgefSettings,
    igef,
    locality,
    rotation,
    travel,
    uncertainty,
)

CONTACTS = np.array([[0.0, 0, 0], [0.1, 0, 0]])


def test_uncertainty_is_zero_at_a_contact_and_one_far_away():
    psi = uncertainty(np.array([[0.1, 0, 0], [5.0, 0, 0]]), CONTACTS, sigma1_m=0.15)
    np.testing.assert_allclose(psi, [0.0, 1.0], atol=1e-12)


def test_uncertainty_follows_the_nearest_contact():
    psi = uncertainty(np.array([[0.13, 0, 0]]), CONTACTS, sigma1_m=0.15)
    assert psi[0] == pytest.approx(1 - np.exp(-(0.03**2) / 0.15**2))


def test_locality_sums_over_contacts_and_peaks_at_its_distance():
    rings = np.column_stack([np.zeros(3), [0.03, 0.04, 0.05], np.zeros(3)])
    psi = locality(rings, CONTACTS[:1], mu3_m=0.04, sigma3_m=0.005)
    assert psi.argmax() == 1
    assert psi[1] == pytest.approx(1.0)
    twice = locality(rings, np.vstack([CONTACTS[:1]] * 2), mu3_m=0.04, sigma3_m=0.005)
    np.testing.assert_allclose(twice, 2 * psi)


def test_travel_is_the_inverse_length():
    np.testing.assert_allclose(travel(np.array([0.5, 0.1])), [2.0, 10.0])


def test_rotation_is_one_when_the_fingertip_need_not_turn():
    down = np.array([0.0, 0.0, -1.0])
    normals = np.array([[0, 0, 1.0], [1.0, 0, 0], [0, 0, -1.0]])
    psi = rotation(down, normals, sigma_alpha=1.0)
    alpha = np.array([0.0, np.pi / 2, np.pi])
    np.testing.assert_allclose(psi, np.exp(-2 * np.sin(alpha / 2) ** 2), atol=1e-12)


def test_igef_is_the_product_and_does_not_change_under_a_rigid_motion():
    rng = np.random.default_rng(0)
    p, n = rng.uniform(-0.1, 0.1, (20, 3)), rng.normal(size=(20, 3))
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    lengths, approach = rng.uniform(0.05, 0.2, 20), np.array([0.0, 0.6, 0.8])
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    rating = igef(p, n, CONTACTS, lengths, approach, IgefSettings())
    moved = igef(
        p @ turn.T + 1.0,
        n @ turn.T,
        CONTACTS @ turn.T + 1.0,
        lengths,
        turn @ approach,
        IgefSettings(),
    )
    product = rating.uncertainty * rating.locality * rating.travel * rating.rotation
    np.testing.assert_allclose(rating.product, product)
    np.testing.assert_allclose(moved.product, rating.product, rtol=1e-8)


def test_without_contacts_only_cost_counts():
    p = np.zeros((2, 3))
    rating = igef(
        p, np.eye(3)[:2], np.zeros((0, 3)), np.ones(2), np.array([-1.0, 0, 0]), IgefSettings()
    )
    np.testing.assert_array_equal(rating.uncertainty * rating.locality, [1.0, 1.0])
    assert rating.product.argmax() == 0
