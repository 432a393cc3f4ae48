import functools

import numpy as np
import pytest
import trimesh
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from pydrake.systems.analysis import Simulator

from vh_drake.experiments.judge import (
    Judge,
    TrueTouch,
    nearest_surface_point,
    surface_error_mm,
    touch_report,
)
from vh_drake.geometry.meshes import from_trimesh
from vh_drake.grasping.story import TouchRecord
from vh_drake.objects.model import make_object
from vh_drake.scenes.placing import place_object
from vh_drake.scenes.scenario import Scenario
from vh_drake.scenes.station import make_station
from vh_drake.types import Surface, TouchPlan

SIZE = np.array([0.06, 0.08, 0.16])
BOX = from_trimesh(trimesh.creation.box(SIZE))
BALL_RADIUS = 0.05
FINE_BALL = from_trimesh(trimesh.creation.icosphere(4, BALL_RADIUS))
X_WO = RigidTransform(RollPitchYaw(0.3, -0.7, 1.9), [0.7, -0.3, 1.0])


def nearest_on_box(p):
    """Closed form: clamped from outside, pushed through the nearest face from inside."""
    half = SIZE / 2
    if (np.abs(p) > half).any():
        return np.clip(p, -half, half)
    axis = int((half - np.abs(p)).argmin())
    pushed = p.copy()
    pushed[axis] = np.copysign(half[axis], p[axis])
    return pushed


@pytest.mark.parametrize("seed", range(20))
def test_the_nearest_point_of_a_box_is_the_closed_form(seed):
    p = np.random.default_rng(seed).uniform(-0.12, 0.12, 3)
    found, _ = nearest_surface_point(BOX, p)
    np.testing.assert_allclose(found, nearest_on_box(p), atol=1e-12)


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("sign", [-1.0, 1.0])
@pytest.mark.parametrize("depth", [-0.01, 0.01])
def test_a_point_over_or_under_a_face_gets_the_face_s_outward_normal(axis, sign, depth):
    outward = sign * np.eye(3)[axis]
    along = 0.2 * SIZE / 2 * (1.0 - np.abs(outward))
    on_face = along + outward * SIZE / 2
    found, normal = nearest_surface_point(BOX, on_face - depth * outward)
    np.testing.assert_allclose(found, on_face, atol=1e-12)
    np.testing.assert_allclose(normal, outward, atol=1e-12)


def as_surface(mesh):
    normals = np.zeros_like(mesh.vertices)
    return Surface(mesh.vertices, mesh.faces, normals, np.zeros(len(mesh.vertices)))


def test_the_truth_itself_has_no_surface_error():
    truth = BOX.transformed(X_WO.GetAsMatrix4())
    assert surface_error_mm(as_surface(truth), BOX, X_WO) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("offset_m", [-0.01, 0.002, 0.01])
def test_a_ball_too_large_or_small_by_d_has_an_error_of_d(offset_m):
    scale = 1.0 + offset_m / BALL_RADIUS
    estimate = FINE_BALL.scaled(scale).transformed(X_WO.GetAsMatrix4())
    error = surface_error_mm(as_surface(estimate), FINE_BALL, X_WO)
    assert error == pytest.approx(1000.0 * abs(offset_m), rel=0.02)


def test_half_a_truth_is_an_error_although_all_of_it_is_right():
    """The estimate's points lie on the truth; the truth's points miss the estimate."""
    half = FINE_BALL.with_faces(FINE_BALL.triangles[:, :, 2].mean(axis=1) > 0)
    assert surface_error_mm(as_surface(half), FINE_BALL, RigidTransform()) > 5.0


P_CAMERA = np.array([0.0, 0.0, 2.0])
STANDING = RigidTransform([0.7, -0.3, 1.0])
FRONT_OC = np.array([-SIZE[0] / 2, 0.01, 0.02])  # on the face towards the camera
BACK_OC = -FRONT_OC


