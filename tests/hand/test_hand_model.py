import os

import numpy as np
import pytest
from pydrake.geometry import Box, Capsule, Cylinder, HalfSpace, Sphere
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from vh_drake.errors import BadInput, UnknownName
from vh_drake.geometry.model_files import models_folder
from vh_drake.hand.description import load_hand
from vh_drake.hand.model import read_hand_model
from vh_drake.hand.spheres import cover

GRIPPER = """<robot name="gripper">
  <link name="base"/>
  <link name="mount"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0"
    iyz="0"/></inertial><collision><geometry><box size="0.05 0.05 0.05"/></geometry></collision>
  </link>
  <joint name="weld" type="fixed"><parent link="base"/><child link="mount"/>
    <origin xyz="0 0 -0.1" rpy="0 0 0.5"/></joint>
  {fingers}
</robot>"""
FINGER = """<link name="{name}"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0"
    ixz="0" iyz="0"/></inertial><collision><origin xyz="0 0 0.03"/><geometry>
    <box size="0.01 0.01 0.06"/></geometry></collision></link>
  <joint name="{name}_slide" type="prismatic"><parent link="mount"/><child link="{name}"/>
    <origin xyz="{x} 0 0.13" rpy="0.1 0.2 0"/><axis xyz="{axis} 0 0"/>
    <limit lower="0" upper="0.04" effort="1" velocity="1"/></joint>"""
YAML = """name: gripper
model: gripper.urdf
base: base
fingers:
- {name: l, links: [left], joints: [left_slide], motor: m, p_pad: [0, 0, 0], n_pad: [1, 0, 0]}
- {name: r, links: [right], joints: [right_slide], motor: m, p_pad: [0, 0, 0], n_pad: [1, 0, 0]}
motors:
- {joint: m, closed_m: 0.04, force_n: 10}
tcps: {power: [0, 0, 0.05]}
approach: [0, 0, 1]
closing: [-1, 0, 0]
palm: [0, 0, 1]
along: [1, 0, 0]
"""


@pytest.fixture(scope="module")
def hand():
    return read_hand_model(load_hand(models_folder() / "armar6_hand" / "armar6_hand.yaml"))


@pytest.fixture
def gripper_file(tmp_path):
    fingers = FINGER.format(name="left", x=-0.04, axis=1) + FINGER.format(
        name="right", x=0.04, axis=-1
    )
    (tmp_path / "gripper.urdf").write_text(GRIPPER.format(fingers=fingers))
    (tmp_path / "gripper.yaml").write_text(YAML)
    return tmp_path / "gripper.yaml"


def assert_kinematics_are_drakes(hand, seed):
    plant = MultibodyPlant(0.001)
    Parser(plant).AddModels(hand.description.model)
    plant.Finalize()
    context = plant.CreateDefaultContext()
    angles = np.random.default_rng(seed).uniform(hand.lower, hand.upper)
    for name, angle in zip(hand.joints, angles, strict=True):
        joint = plant.GetJointByName(name)
        plant.SetPositions(
            context,
            np.where(
                np.arange(plant.num_positions()) == joint.position_start(),
                angle,
                plant.GetPositions(context),
            ),
        )
    X_WH = plant.GetBodyByName(hand.links[0]).EvalPoseInWorld(context)
    for name, X_HL in zip(hand.links, hand.link_poses(angles), strict=True):
        expected = X_WH.InvertAndCompose(plant.GetBodyByName(name).EvalPoseInWorld(context))
        np.testing.assert_allclose(X_HL, expected.GetAsMatrix4(), atol=1e-9)


def test_forward_kinematics_are_those_of_drake(hand):
    assert_kinematics_are_drakes(hand, 0)


def test_a_two_finger_gripper_of_slides_is_read_too(gripper_file):
    gripper = read_hand_model(load_hand(gripper_file))
    assert_kinematics_are_drakes(gripper, 1)
    assert gripper.opposing.sum() == 1
    np.testing.assert_allclose(gripper.joint_angles(np.array([0.5])), [0.02, 0.02])
    assert gripper.arrays.first_sphere[1] > 0  # The welded mount belongs to the base.


