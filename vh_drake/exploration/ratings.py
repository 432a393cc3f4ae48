r"""Ratings of candidate touches (section 3.3.2), each a function over all candidates.

.. math:: \Psi = \Psi_1 \Psi_2 \Psi_3 \Psi_4 \qquad (3.68)

Symbols: candidates s (m, 3) with outward normals (m, 3), contacts c (k, 3).
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.distance import cdist

from vh_drake.types import Array


@dataclass(frozen=True)
class IgefSettings:
    """Parameters of the information gain estimation function (the thesis gives no values)."""

    sigma1_m: float = 0.15
    mu3_m: float = 0.04
    sigma3_m: float = 0.005
    sigma_alpha: float = 1.0


@dataclass(frozen=True, eq=False)
class IgefRating:
    """The four metrics of every candidate, each (m,)."""

    uncertainty: Array  # Ψ1
    locality: Array  # Ψ2
    travel: Array  # Ψ3 [1/m]
    rotation: Array  # Ψ4

    @property
    def product(self) -> Array:
        """Ψ of eq. 3.68, (m,)."""
        return self.uncertainty * self.locality * self.travel * self.rotation


def uncertainty(p: Array, p_contacts: Array, *, sigma1_m: float) -> Array:
    """Ψ1: 0 at a contact, 1 far from all (eq. 3.61, 3.63); 1 without contacts."""
    if len(p_contacts) == 0:
        return np.ones(len(p))
    nearest = cdist(p, p_contacts).min(axis=1)
    psi: Array = 1.0 - np.exp(-(nearest**2) / sigma1_m**2)
    return psi


def locality(p: Array, p_contacts: Array, *, mu3_m: float, sigma3_m: float) -> Array:
    """Ψ2: how many contacts lie at about the distance μ3 (eq. 3.62, 3.64); 1 without contacts."""
    if len(p_contacts) == 0:
        return np.ones(len(p))
    distances = cdist(p, p_contacts)
    psi: Array = np.exp(-((distances - mu3_m) ** 2) / sigma3_m**2).sum(axis=1)
    return psi


def travel(lengths: Array) -> Array:
    """Ψ3: the inverse of the path's length (eq. 3.65 as corrected) [1/m]."""
    psi: Array = 1.0 / np.maximum(lengths, 1e-6)
    return psi


def rotation(approach_W: Array, n: Array, *, sigma_alpha: float) -> Array:
    """Ψ4: 1 where the fingertip need not turn (eq. 3.67 as corrected).

    With α between approach axis and inward normal, 2 sin²(α/2) = 1 - cos α.
    """
    psi: Array = np.exp(-(1.0 + n @ approach_W) / sigma_alpha**2)
    return psi


def igef(
    p: Array,
    n: Array,
    p_contacts: Array,
    lengths: Array,
    approach_W: Array,
    settings: IgefSettings,
) -> IgefRating:
    """Rate candidates by all four metrics (Algorithm 3).

    Args:
        p: (m, 3) candidates [m].
        n: (m, 3) outward normals there.
        p_contacts: (k, 3) contacts [m].
        lengths: (m,) lengths of the paths to the candidates [m].
        approach_W: (3,) approach axis of the fingertip now.
        settings: parameters.
    """
    s = settings
    return IgefRating(
        uncertainty(p, p_contacts, sigma1_m=s.sigma1_m),
        locality(p, p_contacts, mu3_m=s.mu3_m, sigma3_m=s.sigma3_m),
        travel(lengths),
        rotation(approach_W, n, sigma_alpha=s.sigma_alpha),
    )