def report(p_OC, *, felt=True, X_WO=STANDING):
    """A touch that was planned 3 mm beside and felt 4 mm beside, and 30 and 10 degrees off."""
    n_W = X_WO.rotation() @ np.array([np.sign(p_OC[0]), 0.0, 0.0])
    p_W, up, across = X_WO @ p_OC, X_WO.rotation() @ [0, 0, 1.0], X_WO.rotation() @ [0, 1.0, 0]
    plan = TouchPlan(p_W + 0.003 * across, turned(n_W, up, 30.0), np.zeros((4, 3)), rating=0.25)
    sensation = {"p_WC": p_W + 0.004 * n_W, "n_WC": turned(n_W, up, 10.0)} if felt else {}
    record = TouchRecord(plan, felt, 1.23456, **sensation)
    return touch_report(record, TrueTouch(p_W, p_OC, X_WO), BOX, P_CAMERA, 1.5)


def turned(n, up, degrees):
    angle = np.deg2rad(degrees)
    return np.cos(angle) * n + np.sin(angle) * np.cross(up, n)


@pytest.mark.parametrize("pose", [STANDING, X_WO])
def test_a_report_has_errors_in_millimetres_and_degrees_in_any_pose(pose):
    numbers = report(FRONT_OC, X_WO=pose)
    assert numbers["prediction_error_mm"] == pytest.approx(3.0, abs=1e-3)
    assert numbers["prediction_normal_error_deg"] == pytest.approx(30.0, abs=0.01)
    assert numbers["felt_error_mm"] == pytest.approx(4.0, abs=1e-3)
    assert numbers["felt_normal_error_deg"] == pytest.approx(10.0, abs=0.01)
    assert numbers["object_displacement_mm"] == 1.5
    assert numbers["rating"] == 0.25
    assert numbers["time_s"] == 1.235
    np.testing.assert_allclose(numbers["actual_position_m"], pose @ FRONT_OC, atol=1e-5)
    normal = pose.rotation() @ [-1.0, 0.0, 0.0]
    np.testing.assert_allclose(numbers["actual_normal"], normal, atol=1e-5)


def test_only_the_far_side_faces_away_from_the_camera():
    for p_OC, normal, away in ((FRONT_OC, -1.0, False), (BACK_OC, 1.0, True)):
        numbers = report(p_OC)
        to_camera = P_CAMERA - STANDING @ p_OC
        cosine = normal * to_camera[0] / np.linalg.norm(to_camera)
        assert numbers["cosine_to_camera"] == pytest.approx(cosine, abs=1e-4)
        assert numbers["faces_away_from_camera"] is away


def test_a_place_inside_the_skin_is_reported_on_the_true_surface():
    """Contact lies within the overlap of two bodies; what counts is the object's surface."""
    pressed = TrueTouch(STANDING @ (0.95 * FRONT_OC), 0.95 * FRONT_OC, STANDING)
    plan = TouchPlan(STANDING @ FRONT_OC, np.array([-1.0, 0.0, 0.0]), np.zeros((4, 3)))
    numbers = touch_report(TouchRecord(plan, False, 1.0), pressed, BOX, P_CAMERA, 0.0)
    assert numbers["actual_position_m"][0] == pytest.approx(0.7 - SIZE[0] / 2, abs=1e-5)
    assert numbers["actual_normal"] == [-1.0, 0.0, 0.0]


def test_a_touch_that_felt_nothing_has_no_sensation_to_compare():
    numbers = report(FRONT_OC, felt=False)
    assert not numbers["felt"]
    assert not [name for name in numbers if name.startswith("felt_")]
    assert "prediction_error_mm" in numbers


