import re
from importlib.util import find_spec
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from pydrake.geometry import Role, SceneGraph
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, MultibodyPlant
from pydrake.systems.framework import DiagramBuilder

from vh_drake.errors import BadInput, UnknownName
from vh_drake.geometry.model_files import models_folder, models_package_map
from vh_drake.geometry.robot_model import add_armar6

ARM_JOINTS = ["t12", "t23", "t34", "t45", "t56", "t67", "t78", "t8"]
LEFT_ARM = [f"arm_{joint}_joint_r0" for joint in ARM_JOINTS]


def make_plant(**options) -> MultibodyPlant:
    plant = MultibodyPlant(0.0)
    add_armar6(plant, visuals=False, **options)
    plant.Finalize()
    return plant


def published_plant() -> MultibodyPlant:
    """Kinematics of the package's URDF: without meshes, its comma repaired."""
    folder = Path(find_spec("armar").origin).parent
    text = (folder / "description" / "urdf" / "armar6.urdf").read_text().replace(",", "")
    robot = ElementTree.fromstring(text)
    for link in robot.iterfind("link"):
        for child in list(link):
            link.remove(child)
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModelsFromString(ElementTree.tostring(robot, "unicode"), "urdf")
    plant.Finalize()
    return plant


def set_joints(plant, context, positions: dict[str, float]) -> None:
    for name, position in positions.items():
        joint = plant.GetJointByName(name)
        (joint.set_translation if "torso" in name else joint.set_angle)(context, position)


def moving_joint_names(plant: MultibodyPlant) -> list[str]:
    names = (plant.get_joint(i).name() for i in plant.GetJointIndices())
    return [name for name in names if plant.GetJointByName(name).num_positions() == 1]


def random_positions(plant: MultibodyPlant, seed: int) -> dict[str, float]:
    rng = np.random.default_rng(seed)
    names = moving_joint_names(plant)
    joints = [plant.GetJointByName(name) for name in names]
    lower = [joint.position_lower_limits()[0] for joint in joints]
    upper = [joint.position_upper_limits()[0] for joint in joints]
    return dict(zip(names, rng.uniform(lower, upper), strict=True))


def test_forward_kinematics_match_the_published_robot():
    pytest.importorskip("armar")
    ours, theirs = make_plant(), published_plant()
    context, their_context = ours.CreateDefaultContext(), theirs.CreateDefaultContext()
    instance = ours.GetModelInstanceByName("armar6")
    links = [ours.get_body(i).name() for i in ours.GetBodyIndices(instance)]
    assert len(links) == 25
    for seed in range(20):
        positions = random_positions(ours, seed)
        set_joints(ours, context, positions)
        set_joints(theirs, their_context, positions)
        for link in links:
            X = ours.EvalBodyPoseInWorld(context, ours.GetBodyByName(link))
            Y = theirs.EvalBodyPoseInWorld(their_context, theirs.GetBodyByName(link))
            np.testing.assert_allclose(X.GetAsMatrix4(), Y.GetAsMatrix4(), atol=1e-6)


def test_hand_frame_at_zero_is_where_the_robot_has_it():
    plant = make_plant()
    hand = plant.GetBodyByName("hand_fixed_r1")
    p_WH = plant.EvalBodyPoseInWorld(plant.CreateDefaultContext(), hand).translation()
    np.testing.assert_allclose(p_WH, [-0.077, -0.89853, 0.47414], atol=1e-5)


def test_mass_is_the_robots_without_its_hands():
    plant = make_plant()
    mass = plant.CalcTotalMass(plant.CreateDefaultContext())
    assert mass == pytest.approx(159.706 - 2 * 0.985765, abs=1e-3)


def test_every_link_inertia_is_physically_valid():
    plant = make_plant()
    for index in plant.GetBodyIndices(plant.GetModelInstanceByName("armar6")):
        body = plant.get_body(index)
        assert body.default_spatial_inertia().IsPhysicallyValid(), body.name()


