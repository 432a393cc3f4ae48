"""`bench planners`: both grasp planners on fused estimates, within the arm's reach.

Each scene is an object on the table, one noisy look and one touch. A candidate counts as usable
where inverse kinematics with many restarts finds the arm a configuration for it, and the open
hand stays off the table; both are computed by other code than the planners'. Beside it stands
the share of candidates whose whole way, from home over the object into the grasp and up again,
the arm's controllers carry out.
"""

import time
from collections import Counter
from collections.abc import Sequence
from functools import partial

import numpy as np

from vh_drake.catalog import Options
from vh_drake.control.kinematics import ArmKinematics
from vh_drake.control.reach import rollout, solve_ik
from vh_drake.geometry.skeleton import curve_skeleton
from vh_drake.gpis.surface import estimate_surface
from vh_drake.grasping.approach import GraspMotionSettings, approach_poses
from vh_drake.grasping.diversity import diversity
from vh_drake.grasping.field import object_field
from vh_drake.grasping.planner_settings import PlannerSettings
from vh_drake.grasping.planners import plan_candidates
from vh_drake.hand.clearance import link_clearance, obstacles
from vh_drake.hand.description import load_hand
from vh_drake.hand.model import HandModel, read_hand_model
from vh_drake.hand.shipped import hand_file
from vh_drake.learning.scene import SceneSettings, look, place
from vh_drake.learning.touches import explore
from vh_drake.objects.library import library_object
from vh_drake.reports import Report, Row
from vh_drake.types import Candidates, Plane, Surface

OBJECTS = ("fruit_drink", "can", "bottle", "apple", "power_drill", "mug")
CANDIDATES = 800
REPEATS = 3
_CHECKED = 8  # Every so manieth candidate is checked for reach, which costs more than planning


def run(options: Options) -> Report:
    """Plan on each scene a few times; the least time of each counts."""
    hand, arm = read_hand_model(load_hand(hand_file())), ArmKinematics("right")
    names = OBJECTS[: options.runs] if options.runs else OBJECTS
    rows = [bench_row(name, hand, arm, options.seed) for name in names]
    settings = {
        "objects": list(names),
        "candidates": CANDIDATES,
        "touches": 1,
        "seed": options.seed,
        "checked_share": 1 / _CHECKED,
    }
    return Report("planners", settings, summarized(rows), {}, rows)


def bench_row(name: str, hand: HandModel, arm: ArmKinematics, seed: int) -> Row:
    """Time, number, use and diversity of the candidates on one object."""
    surface, table = fused_estimate(name, seed)
    settings = PlannerSettings(candidates=CANDIDATES)
    plan = partial(plan_candidates, surface, table, hand, settings, seed, arm=arm)
    plan()  # compiles
    seconds, candidates = np.inf, Candidates()
    for _ in range(REPEATS):
        start = time.perf_counter()
        candidates = plan()
        seconds = min(seconds, time.perf_counter() - start)
    reached, clear, executed = checked(candidates, surface, table, hand, arm)
    varied = diversity(candidates.X_WH, hand)
    skeleton = curve_skeleton(object_field(surface, table).distance)
    return {
        "object": name,
        "seconds": round(seconds, 3),
        "candidates": len(candidates),
        **{f"{name}_planner": n for name, n in sorted(Counter(candidates.planner).items())},
        "reachable_share": round(float(reached.mean()), 4),
        "off_table_share": round(float(clear.mean()), 4),
        "usable_share": round(float((reached & clear).mean()), 4),
        "executable_share": round(float(executed.mean()), 4),
        "nearest_mm": round(1e3 * varied.nearest_m, 2),
        "distinct": varied.distinct,
        "skeleton_trust": round(skeleton.trust, 3),
        "skeleton_trusted": skeleton.trusted,
    }


def fused_estimate(name: str, seed: int) -> tuple[Surface, Plane]:
    """The estimate of an embedded object after one look and one touch, and its table."""
    rng, settings = np.random.default_rng([seed, 17]), SceneSettings()
    truth = place(library_object(name).mesh, settings, rng)
    view = look(truth, settings, rng)
    field = object_field(Surface(truth.mesh.vertices, truth.mesh.faces), truth.table)
    return estimate_surface(view, explore(view, field, 1, rng)), view.table


def checked(
    candidates: Candidates, surface: Surface, table: Plane, hand: HandModel, arm: ArmKinematics
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of every eighth candidate: reachable, off the table, carried out by the controllers."""
    scene, motion = obstacles(surface, table), GraspMotionSettings()
    X_WH_now, rows = arm.pose(arm.home), []
    for i in range(0, len(candidates), _CHECKED):
        X = candidates.X_WH[i]
        way = approach_poses(X, candidates.motion[i], scene, hand, X_WH_now, motion)
        lifted = X.copy()
        lifted[:3, 3] += motion.rise_m(candidates.motion[i]) * table.normal
        rows.append(
            (
                solve_ik(arm, X) is not None,
                link_clearance(hand, X, scene)[1] > 0,
                rollout(arm, arm.home, [*way, lifted]).reached,
            )
        )
    reached, clear, executed = np.array(rows, bool).reshape(-1, 3).T
    return reached, clear, executed


def summarized(rows: Sequence[Row]) -> Row:
    """The slowest, the fewest and the worst, so that all scenes are at least as good."""
    return {
        "candidates": min(row["candidates"] for row in rows),
        "seconds": max(row["seconds"] for row in rows),
        "usable_share": min(row["usable_share"] for row in rows),
        "executable_share": min(row["executable_share"] for row in rows),
        "seconds_median": round(float(np.median([row["seconds"] for row in rows])), 3),
        "usable_share_mean": round(float(np.mean([row["usable_share"] for row in rows])), 4),
        "executable_share_mean": round(
            float(np.mean([row["executable_share"] for row in rows])), 4
        ),
        "nearest_median_mm": round(float(np.median([row["nearest_mm"] for row in rows])), 2),
        "distinct_median": int(np.median([row["distinct"] for row in rows])),
    }
