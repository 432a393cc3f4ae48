import dataclasses as dc

import numpy as np
import pytest
from sklearn.ensemble import ExtraTreesClassifier

from vh_drake.errors import BadInput
from vh_drake.learning.calibration import auc
from vh_drake.learning.lift_inputs import INPUTS
from vh_drake.learning.lift_model import golden_rates, load_lift_model, save_lift_model
from vh_drake.learning.lift_training import (
    LiftSamples,
    LiftTrainingSettings,
    figures,
    fitted,
    folds,
    grown,
    lift_samples,
)
from vh_drake.learning.metric import load_metric, shipped_weights
from vh_drake.learning.training_objects import VALIDATION_KINDS

QUICK = LiftTrainingSettings(trees=40)


def samples(count=1800, seed=0):
    """Lifts that depend on two of the inputs, one of them not in proportion."""
    rng = np.random.default_rng(seed)
    inputs = rng.normal(size=(count, INPUTS))
    inputs[:, 5] = 3.0  # never varies
    logit = 3 * inputs[:, 0] - 4 * np.abs(inputs[:, 12]) + 3
    lifted = rng.random(count) < 1 / (1 + np.exp(-logit))
    names = tuple(f"object_{i % 12}" for i in range(count))
    return LiftSamples(names, inputs, lifted)


@pytest.fixture(scope="module")
def model():
    return fitted(samples(), QUICK)


def test_a_fitted_model_foretells_lifts_of_objects_it_never_saw(model):
    other = samples(2000, seed=1)
    told = model.rate(other.inputs)[0]
    assert auc(told, other.lifted) > 0.8
    assert abs(told.mean() - other.lifted.mean()) < 0.06
    assert 0.8 < model.card["unknown_objects"]["auc"] < 0.99
    assert figures(model)["lifts"] == 1800
    assert figures(model)["objects"] == 12


def test_trees_say_what_scikit_learn_s_say():
    learnt, other = samples(400), samples(200, seed=3).inputs.astype(np.float32)
    forest = ExtraTreesClassifier(
        QUICK.trees, min_samples_leaf=QUICK.leaf, max_features=QUICK.inputs_share, random_state=0
    )
    expected = forest.fit(learnt.inputs.astype(np.float32), learnt.lifted).predict_proba(other)
    shares = grown(learnt.inputs, learnt.lifted, QUICK).shares(other)
    np.testing.assert_allclose(shares.mean(axis=1), expected[:, 1], atol=1e-6)


def test_trees_that_are_all_alike_do_not_disagree(model):
    one = dc.replace(model.trees, root=np.repeat(model.trees.root[:1], 4))
    inputs = samples(100, seed=3).inputs
    np.testing.assert_allclose(dc.replace(model, trees=one).rate(inputs)[1], 0, atol=1e-6)
    few = dc.replace(model.trees, root=model.trees.root[:10])
    ratio = dc.replace(model, trees=few).rate(inputs)[1] / model.rate(inputs)[1]
    assert ratio.mean() == pytest.approx(2.0, abs=0.3)  # of 10 trees against 40


def test_the_same_samples_give_the_same_model(model):
    again = fitted(samples(), QUICK)
    np.testing.assert_array_equal(again.trees.threshold, model.trees.threshold)
    assert again.calibration == model.calibration


def with_a_stray_node(trees, name, value):
    """One more node, to which no tree leads, with a wrong value."""
    stray = {"feature": 0, "threshold": 0.0, "left": 0, "right": 0, "share": 0.5, name: value}
    added = {key: np.append(getattr(trees, key), own) for key, own in stray.items()}
    return dc.replace(trees, **added)


def test_a_model_survives_its_file_and_another_file_is_refused(model, tmp_path):
    path = tmp_path / "lift_model.safetensors"
    save_lift_model(path, model)
    inputs = samples(20, seed=2).inputs
    read = load_lift_model(path)
    np.testing.assert_allclose(read.rate(inputs), model.rate(inputs), atol=1e-6)
    for name, value in (("left", len(model.trees.left) + 1), ("right", -1), ("feature", INPUTS)):
        save_lift_model(path, dc.replace(model, trees=with_a_stray_node(model.trees, name, value)))
        with pytest.raises(BadInput, match="lead nowhere"):
            load_lift_model(path)
    with pytest.raises(BadInput, match="train anew"):
        load_lift_model(tmp_path / "none.safetensors")
    with pytest.raises(BadInput, match="no lift model"):
        load_lift_model(shipped_weights())


def test_the_shipped_model_says_what_its_card_says():
    shipped, metric = load_lift_model(), load_metric()
    np.testing.assert_allclose(golden_rates(shipped), shipped.card["golden"], atol=1e-5)
    assert shipped.card["hand"] == metric.card["hand"]
    assert not VALIDATION_KINDS & set(shipped.card["objects"])
    assert shipped.card["unknown_objects"]["auc"] > 0.8


def test_parts_of_the_objects_share_no_object():
    names = samples().objects
    parts = folds(names, 5, 0)
    np.testing.assert_array_equal(np.sum(parts, axis=0), 1)
    for part in parts:
        own = {name for name, inside in zip(names, part, strict=True) if inside}
        others = {name for name, inside in zip(names, part, strict=True) if not inside}
        assert own
        assert not own & others
    with pytest.raises(BadInput, match="are needed at least"):
        folds(("a", "b"), 5, 0)


def test_lifts_that_all_came_out_alike_teach_nothing():
    alike = dc.replace(samples(), lifted=np.ones(1800, bool))
    with pytest.raises(BadInput, match="came out alike"):
        fitted(alike, QUICK)


def test_without_lifts_there_is_nothing_to_learn_from(tmp_path):
    (tmp_path / "scenes-00000.parquet").touch()
    with pytest.raises(BadInput):
        lift_samples([tmp_path], None, workers=1)
