"""What an explorer knows, and how it learns from a touch."""

import dataclasses as dc

import numpy as np

from vh_drake.exploration.strategies import Igef, Strategy
from vh_drake.gpis.kernels import Kernel, ThinPlate
from vh_drake.gpis.observations import Observations, surface_observations
from vh_drake.gpis.posterior import Posterior, fit
from vh_drake.types import Array, ContactSet, Immutable


@dc.dataclass(frozen=True)
class ExplorerSettings:
    """How the next touch is chosen and learnt from; the same for every strategy."""

    strategy: Strategy = dc.field(default_factory=Igef)
    candidate_radius_m: float = 0.05  # R_0 around the last contact; inf for the whole surface
    departure: str = "contact_normal"  # or inverse_velocity, eq. 3.71
    kernel: Kernel = dc.field(default_factory=ThinPlate)
    contact_std_m: float = 0.0005
    normal_std: float = 0.03
    spacing_m: float = 0.005  # between candidates
    margin_m: float = 0.05  # of candidates beyond the box around the contacts
    # Candidates nearer to a contact are left out while there are others; where all within the
    # candidate radius are so near, or explored, the radius grows, and then the margin.
    fresh_m: float = 0.02
    # So are those that lie farther outside the tangent plane of a contact within `bulge_within_m`,
    # where the estimate hangs over what was touched.
    bulge_m: float = 0.01
    bulge_within_m: float = 0.04
    clearance_m: float = 0.003  # of the tip's centre over the estimate, on a planned curve
    barren_m: float = 0.01  # from an old contact, within which a new one teaches little
    set_aside_m: float = 0.015  # around a target that led to such a barren touch
    most_barren: int = 3  # barren touches in a row, after which the tip takes a way around
    cavity_m: float = 0.02  # contacts so near to the last one are kept off on a way around
    leave_m: float = 0.05  # how far such a way leads at least; more after each barren touch more
    least_apart_m: float = 0.001  # of contacts that enter the estimate
    tip_radius_m: float = 0.005
    missed_after_m: float = 0.005  # Δm, how far the tip goes on behind a target
    explored_radius_m: float = 0.02  # r_E, what is nearer to a contact counts as explored


@dc.dataclass(frozen=True, eq=False)
class Known(Immutable):
    """What an explorer knows; expressed in the world frame W."""

    posterior: Posterior
    contacts: ContactSet
    p_WTip: Array  # (3,) centre of the fingertip [m]
    arrival_W: Array  # (3,) unit direction in which it came
    approach_W: Array  # (3,) unit approach axis
    set_aside: Array  # (k, 3) targets that led to barren touches [m]
    barren: int  # such touches in a row


@dc.dataclass(frozen=True, eq=False)
class Arrival(Immutable):
    """How the fingertip came to a contact."""

    p_WTip: Array  # (3,) its centre [m]
    arrival_W: Array  # (3,) unit direction in which it came
    approach_W: Array  # (3,) unit approach axis
    p_WC: Array  # (3,) the contact [m]
    n_WC: Array  # (3,) outward unit normal there


def after_first(arrival: Arrival, settings: ExplorerSettings) -> Known:
    """What is known after the first contact."""
    return Known(
        fit(settings.kernel, _observed(arrival, settings)),
        ContactSet(arrival.p_WC[None], arrival.n_WC[None]),
        arrival.p_WTip,
        arrival.arrival_W,
        arrival.approach_W,
        np.zeros((0, 3)),
        0,
    )


def after_touch(known: Known, target: Array, arrival: Arrival, settings: ExplorerSettings) -> Known:
    """What is known after one touch more, which was meant for a target (3,) [m].

    Raises:
        IllConditionedKernel: the kernel can't hold the contacts.
    """
    nearest = float(np.linalg.norm(known.contacts.p_WC - arrival.p_WC, axis=1).min())
    posterior = known.posterior
    if nearest >= settings.least_apart_m:
        posterior = posterior.append(_observed(arrival, settings))
    barren = nearest < settings.barren_m
    return Known(
        posterior,
        known.contacts.with_contact(arrival.p_WC, arrival.n_WC),
        arrival.p_WTip,
        arrival.arrival_W,
        arrival.approach_W,
        np.vstack([known.set_aside, target]) if barren else known.set_aside,
        known.barren + 1 if barren else 0,
    )


def _observed(arrival: Arrival, s: ExplorerSettings) -> Observations:
    return surface_observations(
        arrival.p_WC[None],
        arrival.n_WC[None],
        value_std_m=s.contact_std_m,
        gradient_std=s.normal_std,
    )
