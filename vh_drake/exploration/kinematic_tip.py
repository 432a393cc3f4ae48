"""A fingertip without dynamics: a ball that moves along a curve until it meets a mesh.

The ball is never moved farther than its gap to the mesh, so that it can't pass through anything
(sphere tracing, Hart 1996). A contact counts where the ball moves towards what it touches; it may
leave along any direction that does not.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit

from vh_drake.exploration.trajectory import arc_length, velocity
from vh_drake.geometry.closest_points import TriangleTree, Vector, closest_point
from vh_drake.types import Array, Immutable

_TOUCH_M = 5e-5  # a gap that counts as contact
_LEAST_STEP_M = 1e-4  # where the ball slides along the mesh
_MOST_STEP_M = 0.01


@dataclass(frozen=True, eq=False)
class TipMotion(Immutable):
    """How a motion along a curve ended."""

    p_WTip: Array  # (3,) centre of the ball [m]
    direction_W: Array  # (3,) unit vector in which it moved last
    tau: float  # place on the curve, above 1 beyond its end
    length_m: float  # of the way
    touched: bool
    p_WC: Array  # (3,) the point of the mesh that is nearest to the ball [m]
    n_WC: Array  # (3,) unit vector from there to the ball


def move_along(
    tree: TriangleTree, control_points: Array, *, radius_m: float, beyond_m: float = 0.0
) -> TipMotion:
    """Move a ball along a cubic Bezier curve until it touches a mesh.

    Args:
        tree: of the mesh.
        control_points: (4, 3) of the curve of the ball's centre [m].
        radius_m: of the ball.
        beyond_m: how far it goes straight on behind the curve's end.
    """
    tau, centre, nearest = _trace(tree, control_points, radius_m, beyond_m)
    direction = velocity(control_points, tau)
    p, q = np.array(centre), np.array(nearest)
    normal = (p - q) / max(float(np.linalg.norm(p - q)), 1e-12)
    touched = bool(np.linalg.norm(p - q) <= radius_m + _TOUCH_M and direction @ normal < 0.0)
    unit = direction / max(float(np.linalg.norm(direction)), 1e-12)
    return TipMotion(p, unit, tau, _length(control_points, tau), touched, q, normal)


def _length(control_points: Array, tau: float) -> float:
    """Of a curve from 0 to τ, straight beyond τ = 1 [m]."""
    inside = min(tau, 1.0)
    halves = control_points.copy()  # de Casteljau's rule gives the part before τ
    for last in (1, 2, 3):
        halves[last:] = (1.0 - inside) * halves[last - 1 : -1] + inside * halves[last:]
    beyond = (tau - inside) * float(np.linalg.norm(velocity(control_points, 1.0)))
    return float(arc_length(halves[None])[0]) + beyond


@njit(cache=True)
def _trace(
    tree: TriangleTree, b: Array, radius: float, beyond: float
) -> tuple[float, Vector, Vector]:
    """Where the ball stops: τ, its centre and the mesh's nearest point."""
    end = max(3.0 * np.sqrt(((b[3] - b[2]) ** 2).sum()), 1e-9)
    fastest = end
    for i in range(3):
        fastest = max(fastest, 3.0 * np.sqrt(((b[i + 1] - b[i]) ** 2).sum()))
    # A curve that ends in a stand has no direction in which to go on.
    last = 1.0 + (beyond / end if end > 1e-6 else 0.0)
    tau, within = 0.0, np.inf
    while True:
        p, slope = _place(b, tau)
        distance, nearest = closest_point(tree, p, within)
        gap = distance - radius
        away = 0.0
        for axis in range(3):
            away += slope[axis] * (p[axis] - nearest[axis])
        if (gap <= _TOUCH_M and away < 0.0) or tau >= last:
            return tau, p, nearest
        speed = np.sqrt(slope[0] ** 2 + slope[1] ** 2 + slope[2] ** 2)
        step = min(max(gap, 0.0), _MOST_STEP_M) / (fastest if tau < 1.0 else end)
        least = min(_LEAST_STEP_M / max(speed, 1e-9), 0.01)  # a curve may stand still at τ = 0
        step = max(step, least)
        if tau < 1.0:
            step = min(step, max(1.0 - tau, 1e-12))
        tau = min(tau + step, last)
        within = distance + step * fastest + 1e-9


@njit(cache=True)
def _place(b: Array, tau: float) -> tuple[Vector, Vector]:
    """Position and derivative of the curve, straight beyond τ = 1."""
    u = min(tau, 1.0)
    v = 1.0 - u
    p, s = np.empty(3), np.empty(3)
    for a in range(3):
        s[a] = 3.0 * (
            v * v * (b[1, a] - b[0, a])
            + 2.0 * u * v * (b[2, a] - b[1, a])
            + u * u * (b[3, a] - b[2, a])
        )
        p[a] = v**3 * b[0, a] + 3.0 * v * v * u * b[1, a] + 3.0 * v * u * u * b[2, a]
        p[a] += u**3 * b[3, a] + (tau - u) * s[a]
    return (p[0], p[1], p[2]), (s[0], s[1], s[2])
