"""Strategies that choose the next touch, behind one interface: each rates candidates.

=====================  ========================================================================
name                   rates by
=====================  ========================================================================
igef                   Ψ1 Ψ2 Ψ3 Ψ4, information gain against travel and rotation (eq. 3.68)
gp_variance            variance of the Gaussian process (section 3.3.1, eq. 2.1)
random                 chance
uncertainty_cost       variance less a share of the path's length (Matsubara & Shibata, eq. 2.3)
potential_field        rise of a field of unexplored space and contacts (Bierbaum, 2.1.2)
=====================  ========================================================================
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Protocol

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

from vh_drake.exploration.ratings import IgefRating, IgefSettings, igef
from vh_drake.exploration.trajectory import approach_curves, arc_length
from vh_drake.gpis.posterior import Posterior
from vh_drake.types import Array, ContactSet, IntArray


@dataclass(frozen=True, eq=False)
class Situation:
    """What is known before a touch; frames and symbols as in `vh_drake.exploration.trajectory`.

    Attributes:
        p: (m, 3) candidates on the estimated surface [m].
        n: (m, 3) outward unit normals there.
        contacts: all touches so far, at least one.
        posterior: of the potential.
        p_WTip: (3,) centre of the fingertip [m].
        departure_W: (3,) unit direction in which it leaves.
        approach_W: (3,) unit approach axis of the fingertip.
        tip_radius_m: its radius; it touches a candidate while its centre is that far outside.
        explored_radius_m: what lies nearer to a contact counts as explored.
        seed: of choices by chance.
    """

    p: Array
    n: Array
    contacts: ContactSet
    posterior: Posterior
    p_WTip: Array
    departure_W: Array
    approach_W: Array
    tip_radius_m: float
    explored_radius_m: float
    seed: int

    def curves_to(self, chosen: IntArray) -> Array:
        """Control points (k, 4, 3) of the curves to some candidates [m]."""
        p_WT = self.p[chosen] + self.tip_radius_m * self.n[chosen]
        return approach_curves(self.p_WTip, self.departure_W, p_WT, self.n[chosen])

    @cached_property
    def lengths(self) -> Array:
        """(m,) lengths of the curves to all candidates [m]."""
        return arc_length(self.curves_to(np.arange(len(self.p))))

    @cached_property
    def nearest_contact_m(self) -> Array:
        """(m,) distance of every candidate to the nearest contact [m]."""
        distance: Array = cKDTree(self.contacts.p_WC).query(self.p)[0]
        return distance


class Strategy(Protocol):
    """Rates candidates."""

    def rate(self, situation: Situation) -> Array:
        """A number for each candidate (m,); the highest is touched."""


@dataclass(frozen=True)
class Igef:
    """Information gain estimation function (section 3.3.2)."""

    settings: IgefSettings = field(default_factory=IgefSettings)

    def metrics(self, s: Situation) -> IgefRating:
        """Ψ1 to Ψ4 of every candidate."""
        return igef(s.p, s.n, s.contacts.p_WC, s.lengths, s.approach_W, self.settings)

    def rate(self, situation: Situation) -> Array:
        """Ψ (m,), eq. 3.68."""
        return self.metrics(situation).product


@dataclass(frozen=True)
class GpVariance:
    """Variance of the Gaussian process (eq. 2.1, 3.57).

    The variance is smooth, so that it is computed at few candidates first, and then around the
    best of these; the others are rated below all that were looked at.
    """

    first: int = 300
    around: int = 3
    around_m: float = 0.01

    def rate(self, situation: Situation) -> Array:
        """Variance of the potential (m,) [m²], -inf where it was not computed."""
        s = situation
        rating = np.full(len(s.p), -np.inf)
        some = np.arange(0, len(s.p), len(s.p) // self.first + 1)
        rating[some] = s.posterior.variance(s.p[some])
        best = s.p[some[np.argsort(-rating[some], kind="stable")[: self.around]]]
        near = np.flatnonzero(cdist(s.p, best).min(axis=1) < self.around_m)
        rating[near] = s.posterior.variance(s.p[near])
        return rating


@dataclass(frozen=True)
class Facing:
    r"""How differently a place faces from the contacts around it.

    .. math:: 1 - \max_j (n \cdot n_j) \exp(-|p - c_j|^2 / w^2)

    Where an estimate is explored all over though the object goes on, as at the root of a handle,
    it closes over the part that is missing, and this end faces as no contact nearby does.
    """

    width_m: float = 0.04  # w

    def rate(self, situation: Situation) -> Array:
        """0 at a contact, up to 2 where the nearest contacts face the other way (m,)."""
        s = situation
        apart = cdist(s.p, s.contacts.p_WC) / self.width_m
        alike = (s.n @ s.contacts.n_WC.T) * np.exp(-(apart**2))
        rating: Array = 1.0 - alike.max(axis=1)
        return rating


@dataclass(frozen=True)
class Random:
    """Chance: every candidate with the same probability."""

    def rate(self, situation: Situation) -> Array:
        """Numbers between 0 and 1 (m,) that the seed and the number of contacts decide."""
        rng = np.random.default_rng([situation.seed, len(situation.contacts)])
        return rng.random(len(situation.p))


@dataclass(frozen=True)
class UncertaintyCost:
    r"""Uncertainty less travel (Matsubara & Shibata 2017, eq. 2.3).

    .. math:: E(x) = \sigma(x) / \max \sigma - \theta \nu(x) / \max \nu
    """

    theta: float = 1.0
    most: int = 500

    def rate(self, situation: Situation) -> Array:
        """E (m,); -inf at the candidates beyond `most`, which are left out evenly."""
        s = situation
        some = np.arange(0, len(s.p), len(s.p) // self.most + 1)
        variance = s.posterior.variance(s.p[some])
        rating = np.full(len(s.p), -np.inf)
        gain = variance / max(float(variance.max()), 1e-300)
        rating[some] = gain - self.theta * s.lengths[some] / s.lengths.max()
        return rating


@dataclass(frozen=True)
class PotentialField:
    """Attraction by what is unexplored, repulsion by contacts (Bierbaum et al. 2008).

    Attractive sources fill the estimated bounding box on a grid and vanish once explored; contacts
    repel. A candidate is rated by how much the potential rises per metre of way, which is the
    charged particle's drive towards it.
    """

    spacing_m: float = 0.02
    beyond_m: float = 0.02  # of the box around the contacts
    repulsion: float = 1.0  # of a contact against one attractive source
    softening_m: float = 0.01  # keeps the potential finite at a source

    def rate(self, situation: Situation) -> Array:
        """Rise of the potential per metre (m,)."""
        s = situation
        sources = self._unexplored(s)
        here = self._potential(s.p_WTip[None], sources, s.contacts.p_WC)
        rise = self._potential(s.p, sources, s.contacts.p_WC) - here
        rating: Array = rise / np.maximum(s.lengths, 1e-6)
        return rating

    def _unexplored(self, s: Situation) -> Array:
        """Attractive sources (k, 3): nodes of the box that no contact explores."""
        p = s.contacts.p_WC
        low, high = p.min(axis=0) - self.beyond_m, p.max(axis=0) + self.beyond_m
        counts = np.ceil((high - low) / self.spacing_m - 1e-6).astype(int) + 1
        axes = [a + self.spacing_m * np.arange(k) for a, k in zip(low, counts, strict=True)]
        nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
        distance, _ = cKDTree(p).query(nodes)
        # Nodes lie exactly at this distance from the outermost contacts; rounding must not decide.
        unexplored: Array = nodes[distance > 1.001 * s.explored_radius_m]
        return unexplored

    def _potential(self, p: Array, sources: Array, contacts: Array) -> Array:
        attraction = (1.0 / (cdist(p, sources) + self.softening_m)).sum(axis=1)
        repulsion = (1.0 / (cdist(p, contacts) + self.softening_m)).sum(axis=1)
        potential: Array = attraction - self.repulsion * repulsion
        return potential