def test_every_moving_joint_has_limits_damping_and_an_actuator():
    plant = make_plant()
    names = moving_joint_names(plant)
    assert len(names) == 17
    for name in names:
        joint = plant.GetJointByName(name)
        actuator = plant.GetJointActuatorByName(name.replace("_joint", "") + "_motor")
        assert actuator.joint().name() == name
        assert 0 < actuator.effort_limit() <= 1000
        assert np.isfinite(joint.position_upper_limits()).all()
        assert np.isfinite(joint.velocity_upper_limits()).all()
        assert joint.default_damping_vector()[0] == 0.5


def test_fixed_joints_keep_the_pose_and_lose_joint_and_actuator():
    free = make_plant()
    positions = random_positions(free, 3)
    fixed = make_plant(fixed_joints=positions)
    assert fixed.num_positions() == 0
    assert fixed.num_actuators() == 0
    context = free.CreateDefaultContext()
    set_joints(free, context, positions)
    for hand in ("hand_fixed_r1", "hand_fixed_r0"):
        X = free.EvalBodyPoseInWorld(context, free.GetBodyByName(hand))
        Y = fixed.EvalBodyPoseInWorld(fixed.CreateDefaultContext(), fixed.GetBodyByName(hand))
        np.testing.assert_allclose(X.GetAsMatrix4(), Y.GetAsMatrix4(), atol=1e-9)


def test_fixing_torso_and_left_arm_leaves_the_right_arm():
    plant = make_plant(fixed_joints={"torso_joint": -0.1} | dict.fromkeys(LEFT_ARM, 0.0))
    assert plant.num_positions() == plant.num_actuators() == 8


def test_fixing_an_unknown_joint_lists_the_choices():
    with pytest.raises(UnknownName, match=r"torso_jiont.*arm_t12_joint_r0.*torso_joint"):
        make_plant(fixed_joints={"torso_jiont": 0.0})


def test_fixing_a_joint_outside_its_limits_names_them():
    with pytest.raises(BadInput, match=re.escape("from -0.365 to 0")):
        make_plant(fixed_joints={"torso_joint": 0.2})


def scene(visuals: bool) -> tuple[SceneGraph, object]:
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.002)
    add_armar6(plant, visuals=visuals)
    plant.Finalize()
    return scene_graph, builder.Build()


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_robot_never_touches_itself(seed):
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.002)
    add_armar6(plant, visuals=False)
    plant.Finalize()
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    set_joints(plant, plant.GetMyContextFromRoot(context), random_positions(plant, seed))
    query = scene_graph.get_query_output_port().Eval(scene_graph.GetMyContextFromRoot(context))
    assert not query.HasCollisions()


def test_camera_place_in_the_head_lies_outside_the_head_shapes():
    scene_graph, diagram = scene(visuals=False)
    context = diagram.CreateDefaultContext()
    query = scene_graph.get_query_output_port().Eval(scene_graph.GetMyContextFromRoot(context))
    distances = query.ComputeSignedDistanceToPoint([0.21, 0.0, 1.8235], threshold=1.0)
    assert min(d.distance for d in distances) > 0.0


def test_every_moving_link_has_illustration_perception_and_proximity_shapes():
    scene_graph, _ = scene(visuals=False)
    inspector = scene_graph.model_inspector()
    for role in (Role.kIllustration, Role.kPerception, Role.kProximity):
        frames = [inspector.GetName(f) for f in inspector.GetAllFrameIds()]
        shown = {
            inspector.GetName(f)
            for f in inspector.GetAllFrameIds()
            if inspector.NumGeometriesForFrameWithRole(f, role) > 0
        }
        bare = {name for name in frames if name != "world"} - shown
        assert all("hand_fixed" in name for name in bare)


def test_package_map_resolves_our_models():
    path = models_package_map().GetPath("vh_drake_models")
    assert (Path(path) / "armar6" / "armar6.urdf").is_file()
    assert models_folder() == Path(path)
