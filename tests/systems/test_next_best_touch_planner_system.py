import numpy as np
import pytest
import trimesh
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator

from vh_drake.errors import UnknownName
from vh_drake.exploration.next_touch import TouchSettings, plan_touch
from vh_drake.systems.next_best_touch_planner import NextBestTouchPlanner
from vh_drake.types import ContactSet, ObjectView, Plane, Surface

P_CAMERA = np.array([0.21, 0.0, 1.82])
TIP = RigidTransform([0.75, -0.2, 1.0])
VELOCITY = np.array([0.0, 0, 0, -0.03, 0, 0])
CONTACTS = ContactSet(np.array([[0.74, -0.3, 0.95]]), np.array([[1.0, 0, 0]]))


def ball():
    """Estimate of a ball on the table, and the half of it that the camera sees."""
    mesh = trimesh.creation.icosphere(subdivisions=4, radius=0.05)
    n = np.array(mesh.vertex_normals)
    p = np.array(mesh.vertices) + np.array([0.7, -0.3, 0.95])
    seen = np.einsum("ij,ij->i", n, P_CAMERA - p) > 0
    surface = Surface(p, np.array(mesh.faces, np.int64), n, np.zeros(len(p)))
    return surface, ObjectView(p[seen], n[seen], Plane(np.array([0, 0, 1.0]), 0.9), P_CAMERA)


def fix(system, context, request, surface=None):
    estimate, view = ball()
    values = {"surface": surface or estimate, "object_view": view, "contacts": CONTACTS}
    for name, value in values.items():
        system.GetInputPort(name).FixValue(context, Value[object](value))
    system.GetInputPort("fingertip_pose").FixValue(context, Value(TIP))
    system.GetInputPort("fingertip_velocity").FixValue(context, VELOCITY)
    system.GetInputPort("request").FixValue(context, [request])


def planned(system, request, *, caching=True, surface=None):
    simulator = Simulator(system, system.CreateDefaultContext())
    context = simulator.get_mutable_context()
    if not caching:
        context.DisableCaching()
    fix(system, context, request, surface)
    simulator.AdvanceTo(0.03)
    served = system.GetOutputPort("served").Eval(context)[0]
    return system.GetOutputPort("plans").Eval(context), served


@pytest.mark.parametrize("caching", [True, False])
def test_plans_are_those_of_the_algorithm(caching):
    plans, served = planned(NextBestTouchPlanner(), 3.0, caching=caching)
    expected = plan_touch(*ball(), CONTACTS, TIP, VELOCITY[3:])
    assert served == 3.0
    assert len(plans) == len(expected) > 0
    for plan, other in zip(plans, expected, strict=True):
        np.testing.assert_array_equal(plan.control_points, other.control_points)


def test_two_contexts_of_one_planner_are_independent():
    system = NextBestTouchPlanner()
    busy, idle = planned(system, 1.0), planned(system, 0.0)
    assert len(busy[0]) > 0
    assert idle == ((), 0.0)


def test_infeasible_plans_are_left_out():
    plans, _ = planned(NextBestTouchPlanner(feasible=lambda plan: plan.p_WT[2] > 0.95), 1.0)
    assert plans
    assert all(plan.p_WT[2] > 0.95 for plan in plans)


def test_nothing_estimated_gives_no_plan():
    assert planned(NextBestTouchPlanner(), 1.0, surface=Surface()) == ((), 1.0)


def test_unknown_strategy_is_refused():
    with pytest.raises(UnknownName, match="unknown strategy 'clever'"):
        planned(NextBestTouchPlanner(TouchSettings(strategy="clever")), 1.0)
