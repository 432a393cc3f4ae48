"""The tendon's equilibrium: ours beside NLopt on the objective of eq. 4.19.

NLopt gets the objective as the thesis has it, a function of three angles in mm and N, written
with plain floats (arrays would be several times slower). It starts where the tendon would turn
all joints alike, which suits more of its methods than the previous target's end does. Its
methods without derivatives are the peers; those with derivatives, which eq. 4.19 does not come
with, are listed too. Ours computes the same targets in one call.
"""

import math
from collections.abc import Callable

import numpy as np

from vh_drake.benches.gpis_peers import require
from vh_drake.benches.timing import best_ms
from vh_drake.catalog import Options
from vh_drake.errors import VhDrakeError
from vh_drake.hand.tendon_finger import TendonFinger, thesis_finger
from vh_drake.reports import Report, Row
from vh_drake.types import Array

TARGETS = 45
BATCH = 20_000  # equilibria of ours in one call
WITHOUT_DERIVATIVES = (
    "LN_COBYLA",
    "LN_BOBYQA",
    "LN_NEWUOA",
    "LN_PRAXIS",
    "LN_NELDERMEAD",
    "LN_SBPLX",
)
WITH_DERIVATIVES = ("LD_SLSQP", "LD_LBFGS", "LD_TNEWTON_PRECOND_RESTART", "LD_MMA")
LARGEST_DIFFERENCE_RAD = 1e-6  # of a peer that counts
_TOLERANCE_RAD = 1e-8
_MM, _ROOT_2 = 1e-3, math.sqrt(2.0)

Objective = Callable[[Array, Array], float]


def run(options: Options) -> Report:
    """Measure every method on the targets at which no joint is at a stop."""
    finger = thesis_finger()
    targets = free_targets(finger, TARGETS)
    ours_us = 1e3 * best_ms(lambda: finger.equilibrium(_batch(targets)), repeats=20) / BATCH
    single_us = 1e3 * best_ms(lambda: [finger.equilibrium(t) for t in targets]) / TARGETS
    rows = [
        peer_row(finger, targets, name, ours_us) for name in WITHOUT_DERIVATIVES + WITH_DERIVATIVES
    ]
    settings = {
        "seed": options.seed,
        "targets": TARGETS,
        "from_mm": round(1e3 * targets[0], 3),
        "to_mm": round(1e3 * targets[-1], 3),
        "tolerance_rad": _TOLERANCE_RAD,
        "threads": 1,
    }
    return Report("tendon", settings, _summary(rows, ours_us, single_us), rows=rows)


def free_targets(finger: TendonFinger, count: int) -> Array:
    """Shortenings (count,) [m] from where the last joint sets out to where the first one stops."""
    shortening = np.linspace(0.0, finger.closed_m, 100_001)
    angles = finger.equilibrium(shortening).angles
    free = shortening[((angles > 0) & (angles < finger.upper)).all(axis=1)]
    return np.linspace(free[0], free[-1], count + 2)[1:-1]


def peer_row(finger: TendonFinger, targets: Array, name: str, ours_us: float) -> Row:
    """Time, evaluations and largest difference from ours of one of NLopt's methods."""
    evaluations = 0

    def counted(objective: Objective) -> Objective:
        def call(angles: Array, gradient: Array) -> float:
            nonlocal evaluations
            evaluations += 1
            return objective(angles, gradient)

        return call

    found = minimise(finger, targets, name, counted)
    difference = float(np.abs(found - finger.equilibrium(targets).angles).max())
    peer_us = 1e3 * best_ms(lambda: minimise(finger, targets, name), repeats=3) / len(targets)
    return {
        "method": name,
        "derivatives": name in WITH_DERIVATIVES,
        "evaluations": round(evaluations / len(targets), 1),
        "solve_us": round(peer_us, 2),
        "max_difference_rad": difference,
        "speedup": round(peer_us / ours_us, 1),
    }


def minimise(
    finger: TendonFinger,
    targets: Array,
    name: str,
    wrapped: Callable[[Objective], Objective] = lambda objective: objective,
) -> Array:
    """Angles (k, 3) [rad] of least E for each target (k,) [m] by a method of NLopt."""
    nlopt = require("nlopt")
    angles = np.empty((len(targets), 3))
    for k, target in enumerate(targets):
        peer = nlopt.opt(getattr(nlopt, name), 3)
        peer.set_min_objective(wrapped(energy(finger, target)))
        peer.set_lower_bounds(np.zeros(3))
        peer.set_upper_bounds(finger.upper)
        peer.set_xtol_abs(_TOLERANCE_RAD)
        peer.set_maxeval(20_000)
        angles[k] = peer.optimize(np.full(3, target / finger.closed_m * math.pi / 2))
    return angles


def energy(finger: TendonFinger, target_m: float) -> Objective:
    """E of eq. 4.19 with its three differences of forces [mm² + N²], and its gradient."""
    k1, k2, k3 = (finger.stiffness / (_ROOT_2 * finger.lever_open_m)).tolist()
    p1, p2, p3 = finger.preload.tolist()
    length = float(finger.shortening_per_rad[0]) / _MM
    target = target_m / _MM
    quarter = math.pi / 4

    def value(angles: Array, gradient: Array) -> float:
        a, b, c = angles.tolist()
        s1, s2, s3 = math.sin(quarter + a / 2), math.sin(quarter + b / 2), math.sin(quarter + c / 2)
        f1, f2, f3 = k1 * (a + p1) / s1, k2 * (b + p2) / s2, k3 * (c + p3) / s3
        excess, f12, f13, f23 = length * (a + b + c) - target, f1 - f2, f1 - f3, f2 - f3
        if gradient.size:
            g1 = (k1 - 0.5 * f1 * math.cos(quarter + a / 2)) / s1
            g2 = (k2 - 0.5 * f2 * math.cos(quarter + b / 2)) / s2
            g3 = (k3 - 0.5 * f3 * math.cos(quarter + c / 2)) / s3
            gradient[0] = 2.0 * (excess * length + (f12 + f13) * g1)
            gradient[1] = 2.0 * (excess * length + (f23 - f12) * g2)
            gradient[2] = 2.0 * (excess * length - (f13 + f23) * g3)
        return excess * excess + f12 * f12 + f13 * f13 + f23 * f23

    return value


def _batch(targets: Array) -> Array:
    return np.linspace(targets[0], targets[-1], BATCH)


def _summary(rows: list[Row], ours_us: float, single_us: float) -> Row:
    """Against the fastest of NLopt's methods that finds the same angles."""
    same = [row for row in rows if row["max_difference_rad"] <= LARGEST_DIFFERENCE_RAD]
    plain = [row for row in same if not row["derivatives"]]
    if not plain:
        raise VhDrakeError("no method of NLopt found the equilibria; see whether nlopt works here")
    fastest = min(plain, key=lambda row: row["solve_us"])
    return {
        "speedup_over_nlopt": fastest["speedup"],
        "max_difference_rad": fastest["max_difference_rad"],
        "nlopt_method": fastest["method"],
        "nlopt_us": fastest["solve_us"],
        "solve_us": round(ours_us, 4),
        "single_call_us": round(single_us, 2),
        "speedup_over_nlopt_with_derivatives": min(
            (row["speedup"] for row in same if row["derivatives"]), default=None
        ),
    }
