import dataclasses as dc

import numpy as np
import pytest
from sklearn.ensemble import ExtraTreesClassifier

from vh_drake.errors import BadInput
from vh_drake.learning.forest import grow_forest, read_forest

NUMBERS = 8


def samples(count, seed):
    rng = np.random.default_rng(seed)
    numbers = rng.normal(size=(count, NUMBERS))
    numbers[:, 5] = 3.0  # never varies
    logit = 3 * numbers[:, 0] - 4 * np.abs(numbers[:, 2]) + 3
    return numbers, rng.random(count) < 1 / (1 + np.exp(-logit))


@pytest.fixture(scope="module")
def forest():
    return grow_forest(*samples(400, 0), trees=40, leaf=5, numbers_share=0.4, seed=0)


def test_trees_say_what_scikit_learn_s_say(forest):
    numbers, yes = samples(400, 0)
    other = samples(200, 3)[0].astype(np.float32)
    peer = ExtraTreesClassifier(40, min_samples_leaf=5, max_features=0.4, random_state=0)
    expected = peer.fit(numbers.astype(np.float32), yes).predict_proba(other)[:, 1]
    np.testing.assert_allclose(forest.shares(other).mean(axis=1), expected, atol=1e-6)
    inside = np.clip(expected, 1e-3, 1 - 1e-3)
    np.testing.assert_allclose(forest.logits(other), np.log(inside / (1 - inside)), atol=1e-5)


def test_a_forest_survives_its_arrays(forest):
    again = read_forest(forest.arrays(), forest.depth, NUMBERS)
    numbers = samples(100, 1)[0]
    np.testing.assert_allclose(again.shares(numbers), forest.shares(numbers), atol=1e-6)


@pytest.mark.parametrize(
    ("name", "value"), [("left", 10**6), ("right", -1), ("feature", NUMBERS), ("root", 10**6)]
)
def test_trees_that_lead_nowhere_are_refused(forest, name, value):
    column = getattr(forest, name).copy()
    column[-1] = value
    with pytest.raises(BadInput, match="lead nowhere"):
        read_forest(dc.replace(forest, **{name: column}).arrays(), forest.depth, NUMBERS)


def test_a_depth_that_is_none_or_missing_arrays_are_refused(forest):
    for depth in (0, 10**6):
        with pytest.raises(BadInput, match="lead nowhere"):
            read_forest(forest.arrays(), depth, NUMBERS)
    with pytest.raises(BadInput, match="no trees"):
        read_forest({}, 3, NUMBERS)
    with pytest.raises(BadInput, match="no trees"):
        read_forest(forest.arrays(), None, NUMBERS)
