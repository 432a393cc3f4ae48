"""The hand alone, its carriage and one object."""

import pytest
from scenery import right_hand

from vh_drake.geometry.stable_poses import draw_pose
from vh_drake.grasping.closure_rate import PerturbationSettings
from vh_drake.grasping.planner_settings import PlannerSettings
from vh_drake.grasping.planners import plan_candidates
from vh_drake.grasping.scoring import ScoringSettings, score_candidates
from vh_drake.objects.library import library_object
from vh_drake.scenes.hand_lift import HandLifter, lift_motion
from vh_drake.scenes.scenario import Table
from vh_drake.types import Plane, Surface

HAND, MODEL = right_hand(), library_object("fruit_drink")
TABLE = Table(height_m=0.4, center=[0.2, 0.1])
FEW = PerturbationSettings(min_samples=12, max_samples=12)


@pytest.fixture(scope="module")
def lifter():
    return HandLifter(HAND, MODEL, TABLE)


@pytest.fixture(scope="module")
def grasp():
    """The object's pose, and the best rated grasp of its true shape."""
    X_WO = draw_pose(MODEL.mesh, seed=1)
    X_WO[:3, 3] += [*TABLE.center, TABLE.height_m]
    mesh = MODEL.mesh.transformed(X_WO)
    surface, plane = Surface(mesh.vertices, mesh.faces), Plane(offset=TABLE.height_m)
    found = plan_candidates(surface, plane, HAND, PlannerSettings(candidates=60), 0)
    scores = score_candidates(
        found, surface, plane, HAND, ScoringSettings(perturbation=FEW), seed=0
    )
    best = int(scores.score.argmax())
    return X_WO, found.X_WH[best], found.motion[best]


def test_a_good_grasp_lifts_and_a_hand_beside_the_object_does_not(lifter, grasp):
    X_WO, X_WH, motion = grasp
    good = lifter.lift(X_WO, X_WH, motion)
    assert good.lifted
    assert good.height_m == pytest.approx(lift_motion().lift_m, abs=0.02)
    beside = X_WH.copy()
    beside[:2, 3] += 0.25
    missed = lifter.lift(X_WO, beside, motion)
    assert not missed.lifted
    assert missed.height_m == pytest.approx(0.0, abs=0.002)
    assert missed.simulated_s < good.simulated_s
    again = lifter.lift(X_WO, X_WH, motion)  # What came before leaves no trace.
    assert again == good
