import numpy as np
from pydrake.common.value import Value
from pydrake.systems.analysis import Simulator

from vh_drake.hand.description import load_hand
from vh_drake.hand.model import read_hand_model
from vh_drake.scenes.planning import make_planning
from vh_drake.scenes.plant import default_hand
from vh_drake.sensing.segmentation import SegmentationSettings
from vh_drake.types import Candidates, ContactSet, ObjectView, Plane

OUTPUTS = {"surface", "candidates", "scores", "ranking"}


def ports(diagram):
    """Names of the inputs and of the outputs."""
    inputs = {diagram.get_input_port(i).get_name() for i in range(diagram.num_input_ports())}
    outputs = {diagram.get_output_port(i).get_name() for i in range(diagram.num_output_ports())}
    return inputs, outputs


def ball(radius):
    """The upper part of a ball on a table at z = 0."""
    n = np.random.default_rng(0).normal(size=(800, 3))
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    n = n[n[:, 2] > 0.0]
    centre = np.array([0.0, 0.0, radius])
    return ObjectView(radius * n + centre, n, Plane(), np.array([0.0, 0.0, 1.0]))


def test_ports_depend_on_whether_the_object_must_be_cut_out():
    hand = read_hand_model(load_hand(default_hand()))
    assert ports(make_planning(hand, 0, None)) == ({"object_view", "contacts"}, OUTPUTS)
    assert ports(make_planning(hand, 0, SegmentationSettings())) == (
        {"cloud", "contacts"},
        OUTPUTS | {"object_view", "status"},
    )


def test_two_contexts_answer_for_their_own_views():
    diagram = make_planning(read_hand_model(load_hand(default_hand())), 0, None)
    heights = []
    for radius in (0.025, 0.035):
        context = diagram.CreateDefaultContext()
        diagram.GetInputPort("object_view").FixValue(context, Value[object](ball(radius)))
        diagram.GetInputPort("contacts").FixValue(context, Value[object](ContactSet()))
        Simulator(diagram, context).AdvanceTo(0.06)
        heights.append(np.ptp(diagram.GetOutputPort("surface").Eval(context).vertices[:, 2]))
        candidates: Candidates = diagram.GetOutputPort("candidates").Eval(context)
        ranking = diagram.GetOutputPort("ranking").Eval(context)
        assert len(candidates) == len(ranking) > 0
    np.testing.assert_allclose(heights, [0.05, 0.07], atol=0.004)
