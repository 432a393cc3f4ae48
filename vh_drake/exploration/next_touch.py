"""Choice of the next touch on an estimated surface (Algorithm 2, RateAndSelectTarget).

In grasping (chapter 4) a touch shall show what the camera can't: candidates face away from it,
lie high enough over the table for a finger and low enough to meet the object, and have
roughly horizontal normals. Where nothing passes all limits these are relaxed, tier by tier.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from pydrake.math import RigidTransform

from vh_drake.errors import UnknownName
from vh_drake.exploration.ratings import IgefSettings, igef
from vh_drake.exploration.trajectory import approach_curves, arc_length
from vh_drake.gpis.evidence import farthest_points, kept_apart
from vh_drake.types import Array, ContactSet, IntArray, ObjectView, Surface, TouchPlan

STRATEGIES = ["igef", "gp_variance", "random"]
DEPARTURES = ["inverse_velocity", "contact_normal"]


@dataclass(frozen=True)
class Limits:
    """What a place must be like to be touched."""

    most_facing_camera: float = -0.45  # largest n · (direction to the camera)
    least_height_m: float = 0.02  # over the table
    most_height_share: float = 0.6  # of the object's height
    most_vertical: float = 0.4  # largest |n · up|


@dataclass(frozen=True)
class TouchSettings:
    """How the next touch is chosen."""

    strategy: str = "igef"
    departure: str = "inverse_velocity"  # eq. 3.71, or along the last contact's normal
    igef: IgefSettings = field(default_factory=IgefSettings)
    # Points that were seen count as contacts of this wider kind before the first touch.
    igef_of_view: IgefSettings = field(
        default_factory=lambda: IgefSettings(mu3_m=0.05, sigma3_m=0.05)
    )
    seen_points: int = 100
    # IGEF is weighted by (-n · direction to the camera) to this power: estimated normals err,
    # and a place that faces away clearly is the surer touch of the hidden side. 0: as printed.
    hidden_power: float = 2.0
    candidate_radius_m: float = np.inf  # R_0 around the fingertip
    tiers: tuple[Limits, ...] = (
        Limits(),
        Limits(-0.35, 0.015, 0.75, 0.6),
        Limits(-0.25, 0.012, 0.9, 0.75),
        Limits(-0.1, 0.01, 1.0, 0.9),
    )
    apart_m: float = 0.01  # between plans of the list
    most_plans: int = 60
    seed: int = 0


def plan_touch(
    surface: Surface,
    view: ObjectView,
    contacts: ContactSet,
    X_WTip: RigidTransform,
    v_WTip: Array | None,
    settings: TouchSettings | None = None,
    feasible: Callable[[TouchPlan], bool] | None = None,
) -> tuple[TouchPlan, ...]:
    """Touches worth trying, best first; empty where no place may be touched.

    Args:
        surface: estimated surface with outward normals.
        view: what the camera saw, where it stands, and the table.
        contacts: touches so far; their last normal serves the departure rule.
        X_WTip: pose of the fingertip now, z along its approach axis.
        v_WTip: (3,) velocity of the fingertip just before the last contact [m/s], None at rest.
        settings: strategy, limits, parameters.
        feasible: whether the arm can do a plan; others are left out.

    Raises:
        UnknownName: strategy or departure rule.
    """
    settings = settings or TouchSettings()
    _require_known(settings)
    tier = tiers_of(surface, view, X_WTip.translation(), settings)
    chosen = np.flatnonzero(tier < len(settings.tiers))
    p, n = surface.vertices[chosen], surface.normals[chosen]
    departure = departure_direction(contacts, v_WTip, settings.departure)
    curves = approach_curves(X_WTip.translation(), departure, p, n)
    rating = _rate(surface, chosen, view, contacts, curves, X_WTip.rotation().col(2), settings)
    order = np.lexsort((np.arange(len(chosen)), -rating, tier[chosen]))
    plans: list[TouchPlan] = []
    for i in kept_apart(p, order, settings.apart_m):
        plan = TouchPlan(p[i], n[i], curves[i], float(rating[i]))
        if feasible is None or feasible(plan):
            plans.append(plan)
        if len(plans) == settings.most_plans:
            break
    return tuple(plans)


def tiers_of(
    surface: Surface, view: ObjectView, p_WTip: Array, settings: TouchSettings
) -> IntArray:
    """The first tier of limits that each vertex passes (v,); len(tiers) for none."""
    near = np.linalg.norm(surface.vertices - p_WTip, axis=1) <= settings.candidate_radius_m
    tier = np.full(len(surface.vertices), len(settings.tiers), dtype=np.int64)
    for i in range(len(settings.tiers) - 1, -1, -1):
        tier[near & _passes(surface, view, settings.tiers[i])] = i
    return tier


def facing_camera(surface: Surface, view: ObjectView) -> Array:
    """Cosine n · (direction to the camera) of every vertex (v,); negative faces away.

    Undercut normals count as level: that is how a finger comes at them, and it meets the
    object where that is widest.
    """
    up = view.table.normal
    n = surface.normals - np.minimum(surface.normals @ up, 0.0)[:, None] * up
    n /= np.maximum(np.linalg.norm(n, axis=1, keepdims=True), 1e-9)
    to_camera = view.p_WCamera - surface.vertices
    distance = np.linalg.norm(to_camera, axis=1)
    facing: Array = np.einsum("ij,ij->i", n, to_camera) / distance
    return facing


def departure_direction(contacts: ContactSet, v_WTip: Array | None, rule: str) -> Array | None:
    """Unit direction in which the fingertip leaves; None where neither rule applies."""
    if rule == "contact_normal" and len(contacts):
        normal: Array = contacts.n_WC[-1]
        return normal
    speed = 0.0 if v_WTip is None else float(np.linalg.norm(v_WTip))
    return None if v_WTip is None or speed < 1e-6 else -v_WTip / speed


def _passes(surface: Surface, view: ObjectView, limits: Limits) -> NDArray[np.bool_]:
    height = view.table.height(surface.vertices)
    top = max(limits.most_height_share * float(height.max(initial=0.0)), limits.least_height_m)
    level = np.abs(surface.normals @ view.table.normal) <= limits.most_vertical
    away = facing_camera(surface, view) <= limits.most_facing_camera
    return np.asarray(away & level & (height >= limits.least_height_m) & (height <= top))


def _rate(
    surface: Surface,
    chosen: IntArray,
    view: ObjectView,
    contacts: ContactSet,
    curves: Array,
    approach_W: Array,
    settings: TouchSettings,
) -> Array:
    """Rating (m,) of the chosen vertices by the strategy of the settings."""
    if settings.strategy == "gp_variance":
        return surface.variance[chosen]
    if settings.strategy == "random":
        return np.random.default_rng([settings.seed, len(contacts)]).random(len(chosen))
    p, n, lengths = surface.vertices[chosen], surface.normals[chosen], arc_length(curves)
    hidden = np.maximum(-facing_camera(surface, view)[chosen], 0.0) ** settings.hidden_power
    if len(contacts):
        return hidden * igef(p, n, contacts.p_WC, lengths, approach_W, settings.igef).product
    seen = view.p_WO[farthest_points(view.p_WO, settings.seen_points)]
    return hidden * igef(p, n, seen, lengths, approach_W, settings.igef_of_view).product


def _require_known(settings: TouchSettings) -> None:
    if settings.strategy not in STRATEGIES:
        raise UnknownName("strategy", settings.strategy, STRATEGIES)
    if settings.departure not in DEPARTURES:
        raise UnknownName("departure", settings.departure, DEPARTURES)
