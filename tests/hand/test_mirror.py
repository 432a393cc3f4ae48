import numpy as np
import pytest
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from vh_drake.errors import BadInput
from vh_drake.geometry.model_files import models_folder
from vh_drake.hand.mirror import mirrored_sdf

RIGHT = (models_folder() / "armar6_hand" / "armar6_hand.sdf").read_text()
M = np.diag([1.0, -1.0, 1.0])
SKEW = """<sdf version="1.9"><model name="m">
  <link name="base"/>
  <link name="arm"><pose rotation_format="quat_xyzw">0.1 0.2 0.3 0.1 0.5 -0.3 0.8062258</pose>
    <inertial><pose>0.01 0.02 0.03 0.3 0.2 0.1</pose><mass>2</mass><inertia><ixx>0.03</ixx>
    <iyy>0.04</iyy><izz>0.05</izz><ixy>0.004</ixy><ixz>0.003</ixz><iyz>-0.002</iyz></inertia>
    </inertial></link>
  <joint name="turn" type="revolute"><pose>0 0.05 0 0.1 0 0.2</pose><parent>base</parent>
    <child>arm</child><axis><xyz>0.3 -0.5 0.8</xyz></axis></joint>
  <link name="rod"><pose>0.2 -0.1 0 0 0.4 0.9</pose></link>
  <joint name="slide" type="prismatic"><parent>arm</parent><child>rod</child>
    <axis><xyz>0.2 0.9 -0.4</xyz></axis></joint>
</model></sdf>"""


def plant_of(sdf):
    plant = MultibodyPlant(0.001)
    (instance,) = Parser(plant).AddModelsFromString(sdf, "sdf")
    base = plant.get_body(plant.GetBodyIndices(instance)[0])
    plant.WeldFrames(plant.world_frame(), base.body_frame())
    plant.Finalize()
    return plant, [plant.get_body(i) for i in plant.GetBodyIndices(instance)]


def assert_mirror_images(sdf):
    """Kinematics and inertia at random joint positions are reflected."""
    (right, right_bodies), (left, left_bodies) = plant_of(sdf), plant_of(mirrored_sdf(sdf))
    assert [body.name() for body in right_bodies] == [body.name() for body in left_bodies]
    here, there = right.CreateDefaultContext(), left.CreateDefaultContext()
    rng = np.random.default_rng(0)
    for _ in range(5):
        q = rng.uniform(0, 1.5, right.num_positions())
        right.SetPositions(here, q)
        left.SetPositions(there, q)
        for ours, other in zip(right_bodies, left_bodies, strict=True):
            X, Y = ours.EvalPoseInWorld(here), other.EvalPoseInWorld(there)
            np.testing.assert_allclose(Y.translation(), M @ X.translation(), atol=1e-9)
            R = X.rotation().matrix()
            np.testing.assert_allclose(Y.rotation().matrix(), M @ R @ M, atol=1e-9)
            right_I, left_I = (body.default_spatial_inertia() for body in (ours, other))
            np.testing.assert_allclose(left_I.get_com(), M @ right_I.get_com(), atol=1e-12)
            np.testing.assert_allclose(
                left_I.CalcRotationalInertia().CopyToFullMatrix3(),
                M @ right_I.CalcRotationalInertia().CopyToFullMatrix3() @ M,
                atol=1e-12,
            )


def test_the_left_hand_moves_as_the_right_one_s_mirror_image():
    assert_mirror_images(RIGHT)


def test_skew_joints_slides_quaternions_and_inertias_are_mirrored():
    assert_mirror_images(SKEW)


def test_a_hand_mirrored_twice_is_itself():
    twice, once = plant_of(mirrored_sdf(mirrored_sdf(RIGHT)))[0], plant_of(RIGHT)[0]
    contexts = [plant.CreateDefaultContext() for plant in (once, twice)]
    q = np.linspace(0.1, 1.0, once.num_positions())
    poses = []
    for plant, context in zip((once, twice), contexts, strict=True):
        plant.SetPositions(context, q)
        poses.append(plant.GetBodyByName("thumb_distal").EvalPoseInWorld(context))
    assert poses[0].IsNearlyEqualTo(poses[1], 1e-12)


def test_motors_tendons_and_shapes_survive():
    right, left = plant_of(RIGHT)[0], plant_of(mirrored_sdf(RIGHT))[0]
    assert left.num_actuators() == right.num_actuators() == 2
    assert left.num_constraints() == right.num_constraints() == 2
    assert mirrored_sdf(RIGHT).count("drake:compliant_hydroelastic") == RIGHT.count(
        "drake:compliant_hydroelastic"
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<sdf", "no XML"),
        ("<robot name='r'/>", "<robot>"),
        ("<sdf><visual><geometry><mesh/></geometry></visual></sdf>", "<mesh>"),
        ("<sdf><link><pose>1 2 3</pose></link></sdf>", "'1 2 3', not 6 or 7 numbers"),
        ("<sdf><link><pose>a b c d e f</pose></link></sdf>", "not 6 or 7 numbers"),
        (
            "<sdf><joint name='j' type='screw'><axis><xyz>1 0 0</xyz></axis></joint></sdf>",
            "screw joint",
        ),
    ],
)
def test_what_cannot_be_mirrored_is_named(text, message):
    with pytest.raises(BadInput, match=message):
        mirrored_sdf(text)
