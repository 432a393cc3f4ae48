import numpy as np

from vh_drake.geometry.colors import score_colors, variance_colors


def test_uncertainty_turns_from_dark_violet_to_yellow():
    certain, guess = variance_colors(np.array([0.0, 1.0]), top_std=1.0)
    assert certain[2] > certain[1]
    assert min(guess[0], guess[1]) > 0.8 > 0.3 > guess[2]


def test_brightness_never_falls_as_the_variance_rises():
    colors = variance_colors(np.linspace(0.0, 2.0, 100) ** 2, top_std=1.5)
    assert (np.diff(colors @ [0.2126, 0.7152, 0.0722]) > -1e-3).all()


def test_equal_variances_have_equal_colours_whatever_stands_beside_them():
    alone = variance_colors(np.array([0.5]), top_std=2.0)
    together = variance_colors(np.array([0.5, 100.0]), top_std=2.0)
    np.testing.assert_array_equal(alone[0], together[0])


def test_good_scores_are_green_and_bad_or_unknown_ones_red():
    good, bad, unknown = score_colors(np.array([1.0, 0.0, np.nan]))
    assert good[1] > good[0]
    assert bad[0] > bad[1]
    np.testing.assert_array_equal(unknown, bad)
