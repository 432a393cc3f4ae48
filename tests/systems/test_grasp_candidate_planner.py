import numpy as np
import pytest
import trimesh
from pydrake.common.value import Value
from pydrake.systems.analysis import Simulator

from vh_drake.errors import BadInput
from vh_drake.geometry.model_files import models_folder
from vh_drake.grasping.planner_settings import PlannerSettings
from vh_drake.grasping.planners import plan_candidates
from vh_drake.hand.description import load_hand
from vh_drake.hand.model import read_hand_model
from vh_drake.systems.grasp_candidate_planner import GraspCandidatePlanner
from vh_drake.types import ObjectView, Plane, Surface

TABLE = Plane(np.array([0.0, 0, 1]), 0.9)
SETTINGS = PlannerSettings(candidates=20, draws=60)


@pytest.fixture(scope="module")
def hand():
    return read_hand_model(load_hand(models_folder() / "armar6_hand" / "armar6_hand.yaml"))


def brick():
    mesh = trimesh.creation.box([0.05, 0.08, 0.04]).subdivide()
    mesh.apply_translation([0.7, -0.3, 0.92])
    vertices = np.array(mesh.vertices)
    return Surface(vertices, np.array(mesh.faces, np.int64), vertices, np.zeros(len(vertices)))


def planned(system, request, *, caching=True, surface=None):
    simulator = Simulator(system, system.CreateDefaultContext())
    context = simulator.get_mutable_context()
    if not caching:
        context.DisableCaching()
    view = ObjectView(table=TABLE)
    system.GetInputPort("surface").FixValue(context, Value[object](surface or brick()))
    system.GetInputPort("object_view").FixValue(context, Value[object](view))
    system.GetInputPort("request").FixValue(context, [request])
    simulator.AdvanceTo(0.03)
    return [system.GetOutputPort(name).Eval(context) for name in ("candidates", "served")]


@pytest.mark.parametrize("caching", [True, False])
def test_candidates_are_those_of_the_algorithm(hand, caching):
    system = GraspCandidatePlanner(hand, SETTINGS, seed=3)
    candidates, served = planned(system, 5.0, caching=caching)
    expected = plan_candidates(brick(), TABLE, hand, SETTINGS, 3)
    assert served[0] == 5.0
    assert len(candidates) == 20
    np.testing.assert_array_equal(candidates.X_WH, expected.X_WH)


def test_two_contexts_of_one_planner_of_grasps_are_independent(hand):
    system = GraspCandidatePlanner(hand, SETTINGS)
    assert len(planned(system, 1.0)[0]) == 20
    assert len(planned(system, 0.0)[0]) == 0


def test_an_empty_surface_is_refused(hand):
    with pytest.raises(BadInput, match="surface is empty"):
        planned(GraspCandidatePlanner(hand, SETTINGS), 1.0, surface=Surface())
