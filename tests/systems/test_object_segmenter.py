import numpy as np
from pydrake.common.value import Value

from vh_drake.sensing.segmentation import segment
from vh_drake.systems.object_segmenter import ObjectSegmenter
from vh_drake.types import Cloud


def box_on_table() -> Cloud:
    rng = np.random.default_rng(0)
    plane = rng.uniform([0.5, -0.6, 0.9], [1.0, 0.0, 0.9], (20_000, 3))
    top = rng.uniform([0.65, -0.35, 0.95], [0.75, -0.25, 0.95], (3000, 3))
    side = rng.uniform([0.65, -0.35, 0.9], [0.65, -0.25, 0.95], (1500, 3))
    p_W = np.vstack([plane, top, side]) + rng.normal(0.0, 0.001, (24_500, 3))
    return Cloud(p_W, np.array([0.2, 0.0, 1.8]))


def context_with(system: ObjectSegmenter, cloud: Cloud):
    context = system.CreateDefaultContext()
    system.GetInputPort("cloud").FixValue(context, Value[object](cloud))
    return context


def outputs(system, context):
    return (
        system.GetOutputPort("object_view").Eval(context),
        system.GetOutputPort("status").Eval(context),
    )


def test_the_view_is_the_algorithm_s_with_and_without_caching():
    system, cloud = ObjectSegmenter(), box_on_table()
    expected = segment(cloud)
    for caching in (True, False):
        context = context_with(system, cloud)
        if not caching:
            context.DisableCaching()
        view, status = outputs(system, context)
        assert status == "ok"
        np.testing.assert_array_equal(view.p_WO, expected.p_WO)
        np.testing.assert_array_equal(view.n_WO, expected.n_WO)


def test_an_empty_cloud_gives_an_empty_view_and_says_why():
    system = ObjectSegmenter()
    view, status = outputs(system, context_with(system, Cloud()))
    assert view.p_WO.shape == (0, 3)
    assert "0 of 0 points" in status


def test_two_contexts_are_independent_and_a_new_cloud_is_seen():
    system = ObjectSegmenter()
    good, bad = context_with(system, box_on_table()), context_with(system, Cloud())
    assert outputs(system, bad)[1] != "ok"
    assert outputs(system, good)[1] == "ok"
    system.GetInputPort("cloud").FixValue(bad, Value[object](box_on_table()))
    assert outputs(system, bad)[1] == "ok"
