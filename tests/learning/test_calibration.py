import numpy as np
import pytest
from scipy.special import expit
from sklearn.linear_model import LogisticRegression
from sklearn.metrics import roc_auc_score

from vh_drake.learning.calibration import Calibration, auc, fit_calibration, reliability


def drawn(count, seed=0):
    """Logits, and successes of a known probability."""
    rng = np.random.default_rng(seed)
    logits = rng.normal(0, 2, count)
    return logits, rng.random(count) < expit(0.6 * logits - 0.5)


def test_the_fit_is_that_of_scikit_learn():
    logits, success = drawn(2000)
    peer = LogisticRegression(C=1e9).fit(logits[:, None], success)
    fitted = fit_calibration(logits, success)
    assert fitted.slope == pytest.approx(peer.coef_[0, 0], rel=1e-3)
    assert fitted.offset == pytest.approx(peer.intercept_[0], abs=1e-3)


def test_a_fit_to_probabilities_is_that_to_many_draws_of_them():
    logits, _ = drawn(500)
    soft = expit(0.6 * logits - 0.5)
    fitted = fit_calibration(logits, soft)
    assert (fitted.slope, fitted.offset) == pytest.approx((0.6, -0.5), abs=1e-6)


def test_separable_classes_give_finite_numbers():
    fitted = fit_calibration(np.array([-2.0, -1.0, 1.0, 2.0]), np.array([0, 0, 1, 1]))
    assert np.isfinite([fitted.slope, fitted.offset]).all()


def test_calibration_lowers_the_error_of_overconfident_probabilities():
    logits, success = drawn(20_000)
    before = reliability(Calibration().probability(3 * logits), success).error
    fitted = fit_calibration(3 * logits, success)
    after = reliability(fitted.probability(3 * logits), success).error
    assert before > 0.1
    assert after < 0.02


def test_the_error_of_a_known_gap_is_that_gap():
    probability = np.full(1000, 0.9)
    success = np.arange(1000) < 700
    assert reliability(probability, success).error == pytest.approx(0.2)
    assert reliability(np.zeros(0), np.zeros(0, bool)).error == 0


def test_bins_hold_all_candidates_even_at_one():
    probability = np.array([0.0, 0.5, 1.0, 1.0])
    diagram = reliability(probability, np.ones(4, bool))
    assert diagram.count.sum() == 4
    assert diagram.predicted.max() == 1.0


def test_the_area_is_that_of_scikit_learn_ties_included():
    rng = np.random.default_rng(3)
    scores, positive = rng.integers(0, 8, 400).astype(float), rng.random(400) < 0.3
    assert auc(scores, positive) == pytest.approx(roc_auc_score(positive, scores))


def test_the_area_without_both_classes_is_a_half():
    assert auc(np.array([0.1, 0.7]), np.array([True, True])) == 0.5
