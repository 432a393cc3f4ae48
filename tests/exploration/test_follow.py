import numpy as np
import pytest
from pydrake.common.eigen_geometry import AngleAxis
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix

from vh_drake.exploration.follow import FollowSettings, follow
from vh_drake.exploration.trajectory import approach_curves
from vh_drake.types import TouchPlan

SETTINGS = FollowSettings()


def plan_from(tip, target=(0.4, 0.1, 0.2), normal=(1.0, 0.0, 0.0)):
    target, normal = np.array([target]), np.array([normal])
    curve = approach_curves(np.asarray(tip, float), np.array([0.0, 0, 1.0]), target, normal)[0]
    return TouchPlan(target[0], normal[0], curve)


def run(plan, start, steps, dt=0.01, settings=SETTINGS):
    """Integrate the fingertip; the poses, places on the curve and missed flags of all steps."""
    R_0, pose, tau, log = start.rotation(), start, 0.0, []
    for _ in range(steps):
        step = follow(plan, R_0, pose, tau_from=tau, settings=settings)
        tau = step.tau
        log.append((pose, tau, step.missed, step.V_WT))
        angle = np.linalg.norm(step.V_WT[:3]) * dt
        turn = RotationMatrix()
        if angle > 1e-12:
            turn = RotationMatrix(AngleAxis(angle, step.V_WT[:3] * dt / angle))
        pose = RigidTransform(turn @ pose.rotation(), pose.translation() + dt * step.V_WT[3:])
    return log


def test_speed_is_constant_and_place_never_falls():
    tip = np.array([0.1, 0.0, 0.3])
    log = run(plan_from(tip), RigidTransform(p=tip), 500)
    speeds = [np.linalg.norm(V[3:]) for _, _, _, V in log]
    np.testing.assert_allclose(speeds, SETTINGS.speed_m_per_s)
    assert np.all(np.diff([tau for _, tau, _, _ in log]) >= 0)


def test_fingertip_passes_the_target_against_its_normal():
    tip = np.array([0.1, 0.0, 0.3])
    plan = plan_from(tip)
    start = RigidTransform(RotationMatrix(RollPitchYaw(np.pi, 0, 0)), tip)
    log = run(plan, start, 1000)
    near = min(log, key=lambda entry: np.linalg.norm(entry[0].translation() - plan.p_WT))
    assert np.linalg.norm(near[0].translation() - plan.p_WT) < 1e-3
    assert near[0].rotation().col(2) @ -plan.n_WT > np.cos(np.radians(5))


def test_errors_beside_the_curve_decay():
    tip = np.array([0.1, 0.0, 0.3])
    plan = plan_from(tip)
    log = run(plan, RigidTransform(p=tip + 0.02 * np.eye(3)[1]), 900)
    at_end = next(entry for entry in log if entry[1] >= 0.99)
    assert np.linalg.norm(at_end[0].translation() - plan.p_WT) < 3e-3


def test_touch_counts_as_missed_only_beyond_the_margin():
    tip = np.array([0.1, 0.0, 0.3])
    plan = plan_from(tip)
    log = run(plan, RigidTransform(p=tip), 1000)
    for pose, _, missed, _ in log:
        beyond = (plan.p_WT - pose.translation()) @ plan.n_WT
        if missed:
            assert beyond > 0.99 * SETTINGS.missed_after_m
    assert log[-1][2]
    assert not log[0][2]


def test_rate_of_turning_is_bounded():
    plan = plan_from((0.1, 0, 0.3))
    X_WT = RigidTransform(RotationMatrix(RollPitchYaw(2.5, 0.3, 1.0)), [0.1, 0, 0.3])
    step = follow(plan, RotationMatrix(), X_WT, tau_from=0.0, settings=SETTINGS)
    assert np.linalg.norm(step.V_WT[:3]) <= SETTINGS.most_turn_rad_per_s + 1e-12


def test_a_rigid_motion_of_everything_turns_the_command():
    X_MW = RigidTransform(RotationMatrix(RollPitchYaw(0.4, -1.0, 2.0)), [0.3, -0.5, 0.1])
    plan = plan_from((0.1, 0, 0.3))
    moved = TouchPlan(
        X_MW @ plan.p_WT, X_MW.rotation() @ plan.n_WT, (X_MW @ plan.control_points.T).T
    )
    pose = RigidTransform(RotationMatrix(RollPitchYaw(0.1, 0.2, 0.3)), [0.15, 0.02, 0.33])
    R_0 = RotationMatrix(RollPitchYaw(0.0, 0.2, 0.0))
    still = follow(plan, R_0, pose, tau_from=0.0, settings=SETTINGS)
    turned = follow(moved, X_MW.rotation() @ R_0, X_MW @ pose, tau_from=0.0, settings=SETTINGS)
    expected = np.concatenate([X_MW.rotation() @ still.V_WT[:3], X_MW.rotation() @ still.V_WT[3:]])
    np.testing.assert_allclose(turned.V_WT, expected, atol=1e-8)
    assert turned.tau == pytest.approx(still.tau, abs=1e-7)