def test_without_truth_there_is_a_prediction_and_a_sensation_but_no_error():
    plan = TouchPlan(np.zeros(3), np.array([1.0, 0.0, 0.0]), np.zeros((4, 3)))
    record = TouchRecord(plan, True, 1.0, np.ones(3), np.array([0.0, 1.0, 0.0]))
    numbers = touch_report(record, None, BOX, P_CAMERA, 0.0)
    assert numbers["felt_position_m"] == [1.0, 1.0, 1.0]
    assert not [name for name in numbers if "error" in name or "actual" in name]
    assert "faces_away_from_camera" not in numbers


MODEL = make_object("box", BOX, 0.3)
SCENARIO = Scenario(contact="point", time_step_s=0.002)
TIP_P = np.array([-0.0005, 0.0, 0.029])  # end of the axis of the fingertip's capsule [m]
TIP_RADIUS = 0.0086  # [m]
TABLE_POSE = RigidTransform([0.7, -0.3, SCENARIO.table.height_m + SIZE[2] / 2 + 0.0005])


@functools.cache
def station():
    return make_station(SCENARIO, MODEL)


class Rig:
    """A station that does nothing, and its judge."""

    def __init__(self, X_WO):
        self.plant = station().world.plant
        self.simulator = Simulator(station())
        self.context = self.simulator.get_mutable_context()
        station().GetInputPort("spatial_velocity").FixValue(self.context, np.zeros(6))
        station().GetInputPort("motor_command").FixValue(self.context, np.zeros(2))
        self.place(X_WO)
        self.judge = Judge(station(), MODEL, self.context)

    def place(self, X_WO):
        place_object(station(), self.context, X_WO)

    def pose_of(self, body):
        plant = self.plant
        found = plant.GetBodyByName(body, station().world.hand)
        return plant.EvalBodyPoseInWorld(plant.GetMyContextFromRoot(self.context), found)

    def advance(self, duration_s):
        self.simulator.AdvanceTo(self.context.get_time() + duration_s)


@pytest.mark.parametrize("pose", [TABLE_POSE, X_WO])
def test_the_judge_reads_the_placed_pose_and_its_lowest_point(pose):
    judge = Rig(pose).judge
    assert judge.object_pose().IsNearlyEqualTo(pose, 1e-9)
    corners = pose @ (np.array(np.meshgrid(*[[-0.5, 0.5]] * 3)).reshape(3, 8) * SIZE[:, None])
    assert judge.lowest_point() == pytest.approx(corners[2].min(), abs=1e-9)


def test_the_object_in_hand_is_its_pose_as_seen_from_the_palm():
    rig = Rig(X_WO)
    seen = rig.judge.object_in_hand()
    assert (rig.pose_of("hand_palm") @ seen).IsNearlyEqualTo(X_WO, 1e-9)


def test_an_object_that_stands_on_the_table_apart_from_the_hand_is_not_touched():
    rig = Rig(TABLE_POSE)
    rig.advance(0.01)
    assert rig.judge.touch() is None


def test_an_object_at_the_pad_of_the_open_hand_is_touched_there():
    rig = Rig(TABLE_POSE)
    X_WT = rig.pose_of("middle_distal")
    ahead = X_WT.rotation() @ [0.0, 0.0, 1.0]
    R_WO = RotationMatrix.MakeFromOneVector(-ahead, 0)  # the face +x looks at the fingertip
    p_WTip = X_WT @ TIP_P + TIP_RADIUS * ahead
    placed = RigidTransform(R_WO, p_WTip + (SIZE[0] / 2 - 0.001) * ahead)
    rig.place(placed)
    rig.advance(SCENARIO.time_step_s)
    touch = rig.judge.touch()
    assert touch is not None
    assert touch.X_WO.IsNearlyEqualTo(placed, 0.01)
    np.testing.assert_allclose(touch.X_WO @ touch.p_OC, touch.p_WC, atol=1e-12)
    assert np.linalg.norm(touch.p_WC - p_WTip) < 0.003
    _, n_OS = nearest_surface_point(BOX, touch.p_OC)
    np.testing.assert_allclose(n_OS, [1.0, 0.0, 0.0], atol=1e-9)
