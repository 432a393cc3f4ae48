import numpy as np
from learning_scenes import can_scene
from scenery import right_hand

from vh_drake.learning.knowledge import scene_knowledge
from vh_drake.learning.lift_inputs import LIFT_NUMBERS, lift_inputs, with_success
from vh_drake.learning.lift_training import scene_inputs
from vh_drake.learning.metric import Prediction
from vh_drake.learning.network import SEEN
from vh_drake.types import Candidates


def told(count, success):
    """A metric's word, the same of all grasps."""
    return Prediction(*(np.full(count, p) for p in (success, 0.6, 0.0)), np.zeros((count, SEEN)))


def test_inputs_are_finite_and_of_one_magnitude():
    known, hand = scene_knowledge(can_scene()), right_hand()

    def told(count, success):
        return Prediction(
            *(np.full(count, p) for p in (success, 0.6, 0.0)), np.zeros((count, SEEN))
        )

    count = len(known.candidates)
    inputs = lift_inputs(known, hand, told(count, 1.0))
    assert inputs.shape == (count, LIFT_NUMBERS)
    assert np.isfinite(inputs).all()
    assert np.abs(inputs).max() < 10
    other = with_success(inputs, np.full(count, 0.3))
    np.testing.assert_array_equal(other, lift_inputs(known, hand, told(count, 0.3)))
    none = scene_knowledge(can_scene(), Candidates())
    assert lift_inputs(none, hand, told(0, 1.0)).shape == (0, LIFT_NUMBERS)


def test_inputs_of_a_scene_are_those_of_the_chosen_grasps():
    scene = can_scene()
    seen, some = scene_inputs(scene, np.array([3, 1]), None)
    seen_alone, other = scene_inputs(scene, np.array([1]), None)
    assert seen.shape == (2, SEEN)
    np.testing.assert_allclose(seen[1], seen_alone[0], atol=1e-4)
    assert some.shape == (2, LIFT_NUMBERS)
    stochastic = [3, 5, 6, 7, 8, 9]  # hints from disturbances, which are drawn for each set
    fixed = np.setdiff1d(np.arange(10, LIFT_NUMBERS), stochastic)
    np.testing.assert_allclose(some[1][fixed], other[0][fixed], atol=1e-9)


def test_inputs_tell_how_far_the_contacts_are_from_the_top_and_whether_they_oppose_the_thumb():
    known, hand = scene_knowledge(can_scene()), right_hand()
    count = len(known.candidates)
    inputs = lift_inputs(
        known, hand, Prediction(*np.full((3, count), 0.5), np.zeros((count, SEEN)))
    )
    facing, below_top, longest = inputs[:, 28], inputs[:, 31], inputs[:, 24]
    height = known.estimate.table.height
    size = np.linalg.norm(np.ptp(known.surface.vertices, axis=0))
    assert np.ptp(known.surface.vertices[:, 2]) * 0.95 < 0.05 * longest[0] < size
    thumb = np.array(["thumb" in name for name in hand.links])
    opposed = 0
    for k, closure in enumerate(known.hints.closures):
        if len(closure.p_WC) == 0:
            continue
        top = height(known.surface.vertices).max() - height(closure.p_WC).mean()
        np.testing.assert_allclose(below_top[k], top / 0.05, atol=1e-9)
        own = thumb[closure.links]
        if own.any() and not own.all():
            one, other = (closure.n_WC[at].mean(axis=0) for at in (own, ~own))
            np.testing.assert_allclose(facing[k], one @ other, atol=1e-9)
            opposed += facing[k] < -0.5
        else:
            assert facing[k] == 1.0
    assert opposed > 5
