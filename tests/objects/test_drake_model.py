import numpy as np
import pytest
from pydrake.geometry import (
    AddCompliantHydroelasticProperties,
    AddContactMaterial,
    Box,
    ProximityProperties,
    Role,
    Sphere,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import (
    AddMultibodyPlantSceneGraph,
    ContactModel,
    CoulombFriction,
)
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from vh_drake.errors import UnknownName
from vh_drake.geometry.meshes import TriMesh
from vh_drake.geometry.remesh import simplify
from vh_drake.geometry.stable_poses import draw_pose
from vh_drake.objects.drake_model import (
    VISUAL_TRIANGLES,
    add_object,
    contact_shapes,
    obj_text,
    spatial_inertia,
)
from vh_drake.objects.library import library_object


def soft_properties():
    properties = ProximityProperties()
    AddCompliantHydroelasticProperties(0.01, 1e7, properties)
    AddContactMaterial(dissipation=5.0, friction=CoulombFriction(0.5, 0.5), properties=properties)
    return properties


def build(model, contact, shape, p_WS):
    """A diagram of the object and one soft shape of the world."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.002)
    plant.set_contact_model(ContactModel.kHydroelasticWithFallback)
    plant.SetUseSampledOutputPorts(False)
    plant.RegisterCollisionGeometry(
        plant.world_body(), RigidTransform(p_WS), shape, "world", soft_properties()
    )
    body = add_object(plant, model, contact=contact)
    plant.Finalize()
    return builder.Build(), plant, scene_graph, body


def pairs_in_contact(model, contact, p_WS, radius=0.01):
    """How many contacts a soft ball has with the object at the world's origin."""
    diagram, plant, _, body = build(model, contact, Sphere(radius), p_WS)
    root = diagram.CreateDefaultContext()
    context = plant.GetMyContextFromRoot(root)
    plant.SetFreeBodyPose(context, body, RigidTransform())
    results = plant.get_contact_results_output_port().Eval(context)
    return results.num_hydroelastic_contacts() + results.num_point_pair_contacts()


@pytest.mark.parametrize("contact", ["hydroelastic", "point"])
def test_the_inside_of_a_mug_is_free_and_its_wall_is_not(contact):
    mug = library_object("mug")
    assert pairs_in_contact(mug, contact, [0.0, 0.0, 0.05]) == 0
    assert pairs_in_contact(mug, contact, [0.0, 0.032, 0.05]) > 0
    assert pairs_in_contact(mug, contact, [0.0, 0.048, 0.05]) > 0


def test_the_body_carries_the_mass_properties_of_the_object():
    model = library_object("power_drill")
    inertia = spatial_inertia(model)
    assert inertia.get_mass() == pytest.approx(model.mass_kg)
    np.testing.assert_allclose(inertia.get_com(), model.com)
    about_com = inertia.Shift(model.com).CalcRotationalInertia().CopyToFullMatrix3()
    np.testing.assert_allclose(about_com, model.inertia, atol=1e-12)


@pytest.mark.parametrize("contact", ["hydroelastic", "point"])
@pytest.mark.parametrize("name", ["can", "cereal_box", "power_drill"])
def test_an_object_in_a_resting_pose_stays_there(name, contact):
    model = library_object(name)
    table = Box(1.0, 1.0, 0.1)
    diagram, plant, _, body = build(model, contact, table, [0.0, 0.0, -0.05])
    simulator = Simulator(diagram)
    context = plant.GetMyContextFromRoot(simulator.get_mutable_context())
    X_WO = draw_pose(model.mesh, seed=0)
    plant.SetFreeBodyPose(context, body, RigidTransform(X_WO))
    simulator.AdvanceTo(0.2)
    X_after = plant.EvalBodyPoseInWorld(context, body).GetAsMatrix4()
    assert np.abs(X_after - X_WO).max() < 0.02
    assert abs(model.mesh.transformed(X_after).bounds[0, 2]) < 0.002


def test_cameras_and_meshcat_see_one_light_mesh_and_contact_has_its_own():
    model = library_object("mug")
    _, plant, scene_graph, body = build(model, "hydroelastic", Sphere(0.1), [0, 0, -1])
    inspector = scene_graph.model_inspector()
    frame = plant.GetBodyFrameIdOrThrow(body.index())
    for role in (Role.kPerception, Role.kIllustration, Role.kProximity):
        assert inspector.NumGeometriesForFrameWithRole(frame, role) == 1
    assert len(obj_text(simplify(model.mesh, VISUAL_TRIANGLES))) < 200_000


def test_library_shapes_use_exact_primitives():
    (shape, X_OS), *_ = contact_shapes(library_object("sugar_box"), "hydroelastic")
    np.testing.assert_allclose(shape.size(), [0.092, 0.045, 0.176])
    np.testing.assert_allclose(X_OS.translation(), [0, 0, 0.088])


def test_obj_text_lists_vertices_and_faces_from_one():
    text = obj_text(TriMesh(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.5]]), np.array([[0, 1, 2]])))
    assert text.splitlines()[2:] == [
        "v 0.00000 1.00000 0.50000",
        "vn 0.0000 -0.4472 0.8944",
        "f 1//1 2//1 3//1",
    ]


def test_an_unknown_contact_model_lists_the_choices():
    with pytest.raises(UnknownName, match="hydroelastic, point"):
        build(library_object("can"), "soft", Sphere(0.01), [1.0, 0.0, 0.0])
