"""Grasps on surfaces known from touches alone (section 3.5), for figures 3.23 to 3.25.

A fingertip with the noise of the tactile sensor explores an object by IGEF; the estimate with
normals is what the planners see. Hands come from anywhere, as there is no table in that section.
"""

import dataclasses as dc
from collections.abc import Sequence

import numpy as np

from vh_drake.experiments.table_3_6 import EXPLORER, NOISY, sensed
from vh_drake.exploration.loop import EndSettings, explore, make_body
from vh_drake.geometry.inertia import mass_properties
from vh_drake.geometry.meshes import TriMesh
from vh_drake.gpis.contact_surface import ContactSurface
from vh_drake.gpis.meshing import closed_mesh
from vh_drake.gpis.prior import node_coordinates
from vh_drake.grasping.closing import Closure
from vh_drake.grasping.diversity import spread
from vh_drake.grasping.field import ObjectField, object_field
from vh_drake.grasping.planner_settings import PlannerSettings
from vh_drake.grasping.planners import plan_candidates
from vh_drake.hand.model import HandModel
from vh_drake.learning.labels import (
    LabelSettings,
    guarded_rates,
    nominal_closures,
    nominal_epsilon,
)
from vh_drake.objects.library import library_object
from vh_drake.reports import Row
from vh_drake.types import Array, Candidates, ContactSet, IntArray, Plane, ScalarGrid, Surface

CANDIDATES = 100
END = EndSettings(goal=0.9, most_touches=119, most_without_gain=40)
NO_TABLE = Plane(np.array([0.0, 0.0, 1.0]), -1.0)  # a metre below
_SPACING_M, _MARGIN_M = 0.004, 0.01  # of the estimate, and of it beyond the contacts
_GRID_M = 0.002  # of signed distances


@dc.dataclass(frozen=True, eq=False)
class Touched:
    """An object, what was felt of it, and the estimate."""

    name: str
    truth: TriMesh
    contacts: ContactSet
    surface: Surface


@dc.dataclass(frozen=True, eq=False)
class Planned:
    """Candidates of one planner for one hand, and how they end."""

    touched: Touched
    hand: HandModel
    planner: str
    candidates: Candidates
    closures: list[Closure]  # on the estimate
    epsilon: Array  # (n,) on the estimate; 0 is not stable
    rate: Array  # (n,) force-closure rate of disturbed grasps on the true object

    @property
    def stable(self) -> IntArray:
        """Indices of the candidates that are stable on the estimate, best first."""
        order = np.argsort(-self.epsilon, kind="stable")
        best: IntArray = order[self.epsilon[order] > 0]
        return best


def touched_object(name: str, seed: int) -> Touched:
    """Explore an object of the library and estimate it."""
    truth = library_object(name).mesh
    body = make_body(truth, mass_properties(truth, 1.0).com)
    known = explore(body, EXPLORER, END, seed=seed).known.contacts
    p, n = sensed(known.p_WC, known.n_WC, seed)
    estimate = ContactSurface.of(p, n, kernel=NOISY.kernel, noise=NOISY.noise)
    return Touched(name, truth, ContactSet(p, n), closed_surface(estimate))


def closed_surface(estimate: ContactSurface) -> Surface:
    """The estimate within a box around its contacts, closed at the box where it is cut."""
    low = estimate.p_WC.min(axis=0) - _MARGIN_M
    counts = np.ceil((np.ptp(estimate.p_WC, axis=0) + 2 * _MARGIN_M) / _SPACING_M).astype(int) + 1
    grid = ScalarGrid(low, _SPACING_M, np.zeros(counts))
    values = estimate.posterior.mean_on_grid(*node_coordinates(grid))
    potential = ScalarGrid(low, _SPACING_M, values)
    vertices, faces, normals = closed_mesh(potential, estimate.p_WC)
    return Surface(vertices, faces, normals, estimate.variance(vertices), potential)


def planned(touched: Touched, hand: HandModel, planner: str, seed: int) -> Planned:
    """Plan with one planner and close every candidate."""
    wanted = PlannerSettings(planners=[planner], approaches=["free"], candidates=CANDIDATES)
    candidates = plan_candidates(touched.surface, NO_TABLE, hand, wanted, seed)
    field = object_field(touched.surface, NO_TABLE, spacing_m=_GRID_M)
    settings = LabelSettings()
    rates = guarded_rates(candidates, _true_field(touched), hand, settings, seed)
    return Planned(
        touched,
        hand,
        planner,
        candidates,
        nominal_closures(candidates, field, hand, settings),
        nominal_epsilon(candidates, field, hand, settings),
        rates.rate,
    )


def _true_field(touched: Touched) -> ObjectField:
    truth = touched.truth
    return object_field(Surface(truth.vertices, truth.faces), NO_TABLE, spacing_m=_GRID_M)


def shown(plan: Planned, count: int) -> IntArray:
    """Indices (k,) of stable candidates to draw, k ≤ count: of the better half, far apart."""
    stable = plan.stable
    better = stable[: max(count, len(stable) // 2)]
    if len(better) <= count:
        return better
    poses = plan.candidates.X_WH[better]
    kept = spread(poses, np.zeros(len(better)), plan.hand, count)
    chosen: IntArray = better[np.sort(kept)]
    return chosen


def candidate_rows(plans: Sequence[Planned]) -> list[Row]:
    """One row a candidate."""
    return [
        {
            "object": plan.touched.name,
            "hand": plan.hand.description.name,
            "planner": plan.planner,
            "candidate": i,
            "contacts": len(plan.closures[i].links),
            "epsilon_on_estimate": round(float(plan.epsilon[i]), 4),
            "rate_on_object": round(float(plan.rate[i]), 4),
        }
        for plan in plans
        for i in range(len(plan.candidates))
    ]


def plan_figures(plan: Planned) -> Row:
    """How many candidates are stable on the estimate, and how often these hold the object."""
    stable = plan.stable
    return {
        "candidates": len(plan.candidates),
        "stable_share": round(len(stable) / max(len(plan.candidates), 1), 4),
        "stable_rate_on_object": round(float(plan.rate[stable].mean()), 4) if len(stable) else 0.0,
    }
