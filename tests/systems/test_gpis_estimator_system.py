import numpy as np
import pytest
import trimesh
from pydrake.common.value import Value
from pydrake.systems.analysis import Simulator

from vh_drake.errors import BadInput
from vh_drake.gpis.surface import SurfaceSettings, estimate_surface
from vh_drake.systems.gpis_estimator import GpisEstimator
from vh_drake.types import ContactSet, ObjectView, Plane

SETTINGS = SurfaceSettings(least_spacing_m=0.006)
CONTACTS = ContactSet(np.array([[0.74, -0.3, 0.94]]), np.array([[1.0, 0.0, 0.0]]))
NO_REQUEST, FIRST, SECOND = [0.0], [1.0], [2.0]


def view():
    """The upper half of a ball on the table."""
    ball = trimesh.creation.icosphere(subdivisions=3, radius=0.04)
    upper = ball.vertices[:, 2] > 0
    n = np.array(ball.vertex_normals)[upper]
    p = np.array(ball.vertices)[upper] + [0.7, -0.3, 0.94]
    return ObjectView(p, n, Plane(np.array([0, 0, 1.0]), 0.9), np.array([0.21, 0, 1.82]))


def fix(system, context, contacts, request, seen=None):
    system.GetInputPort("object_view").FixValue(context, Value[object](seen or view()))
    system.GetInputPort("contacts").FixValue(context, Value[object](contacts))
    system.GetInputPort("request").FixValue(context, request)


def outputs(system, context):
    return (
        system.GetOutputPort("surface").Eval(context),
        system.GetOutputPort("served").Eval(context)[0],
    )


@pytest.mark.parametrize("caching", [True, False])
def test_request_is_served_with_the_algorithms_surface(caching):
    system = GpisEstimator(SETTINGS)
    simulator = Simulator(system)
    context = simulator.get_mutable_context()
    if not caching:
        context.DisableCaching()
    fix(system, context, CONTACTS, FIRST)
    assert outputs(system, context)[1] == 0.0
    simulator.AdvanceTo(0.03)
    surface, served = outputs(system, context)
    expected = estimate_surface(view(), CONTACTS, SETTINGS)
    assert served == 1.0
    np.testing.assert_array_equal(surface.vertices, expected.vertices)
    np.testing.assert_array_equal(surface.variance, expected.variance)


def test_without_a_request_nothing_is_estimated():
    system = GpisEstimator(SETTINGS)
    simulator = Simulator(system)
    fix(system, simulator.get_mutable_context(), CONTACTS, NO_REQUEST)
    simulator.AdvanceTo(0.1)
    surface, served = outputs(system, simulator.get_context())
    assert served == 0.0
    assert len(surface.vertices) == 0


def test_served_estimate_stays_until_another_request():
    system = GpisEstimator(SETTINGS)
    simulator = Simulator(system)
    context = simulator.get_mutable_context()
    fix(system, context, ContactSet(), FIRST)
    simulator.AdvanceTo(0.03)
    first, _ = outputs(system, context)
    fix(system, context, CONTACTS, FIRST)
    simulator.AdvanceTo(0.06)
    assert outputs(system, context)[0] is first
    fix(system, context, CONTACTS, SECOND)
    simulator.AdvanceTo(0.09)
    second, served = outputs(system, context)
    assert served == 2.0
    assert second is not first


def test_two_contexts_of_one_estimator_are_independent():
    system = GpisEstimator(SETTINGS)
    busy, idle = Simulator(system), Simulator(system, system.CreateDefaultContext())
    fix(system, busy.get_mutable_context(), CONTACTS, FIRST)
    fix(system, idle.get_mutable_context(), CONTACTS, NO_REQUEST)
    busy.AdvanceTo(0.03)
    idle.AdvanceTo(0.03)
    assert len(outputs(system, busy.get_context())[0].faces) > 0
    assert len(outputs(system, idle.get_context())[0].faces) == 0


def test_contacts_that_are_not_finite_are_refused():
    system = GpisEstimator(SETTINGS)
    simulator = Simulator(system)
    bad = ContactSet(np.full((1, 3), np.nan), np.array([[1.0, 0, 0]]))
    fix(system, simulator.get_mutable_context(), bad, FIRST)
    with pytest.raises(BadInput, match="contacts hold NaN"):
        simulator.AdvanceTo(0.03)
