import dataclasses as dc

import numpy as np
import pytest
import torch
from learning_scenes import can_scene

from vh_drake.errors import BadInput
from vh_drake.learning.features import NUMBERS
from vh_drake.learning.hints import HINT_NUMBERS
from vh_drake.learning.network import RATE, SUCCESS, GraspNetwork
from vh_drake.learning.samples import (
    batches,
    inputs_of,
    scene_samples,
    split_objects,
    without_hints,
)
from vh_drake.learning.training import (
    TrainingSettings,
    curves_csv,
    learning_rate_factor,
    loss,
    predict,
    train,
)

QUICK = TrainingSettings(epochs=2, rounds_per_epoch=1, batch=32, held_out=0.34)


@pytest.fixture(scope="module")
def scenes():
    """Four scenes whose success depends on the height of the hand alone."""
    made = scene_samples(can_scene(), *inputs_of(can_scene()))
    high = made.X_WH[:, 2, 3] > np.median(made.X_WH[:, 2, 3])
    rate = np.where(high, 0.95, 0.2)
    return [
        dc.replace(made, object=name, rate=rate, success=high.astype(float))
        for name in ("a", "b", "c", "d")
    ]


def test_every_candidate_is_in_one_batch(scenes):
    rng = np.random.default_rng(0)
    targets = torch.cat([batch.targets for batch in batches(scenes, 32, rng)])
    assert len(targets) == sum(map(len, scenes))
    expected = np.sort(np.concatenate([scene.rate for scene in scenes]))
    np.testing.assert_allclose(np.sort(targets[:, RATE].numpy()), expected, atol=1e-6)


def test_hints_are_hidden_where_asked_for():
    numbers = torch.ones(3, NUMBERS)
    hidden = without_hints(numbers, torch.tensor([True, False, True]))
    assert hidden[:, -HINT_NUMBERS:].sum(dim=1).tolist() == [0, HINT_NUMBERS, 0]
    assert (hidden[:, :-HINT_NUMBERS] == 1).all()
    assert without_hints(numbers)[:, -HINT_NUMBERS:].sum() == 0


def test_the_loss_is_least_at_the_targets():
    targets = torch.tensor([[0.7, 0.4]])
    logits = torch.logit(targets)
    least = loss(logits, targets)
    for step in ([0.3, 0.0], [-0.3, 0.0], [0.0, 0.3], [0.0, -0.3]):
        assert loss(logits + torch.tensor([step]), targets) > least


def test_objects_are_split_without_overlap_and_the_same_way_every_time():
    names = [f"object {i}" for i in range(20)]
    learnt, held = split_objects(names * 3, 0.2, 4)
    assert learnt | held == set(names)
    assert not learnt & held
    assert len(held) == 4
    assert split_objects(sorted(names), 0.2, 4) == (learnt, held)
    with pytest.raises(BadInput, match="at least two"):
        split_objects(["one"], 0.2, 0)


def test_training_lowers_the_loss_on_objects_it_never_saw(scenes, tmp_path):
    settings = dc.replace(QUICK, epochs=6, batch=16, learning_rate=5e-3)
    trained = train(scenes, tmp_path, settings)
    losses = [r.held_loss for r in trained.rounds]
    assert min(losses) < 0.9 * losses[0]
    assert set(trained.learnt) | set(trained.held_out) == {"a", "b", "c", "d"}
    assert (tmp_path / "curves.csv").read_text() == curves_csv(trained.rounds)


def test_a_resumed_run_ends_as_one_that_was_never_stopped(scenes, tmp_path):
    whole = train(scenes, tmp_path / "whole", QUICK)

    class StoppedError(Exception):
        pass

    def stop(_round):
        raise StoppedError

    with pytest.raises(StoppedError):
        train(scenes, tmp_path / "cut", QUICK, stop)
    resumed = train(scenes, tmp_path / "cut", QUICK)
    assert resumed.rounds == whole.rounds
    np.testing.assert_array_equal(predict(resumed.network, scenes), predict(whole.network, scenes))


def test_a_checkpoint_of_other_settings_is_refused(scenes, tmp_path):
    train(scenes, tmp_path, dc.replace(QUICK, epochs=1))
    with pytest.raises(BadInput, match="other settings"):
        train(scenes, tmp_path, dc.replace(QUICK, seed=3, epochs=1))


def test_unusable_settings_are_refused(scenes, tmp_path):
    for bad in ({"epochs": 0}, {"learning_rate": 0.0}, {"held_out": 1.0}):
        with pytest.raises(BadInput, match="training settings"):
            train(scenes, tmp_path, dc.replace(QUICK, **bad))


def test_the_learning_rate_rises_then_falls_to_zero():
    factors = [learning_rate_factor(share) for share in np.linspace(0, 1, 101)]
    assert max(factors) == pytest.approx(1.0, abs=0.01)
    assert int(np.argmax(factors)) == pytest.approx(10, abs=1)
    assert factors[-1] == pytest.approx(0.0, abs=1e-12)


def test_an_untrained_network_starts_from_the_rate_on_the_estimate():
    torch.manual_seed(0)
    network = GraspNetwork().eval()
    numbers = torch.zeros(2, NUMBERS)
    numbers[:, -HINT_NUMBERS] = 1
    numbers[:, 1 - HINT_NUMBERS] = torch.tensor([-1.0, 1.0])
    with torch.inference_mode():
        logits = network(torch.zeros(2, 2, 32, 32, 32), numbers)
    assert logits[1, SUCCESS] - logits[0, SUCCESS] > 5
    assert logits[1, RATE] - logits[0, RATE] > 5
