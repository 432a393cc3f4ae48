import numpy as np

from vh_drake.learning.soft_labels import RatePrior, fit_prior


def test_success_is_the_share_of_the_posterior_over_the_threshold():
    rate, samples = np.array([0.5, 0.8, 1.0]), np.array([40, 40, 40])
    prior = RatePrior(0.5, 0.4)
    rng = np.random.default_rng(0)
    closed = (rate * samples).astype(int)
    drawn = rng.beta(closed + 0.5, samples - closed + 0.4, (100_000, 3))
    told = prior.success_probability(rate, samples)
    np.testing.assert_allclose(told, (drawn > 0.8).mean(axis=0), atol=0.01)


def test_the_prior_is_found_from_which_rates_were_drawn():
    rng = np.random.default_rng(1)
    samples = rng.choice([20, 30, 48], 20_000)
    rate = rng.binomial(samples, rng.beta(0.5, 0.3, len(samples))) / samples
    prior = fit_prior(rate, samples)
    np.testing.assert_allclose([prior.closing, prior.failing], [0.5, 0.3], rtol=0.05)


def test_targets_by_the_fitted_prior_are_calibrated_where_uniform_ones_are_not():
    rng = np.random.default_rng(2)
    true = rng.beta(0.5, 0.3, 50_000)
    samples = np.full(len(true), 20)
    rate = rng.binomial(20, true) / 20
    nearly = rate == 0.95
    fitted, uniform = (
        prior.success_probability(rate[nearly], samples[nearly])[0]
        for prior in (fit_prior(rate, samples), RatePrior())
    )
    share = (true[nearly] > 0.8).mean()
    assert abs(fitted - share) < 0.01 < abs(uniform - share)


def test_labels_that_are_all_alike_leave_a_finite_prior():
    prior = fit_prior(np.ones(50), np.full(50, 20))
    assert np.isfinite([prior.closing, prior.failing]).all()
    assert prior.success_probability(np.ones(1), np.array([20]))[0] > 0.99