def test_the_thumb_of_armar6_opposes_its_fingers(hand):
    np.testing.assert_array_equal(hand.opposing, [0, 0, 0, 0, 1])
    np.testing.assert_array_equal(hand.motor_fractions(0.5, 0.2), [0.5, 0.2])


def test_springs_are_those_of_table_4_4(hand):
    np.testing.assert_allclose(np.deg2rad(hand.stiffness[:3]) * 1e3, [0.67, 0.82, 0.82], rtol=1e-4)
    np.testing.assert_allclose(np.rad2deg(hand.preload[:3]), [30, 30, 35], rtol=1e-4)


def test_open_and_closed_motors_bring_the_joints_to_their_stops(hand):
    np.testing.assert_allclose(hand.joint_angles(np.zeros(2)), hand.lower)
    np.testing.assert_allclose(hand.joint_angles(np.ones(2)), hand.upper)


def test_no_sphere_moves_farther_than_its_lever_allows(hand):
    rng = np.random.default_rng(2)
    for _ in range(20):
        angles = rng.uniform(hand.lower, hand.upper)
        for joint in range(len(angles)):
            moved = angles + 1e-5 * (np.arange(len(angles)) == joint)
            way = np.linalg.norm(hand.spheres(moved)[0] - hand.spheres(angles)[0], axis=1)
            assert (way <= hand.arrays.sphere_lever[:, joint] * 1e-5 + 1e-12).all()


def inside(shape, p):
    if isinstance(shape, Box):
        return (np.abs(p) <= np.asarray(shape.size()) / 2 + 1e-9).all()
    if isinstance(shape, Sphere):
        return np.linalg.norm(p) <= shape.radius() + 1e-9
    half = shape.length() / 2
    if isinstance(shape, Cylinder):
        return np.hypot(p[0], p[1]) <= shape.radius() + 1e-9 and abs(p[2]) <= half + 1e-9
    axis = np.array([0, 0, np.clip(p[2], -half, half)])
    return np.linalg.norm(p - axis) <= shape.radius() + 1e-9


@pytest.mark.parametrize(
    "shape", [Box(0.05, 0.09, 0.07), Capsule(0.0086, 0.031), Cylinder(0.045, 0.016), Sphere(0.02)]
)
def test_spheres_stay_inside_their_shape_and_reach_its_ends(shape):
    centers, radii = cover(shape)
    directions = np.random.default_rng(3).normal(size=(50, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    for center, radius in zip(centers, radii, strict=True):
        assert all(inside(shape, center + radius * d) for d in directions)
    top = (centers[:, 2] + radii).max()
    assert not inside(shape, np.array([0, 0, top + 1e-6]))
    assert inside(shape, np.array([0, 0, top]))


def test_a_half_space_can_not_be_part_of_a_hand():
    with pytest.raises(BadInput, match="HalfSpace"):
        cover(HalfSpace())


def test_an_unknown_link_is_named_with_the_choices(gripper_file):
    gripper_file.write_text(YAML.replace("[left]", "[lefty]"))
    with pytest.raises(UnknownName, match=r"lefty.*left"):
        read_hand_model(load_hand(gripper_file))


def test_a_broken_model_file_is_refused(gripper_file):
    (gripper_file.parent / "gripper.urdf").write_text("<robot name='x'><link")
    with pytest.raises(BadInput, match="can't read the hand model"):
        read_hand_model(load_hand(gripper_file))


def test_a_hand_is_read_once_until_its_description_or_its_model_changes(gripper_file):
    first = read_hand_model(load_hand(gripper_file))
    assert read_hand_model(load_hand(gripper_file)) is first
    gripper_file.write_text(YAML.replace("name: gripper", "name: other"))
    assert read_hand_model(load_hand(gripper_file)).description.name == "other"
    gripper_file.write_text(YAML)
    model = gripper_file.parent / "gripper.urdf"
    model.write_text(model.read_text().replace("0.04", "0.05"))
    os.utime(model, ns=(0, 1))
    assert not np.array_equal(read_hand_model(load_hand(gripper_file)).upper, first.upper)
