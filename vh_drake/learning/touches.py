"""Touches without a simulator: a fingertip goes the planned way until it meets the true object."""

import dataclasses as dc

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix
from scipy.spatial.transform import Rotation

from vh_drake.exploration.next_touch import TouchSettings, plan_touch
from vh_drake.geometry.signed_distance import interpolate
from vh_drake.gpis.surface import SurfaceSettings, estimate_surface
from vh_drake.grasping.field import ObjectField
from vh_drake.learning.scene import single
from vh_drake.types import Array, ContactSet, ObjectView, Surface, TouchPlan


@dc.dataclass
class KinematicTouchSettings:
    """The finger, its way, and how well it feels."""

    standoff_m: float = 0.05  # where the guarded way starts, before the estimate
    beyond_m: float = 0.04  # behind the estimate, until which the finger searches
    radius_m: float = 0.009  # of the finger's round end
    least_height_m: float = 0.0132  # of its middle over the table
    step_m: float = 0.0005
    position_std_m: float = 0.0015  # per axis, of what is felt
    normal_std_deg: float = 8.0  # per axis
    p_WTip: list[float] = dc.field(default_factory=lambda: [0.42, -0.5, 1.15])  # at the start


def explore(
    view: ObjectView,
    truth: ObjectField,
    touches: int,
    rng: np.random.Generator,
    settings: KinematicTouchSettings | None = None,
) -> ContactSet:
    """Touch an object several times by next best touch (Algorithm 2); misses are left out.

    Args:
        view: what the camera saw.
        truth: the true object.
        touches: how many are tried.
        rng: draws the sensor's errors.
        settings: of finger and sensor.
    """
    settings = settings or KinematicTouchSettings()
    coarse = SurfaceSettings(least_spacing_m=0.005, most_nodes=25_000)
    contacts, tip, failed = ContactSet(), RigidTransform(settings.p_WTip), np.zeros((0, 3))
    for _ in range(touches):
        surface = estimate_surface(view, contacts, coarse)
        plan = _next_plan(surface, view, contacts, tip, failed)
        if plan is None:
            break
        way = approach_direction(plan, view)
        felt = feel(plan.p_WT, way, truth, settings, rng)
        tip = RigidTransform(_looking_along(way), plan.p_WT - settings.standoff_m * way)
        if felt is None:
            failed = np.vstack([failed, plan.p_WT])
        else:
            contacts = contacts.with_contact(*felt)
    return contacts


def approach_direction(plan: TouchPlan, view: ObjectView) -> Array:
    """Unit direction (3,) of the guarded way: against the normal, level where it is undercut."""
    up, n = view.table.normal, plan.n_WT
    level = n - (n @ up) * up
    if n @ up < 0 and np.linalg.norm(level) > 0.3:
        n = level
    direction: Array = -n / np.linalg.norm(n)
    return direction


def feel(
    p_WT: Array,
    way: Array,
    truth: ObjectField,
    settings: KinematicTouchSettings,
    rng: np.random.Generator,
) -> tuple[Array, Array] | None:
    """Where a round fingertip first meets the object on a straight way, with errors.

    Args:
        p_WT: (3,) target on the estimate [m].
        way: (3,) unit direction.
        truth: the true object.
        settings: of finger and sensor.
        rng: draws the errors; the same number whether or not something is met.

    Returns:
        Position [m] and outward normal (3,), in single precision; None where nothing is met.
    """
    errors = rng.standard_normal((2, 3))
    steps = np.arange(-settings.standoff_m, settings.beyond_m, settings.step_m)
    p_WEnd = p_WT + (steps[:, None] - settings.radius_m) * way
    low = settings.least_height_m - truth.table.height(p_WEnd)
    p_WEnd += np.maximum(low, 0.0)[:, None] * truth.table.normal
    gap, gradient = interpolate(truth.distance, p_WEnd)
    met = np.flatnonzero(gap <= settings.radius_m)
    if len(met) == 0:
        return None
    normal = gradient[met[0]] / max(float(np.linalg.norm(gradient[met[0]])), 1e-9)
    point = p_WEnd[met[0]] - gap[met[0]] * normal
    turn = Rotation.from_rotvec(np.deg2rad(settings.normal_std_deg) * errors[1])
    return single(point + settings.position_std_m * errors[0]), _unit(turn.apply(normal))


def _unit(v: Array) -> Array:
    return single(v / np.linalg.norm(v))


def _next_plan(
    surface: Surface,
    view: ObjectView,
    contacts: ContactSet,
    tip: RigidTransform,
    failed: Array,
) -> TouchPlan | None:
    """The best rated touch away from places where nothing was met."""
    if len(surface.faces) == 0:
        return None
    for plan in plan_touch(surface, view, contacts, tip, None, TouchSettings()):
        if (np.linalg.norm(failed - plan.p_WT, axis=1) > 0.025).all():
            return plan
    return None


def _looking_along(z: Array) -> RotationMatrix:
    """A rotation whose z axis is a unit vector (3,)."""
    return RotationMatrix.MakeFromOneVector(z, 2)
