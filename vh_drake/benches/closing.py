"""`bench closing`: kinematic closings a second, and what the signed distance grid costs in truth.

Each object stands on a table, and the hand closes from where the planners would begin, coming on
along its palm as it does for labels. Closings are timed on one core with a grid of 2 mm. A grid
of 0.5 mm and the mesh itself say how far that grid is off: in labels, and in contacts.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numba import njit

from vh_drake.benches.timing import best_ms
from vh_drake.catalog import Options
from vh_drake.errors import BadInput
from vh_drake.experiments.estimate import evaluated_objects
from vh_drake.geometry.closest_points import closest_points, triangle_tree
from vh_drake.geometry.meshes import TriMesh
from vh_drake.grasping.closing import Closure, close_fingers, new_state
from vh_drake.grasping.field import FieldArrays, ObjectField, object_field
from vh_drake.grasping.motions import CollectSettings, MotionArrays, motion_of
from vh_drake.grasping.planner_settings import PlannerSettings
from vh_drake.grasping.planners import plan_candidates
from vh_drake.hand.description import load_hand
from vh_drake.hand.kinematics import HandArrays
from vh_drake.hand.model import HandModel, read_hand_model
from vh_drake.hand.shipped import hand_file
from vh_drake.learning.labels import (
    SUCCESS_RATE,
    LabelSettings,
    guarded_rates,
    nominal_closures,
    start_poses,
)
from vh_drake.learning.scene import SceneSettings, TrueObject, place
from vh_drake.objects.loading import load_object
from vh_drake.reports import Report, Row
from vh_drake.types import Array, Candidates, Surface

OBJECTS = ("apple", "banana", "can", "fruit_drink", "mug", "sugar_box")
CANDIDATES = 150  # of each object
TRIALS = 100  # of each label
SPACING_M, FINE_M = 0.002, 0.0005
_PADDING_M = 0.015  # a sphere that touches has its centre within the grid
_MOST_FINE_NODES = 2e7  # of larger objects the time is taken alone
_REPEATS = 20


def run(options: Options) -> Report:
    """Time closings and compare grids on each object.

    Raises:
        BadInput: an option is unusable, or there is nothing to grasp.
    """
    names = OBJECTS if options.objects is None else tuple(evaluated_objects(options))
    names = names[: options.runs]
    hand = read_hand_model(load_hand(hand_file()))
    rows = [bench_row(name, options.objects, hand, options.seed) for name in names]
    settings = {
        "objects": list(names),
        "candidates": CANDIDATES,
        "trials": TRIALS,
        "spheres": len(hand.arrays.sphere_radius),
        "spacing_mm": 1e3 * SPACING_M,
        "fine_mm": 1e3 * FINE_M,
        "seed": options.seed,
    }
    return Report("closing", settings, summarized(rows), {}, rows)


def bench_row(name: str, folder: Path | None, hand: HandModel, seed: int) -> Row:
    """Time of a closing [µs] on one object, and what the finer grid and the mesh say of it."""
    truth = place(
        load_object(name, folder=folder).mesh, SceneSettings(), np.random.default_rng([seed, 17])
    )
    surface = Surface(truth.mesh.vertices, truth.mesh.faces)
    wanted = PlannerSettings(candidates=CANDIDATES)
    candidates = plan_candidates(surface, truth.table, hand, wanted, seed)
    row: Row = {"object": name, "candidates": len(candidates)}
    if len(candidates) == 0:
        return row
    field = _field(truth, SPACING_M)
    closings, ms = timed(candidates, field, hand)
    row |= {"closings": closings, "closings_per_s": round(1e3 * closings / max(ms, 1e-9))}
    if np.prod(truth.mesh.extents + 2 * _PADDING_M) / FINE_M**3 > _MOST_FINE_NODES:
        return row
    return row | compared(candidates, (field, _field(truth, FINE_M)), truth.mesh, hand, seed)


def _field(truth: TrueObject, spacing_m: float) -> ObjectField:
    surface = Surface(truth.mesh.vertices, truth.mesh.faces)
    return object_field(surface, truth.table, spacing_m=spacing_m, padding_m=_PADDING_M)


def timed(candidates: Candidates, field: ObjectField, hand: HandModel) -> tuple[int, float]:
    """How many closings begin free, and how long they take together [ms].

    What begins in collision takes next to no time and does not count.
    """
    palm = np.asarray(hand.description.palm) / np.linalg.norm(hand.description.palm)
    way = LabelSettings().guarded_m
    closings, total_ms = 0, 0.0
    for name in sorted(set(candidates.motion)):
        own = np.array([motion == name for motion in candidates.motion])
        motion = motion_of(name, hand, CollectSettings())
        X = np.ascontiguousarray(start_poses(candidates.X_WH[own], hand, way)[:, :3])
        arrays = (hand.arrays, field.arrays, motion)
        free = np.array([_close_all(*arrays, one[None], palm, way) for one in X], bool)
        starts = np.ascontiguousarray(X[free])
        closings += len(starts)
        total_ms += _best_ms(arrays, starts, palm, way)
    return closings, total_ms


def _best_ms(
    arrays: tuple[HandArrays, FieldArrays, MotionArrays], starts: Array, palm: Array, way: float
) -> float:
    if len(starts) == 0:
        return 0.0
    return best_ms(lambda: _close_all(*arrays, starts, palm, way), repeats=_REPEATS)


@njit(cache=True)
def _close_all(
    hand: HandArrays, field: FieldArrays, motion: MotionArrays, X_WH: Array, palm: Array, way: float
) -> int:
    """Close from each pose (n, 3, 4); returns how many began free."""
    state, free = new_state(hand), 0
    for i in range(len(X_WH)):
        free += close_fingers(hand, field, motion, X_WH[i], palm, way, state)
    return free


def compared(
    candidates: Candidates,
    fields: tuple[ObjectField, ObjectField],
    mesh: TriMesh,
    hand: HandModel,
    seed: int,
) -> Row:
    """Labels and contacts by a coarse and a fine grid, and contacts beside the mesh."""
    settings = LabelSettings(min_samples=TRIALS, max_samples=TRIALS)
    coarse, fine = (
        guarded_rates(candidates, field, hand, settings, seed).rate > SUCCESS_RATE
        for field in fields
    )
    closures = [nominal_closures(candidates, field, hand, settings) for field in fields]
    p = np.concatenate([one.p_WC for one in closures[0]])
    off = np.linalg.norm(closest_points(triangle_tree(mesh), p) - p, axis=1)
    shifts = np.concatenate([shift(a, b) for a, b in zip(*closures, strict=True)])
    return {
        "labels_agree": int((coarse == fine).sum()),
        "labels": len(coarse),
        "successes": int(fine.sum()),
        "contacts": len(p),
        "off_mesh_mm": round(1e3 * float(np.median(off)), 4),
        "off_mesh_95_mm": round(1e3 * float(np.quantile(off, 0.95)), 4),
        "shift_mm": round(1e3 * float(np.median(shifts)), 4),
    }


def shift(one: Closure, other: Closure) -> Array:
    """How far the contacts of links that touch in both are apart (k,) [m]."""
    _, a, b = np.intersect1d(one.links, other.links, return_indices=True)
    apart: Array = np.linalg.norm(one.p_WC[a] - other.p_WC[b], axis=1)
    return apart


def summarized(rows: Sequence[Row]) -> Row:
    """All closings together, and the slowest object.

    Raises:
        BadInput: no candidate closed on anything.
    """
    timed_rows = [row for row in rows if row.get("closings")]
    if not timed_rows:
        raise BadInput("no object of the choice can be grasped; choose others with --objects")
    seconds = sum(row["closings"] / row["closings_per_s"] for row in timed_rows)
    summary: Row = {
        "closings_per_s": round(sum(row["closings"] for row in timed_rows) / seconds),
        "closings_per_s_slowest": min(row["closings_per_s"] for row in timed_rows),
    }
    fine = [row for row in rows if row.get("labels")]
    if fine:
        labels = sum(row["labels"] for row in fine)
        summary |= {
            "label_agreement": round(sum(row["labels_agree"] for row in fine) / labels, 4),
            "labels": labels,
            "success_share": round(sum(row["successes"] for row in fine) / labels, 4),
            "contact_off_mesh_median_mm": float(np.median([row["off_mesh_mm"] for row in fine])),
            "contact_shift_median_mm": float(np.median([row["shift_mm"] for row in fine])),
        }
    return summary | {"objects_without_fine_grid": len(rows) - len(fine)}
