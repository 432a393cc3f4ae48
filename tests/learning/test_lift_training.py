import dataclasses as dc

import numpy as np
import pytest

from vh_drake.errors import BadInput
from vh_drake.learning.calibration import auc
from vh_drake.learning.lift_inputs import LIFT_NUMBERS
from vh_drake.learning.lift_model import check_metric, load_lift_model, save_lift_model
from vh_drake.learning.lift_training import (
    LiftSamples,
    LiftTrainingSettings,
    figures,
    fitted,
    folds,
    lift_samples,
    logits_of,
)
from vh_drake.learning.metric import load_metric
from vh_drake.learning.network import SEEN

QUICK = LiftTrainingSettings(judges=3, trees=10, epochs=12, batch=32)


def samples(count=900, seed=0):
    """Lifts that depend on two of the numbers, and on one of the things seen."""
    rng = np.random.default_rng(seed)
    numbers = rng.normal(size=(count, LIFT_NUMBERS))
    numbers[:, 5] = 3.0  # never varies
    seen = np.zeros((count, SEEN), np.float16)
    logit = 3 * numbers[:, 0] - 4 * np.abs(numbers[:, 12]) + 3
    lifted = rng.random(count) < 1 / (1 + np.exp(-logit))
    names = tuple(f"object_{i % 12}" for i in range(count))
    return LiftSamples(names, seen, numbers, lifted)


@pytest.fixture(scope="module")
def metric():
    return load_metric()


@pytest.fixture(scope="module")
def model(metric):
    return fitted(samples(), metric, QUICK)


def rates(model, other):
    return model.rate(model.hidden(other.seen.astype(np.float32)), other.numbers)[0]


def test_a_fitted_model_foretells_lifts_of_objects_it_never_saw(model, metric):
    other = samples(1000, seed=1)
    told = rates(model, other)
    assert auc(told, other.lifted) > 0.8
    assert abs(told.mean() - other.lifted.mean()) < 0.06
    assert 0.75 < model.card["unknown_objects"]["auc"] < 0.99
    assert figures(model)["lifts"] == 900
    assert figures(model)["objects"] == 12
    check_metric(model, metric)


def test_a_judge_never_learns_from_the_objects_that_it_judges(metric, model):
    plain = samples()
    unknown = folds(plain.objects, QUICK.judges, QUICK.seed)[0]
    turned = dc.replace(plain, lifted=np.where(unknown, ~plain.lifted, plain.lifted))
    again = fitted(turned, metric, QUICK).judges[0]
    np.testing.assert_array_equal(
        logits_of(again, plain, unknown), logits_of(model.judges[0], plain, unknown)
    )


def test_the_same_samples_give_the_same_model_and_its_file_says_the_same(model, metric, tmp_path):
    again, other = fitted(samples(), metric, QUICK), samples(50, seed=3)
    np.testing.assert_array_equal(rates(again, other), rates(model, other))
    assert again.calibration == model.calibration
    save_lift_model(tmp_path / "m.safetensors", model)
    read = load_lift_model(tmp_path / "m.safetensors")
    np.testing.assert_allclose(rates(read, other), rates(model, other), atol=1e-6)


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


def test_lifts_that_all_came_out_alike_teach_nothing(metric):
    alike = dc.replace(samples(), lifted=np.ones(900, bool))
    with pytest.raises(BadInput, match="came out alike"):
        fitted(alike, metric, QUICK)


def test_without_lifts_there_is_nothing_to_learn_from(tmp_path):
    (tmp_path / "scenes-00000.parquet").touch()
    with pytest.raises(BadInput):
        lift_samples([tmp_path], None, workers=1)
