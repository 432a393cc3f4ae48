"""Force-closure tests beside SciPy's linear program, and epsilon beside Qhull's hull."""

import numpy as np
from numba import njit
from scipy.optimize import linprog

from vh_drake.benches.timing import best_ms
from vh_drake.catalog import Options
from vh_drake.grasping.epsilon import epsilon_quality
from vh_drake.grasping.wrench_space import (
    ContactSettings,
    is_force_closure,
    spans_positively,
    wrench_matrix,
    wrench_quality,
)
from vh_drake.reports import Report
from vh_drake.types import Array

GRASPS = 300
HULLS = 20
CLEAR_SLACK = 1e-4


def run(options: Options) -> Report:
    """Time and compare; a test is the decision for wrenches that are already there."""
    rng = np.random.default_rng(options.seed)
    grasps = [random_wrenches(rng) for _ in range(options.runs or GRASPS)]
    slacks = np.array([slack(W) for W in grasps])
    ours = np.array([is_force_closure(W) for W in grasps])
    clear = np.abs(slacks) > CLEAR_SLACK
    rows = np.stack([np.pad(W.T, ((0, 64 - W.shape[1]), (0, 0))) for W in grasps])
    counts = np.array([W.shape[1] for W in grasps])
    _decide_all(rows[:1], counts[:1])  # compiles
    tests_ms = best_ms(lambda: _decide_all(rows, counts), repeats=50) / len(grasps)
    lp_ms = best_ms(lambda: [slack(W) for W in grasps], repeats=2) / len(grasps)
    hulls = [W for W in grasps if is_force_closure(W)][:HULLS]
    hull_ms = best_ms(lambda: [wrench_quality(W) for W in hulls], repeats=2) / len(hulls)
    epsilon_ms = best_ms(lambda: [epsilon_quality(W) for W in hulls], repeats=5) / len(hulls)
    epsilon_error = max(abs(epsilon_quality(W) - wrench_quality(W).epsilon) for W in hulls)
    summary = {
        "tests_per_s": 1e3 / tests_ms,
        "speedup_over_lp": lp_ms / tests_ms,
        "agreement": float((ours == (slacks > 0))[clear].mean()),
        "clear_share": float(clear.mean()),
        "closed_share": float(ours.mean()),
        "lp_ms": lp_ms,
        "hull_ms": hull_ms,
        "epsilon_ms": epsilon_ms,
        "epsilon_speedup_over_hull": hull_ms / epsilon_ms,
        "epsilon_max_difference": epsilon_error,
    }
    settings = {"grasps": len(grasps), "seed": options.seed, "contacts": "3 to 8", "edges": 8}
    return Report("force-closure", settings, summary)


def random_wrenches(rng: np.random.Generator) -> Array:
    """Wrenches (6, n) of 3 to 8 contacts on a ball of 5 cm whose normals are disturbed."""
    p = rng.normal(size=(rng.integers(3, 9), 3))
    p /= np.linalg.norm(p, axis=1, keepdims=True)
    n = p + 0.5 * rng.normal(size=p.shape)
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    settings = ContactSettings()
    return wrench_matrix(0.05 * p, n, center=np.zeros(3), size_m=0.05, settings=settings)


def slack(W: Array) -> float:
    """N times the largest weight that all wrenches W (6, n) can have in a balance of unit sum.

    Positive where the origin is strictly inside the hull of wrenches of full rank.
    """
    n = W.shape[1]
    solution = linprog(
        np.append(np.zeros(n), -1),
        A_eq=np.vstack([np.column_stack([W, np.zeros(6)]), np.append(np.ones(n), 0)]),
        b_eq=np.append(np.zeros(6), 1),
        A_ub=np.column_stack([-np.eye(n), np.ones(n)]),
        b_ub=np.zeros(n),
        bounds=(None, None),
    )
    return float(-solution.fun * n) if solution.success else -1.0


@njit(cache=True)
def _decide_all(rows: Array, counts: Array) -> int:
    """How many of the grasps are force closed; `rows` (g, 64, 6) stay as they are."""
    closed, own = 0, np.empty((64, 6))
    for grasp in range(len(rows)):
        own[:] = rows[grasp]
        closed += spans_positively(own, counts[grasp])
    return closed
