from dataclasses import replace

import numpy as np
import pytest

from vh_drake.exploration.ratings import IgefSettings
from vh_drake.exploration.strategies import (
    Facing,
    GpVariance,
    Igef,
    PotentialField,
    Random,
    Situation,
    UncertaintyCost,
)
from vh_drake.gpis.kernels import ThinPlate
from vh_drake.gpis.observations import surface_observations
from vh_drake.gpis.posterior import fit
from vh_drake.types import ContactSet

UP = np.array([0.0, 0.0, 1.0])


def plane(contacts=((0.0, 0.0, 0.0),)):
    """Candidates on a plane, the fingertip on the last contact."""
    p_WC = np.array(contacts, float)
    n_WC = np.tile(UP, (len(p_WC), 1))
    x, y = np.meshgrid(np.linspace(-0.06, 0.06, 25), np.linspace(-0.06, 0.06, 25))
    p = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    seen = surface_observations(p_WC, n_WC, value_std_m=5e-4, gradient_std=0.03)
    return Situation(
        p=p,
        n=np.tile(UP, (len(p), 1)),
        contacts=ContactSet(p_WC, n_WC),
        posterior=fit(ThinPlate(), seen),
        p_WTip=p_WC[-1] + 0.005 * UP,
        departure_W=UP,
        approach_W=-UP,
        tip_radius_m=0.005,
        explored_radius_m=0.02,
        seed=0,
    )


def best(strategy, situation):
    return situation.p[int(np.argmax(strategy.rate(situation)))]


def test_igef_is_the_product_of_its_four_metrics():
    situation, strategy = plane(), Igef()
    m = strategy.metrics(situation)
    product = m.uncertainty * m.locality * m.travel * m.rotation
    np.testing.assert_allclose(strategy.rate(situation), product)


def test_igef_touches_at_about_its_distance():
    strategy = Igef(IgefSettings(sigma1_m=0.15, mu3_m=0.04, sigma3_m=0.005))
    assert np.linalg.norm(best(strategy, plane())) == pytest.approx(0.04, abs=0.005)


def test_variance_goes_as_far_as_it_can():
    assert np.linalg.norm(best(GpVariance(), plane())) == pytest.approx(0.06 * np.sqrt(2))


def test_a_place_that_faces_as_no_contact_nearby_stands_out():
    situation = plane([[0.0, 0.0, 0.0], [0.05, 0.05, 0.0]])
    n = situation.n.copy()
    near = int(np.argmin(np.linalg.norm(situation.p - [0.01, 0.0, 0.0], axis=1)))
    n[near] = [0.0, 1.0, 0.0]
    rating = Facing().rate(replace(situation, n=n))
    assert rating[near] == pytest.approx(1.0)
    assert int(np.argmax(rating)) == near
    rating = Facing(width_m=0.03).rate(situation)
    distance = np.linalg.norm(situation.p[:, None] - situation.contacts.p_WC, axis=2).min(axis=1)
    np.testing.assert_allclose(rating, 1.0 - np.exp(-((distance / 0.03) ** 2)), atol=1e-12)


def test_variance_finds_the_highest_although_it_looks_at_few_candidates_first():
    situation = plane([[0.05, 0.05, 0], [-0.05, 0.05, 0], [0.05, -0.05, 0], [0.01, 0.0, 0]])
    few = GpVariance(first=60).rate(situation)
    exact = situation.posterior.variance(situation.p)
    assert few.max() == pytest.approx(exact.max(), rel=0.02)
    seen = np.isfinite(few)
    np.testing.assert_allclose(few[seen], exact[seen])


def test_chance_depends_on_seed_and_number_of_contacts_alone():
    situation = plane()
    rating = Random().rate(situation)
    np.testing.assert_array_equal(rating, Random().rate(situation))
    assert not np.array_equal(rating, Random().rate(replace(situation, seed=1)))
    assert not np.array_equal(rating, Random().rate(plane([[0, 0, 0], [0.02, 0, 0]])))


def test_cost_that_weighs_nothing_leaves_the_variance():
    situation = plane()
    far = np.linalg.norm(best(UncertaintyCost(theta=0.0), situation))
    near = np.linalg.norm(best(UncertaintyCost(theta=10.0), situation))
    assert far == pytest.approx(0.06 * np.sqrt(2))
    assert near < 0.01


def test_the_field_draws_away_from_contacts():
    situation = plane([[-0.05, 0, 0], [-0.03, 0.02, 0], [-0.03, -0.02, 0], [0.0, 0, 0]])
    assert best(PotentialField(), situation)[0] > 0.0


@pytest.mark.parametrize(
    "strategy",
    [Igef(), GpVariance(), UncertaintyCost(), PotentialField()],
    ids=lambda s: type(s).__name__,
)
def test_ratings_do_not_depend_on_where_the_world_has_its_origin(strategy):
    situation = plane([[0.031, 0.012, 0], [0.0, 0, 0]])
    shift = np.array([0.1, -0.2, 0.3])
    seen = situation.contacts
    moved = replace(
        situation,
        p=situation.p + shift,
        contacts=ContactSet(seen.p_WC + shift, seen.n_WC),
        posterior=fit(
            ThinPlate(),
            surface_observations(seen.p_WC + shift, seen.n_WC, value_std_m=5e-4, gradient_std=0.03),
        ),
        p_WTip=situation.p_WTip + shift,
    )
    np.testing.assert_allclose(strategy.rate(moved), strategy.rate(situation), rtol=1e-5, atol=1e-9)
