import dataclasses as dc
import json

import numpy as np
import pytest
from lift_models import linear_model

from vh_drake.errors import BadInput
from vh_drake.learning.lift_inputs import LIFT_NUMBERS
from vh_drake.learning.lift_model import (
    FILE,
    check_metric,
    fingerprint,
    golden_rates,
    lift_model_beside,
    load_lift_model,
    save_lift_model,
)
from vh_drake.learning.metric import load_metric, shipped_weights
from vh_drake.learning.network import SEEN
from vh_drake.learning.training_objects import VALIDATION_KINDS
from vh_drake.learning.weights import load_weights, save_weights


@pytest.fixture(scope="module")
def metric():
    return load_metric()


def inputs(count=20, seed=2):
    rng = np.random.default_rng(seed)
    return rng.random((count, SEEN)).astype(np.float32), rng.normal(size=(count, LIFT_NUMBERS))


def test_the_probability_is_that_of_the_mean_logit_and_the_error_tells_how_they_differ(metric):
    model = linear_model(metric, (1.0, 3.0))
    seen, numbers = inputs()
    told, error = model.rate(model.hidden(seen), numbers)
    one, other = (1 / (1 + np.exp(-slope * numbers[:, 0])) for slope in (1.0, 3.0))
    np.testing.assert_allclose(told, 1 / (1 + np.exp(-2.0 * numbers[:, 0])), atol=1e-6)
    np.testing.assert_allclose(error, np.abs(one - other) / 2 / np.sqrt(2), atol=1e-6)


def test_a_model_survives_its_file_and_another_file_is_refused(metric, tmp_path):
    model, path = linear_model(metric, (1.0, 2.0)), tmp_path / FILE
    save_lift_model(path, model)
    seen, numbers = inputs()
    read = load_lift_model(path)
    rates = [own.rate(own.hidden(seen), numbers)[0] for own in (read, model)]
    np.testing.assert_allclose(*rates, atol=1e-6)
    with pytest.raises(BadInput, match="belong together"):
        load_lift_model(tmp_path / "none.safetensors")
    with pytest.raises(BadInput, match="no lift model"):
        load_lift_model(shipped_weights())
    arrays, card = load_weights(path)
    for count in (3, 10**9, "2"):
        save_weights(path, arrays, {**card, "judges": count})
        with pytest.raises(BadInput, match="train-lifts"):
            load_lift_model(path)
    for name, value in (("depths", [1]), ("depths", [1, 0]), ("depths", "11")):
        save_weights(path, arrays, {**card, name: value})
        with pytest.raises(BadInput, match="train-lifts"):
            load_lift_model(path)
    save_weights(path, {**arrays, "1/forest/left": np.full(1, 7)}, card)
    with pytest.raises(BadInput, match="lead nowhere"):
        load_lift_model(path)


def test_a_model_is_refused_beside_another_metric(metric):
    model = linear_model(metric, (1.0,))
    check_metric(model, metric)
    with pytest.raises(BadInput, match="belongs to other weights"):
        check_metric(dc.replace(model, card={}), metric)
    other = dc.replace(metric, network=type(metric.network)())
    assert fingerprint(other) != fingerprint(metric)


def test_the_model_of_weights_lies_beside_them(tmp_path):
    assert lift_model_beside(tmp_path / "grasp_metric.safetensors") == tmp_path / FILE
    assert lift_model_beside(None).is_file()


def test_the_shipped_model_says_what_its_card_says(metric):
    shipped = load_lift_model()
    np.testing.assert_allclose(golden_rates(shipped), shipped.card["golden"], atol=1e-5)
    check_metric(shipped, metric)
    assert shipped.card["hand"] == metric.card["hand"]
    assert not VALIDATION_KINDS & set(shipped.card["objects"])
    assert shipped.card["unknown_objects"]["auc"] > 0.8
    json.dumps(shipped.card)
