"""The surface that touches alone suggest, growing contact by contact.

Example:
    >>> import numpy as np
    >>> first = ContactSurface.of(np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]))
    >>> second = first.append(np.array([0.03, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]))
    >>> len(first), len(second)
    (1, 2)
    >>> bool(abs(second.follow(margin_m=0.05).vertices[:, 2]).max() < 1e-6)
    True
"""

import math
from dataclasses import dataclass, field

import numpy as np

from vh_drake.errors import BadInput
from vh_drake.gpis.following import Sheet, follow_surface
from vh_drake.gpis.kernels import Kernel, ThinPlate
from vh_drake.gpis.observations import surface_observations
from vh_drake.gpis.posterior import Posterior, fit
from vh_drake.types import Array, Immutable


@dataclass(frozen=True)
class ContactNoise:
    """What is believed of every touch; gradients have no unit."""

    position_std_m: float = 0.0005
    normal_std: float = 0.05


@dataclass(frozen=True, eq=False)
class ContactSurface(Immutable):
    """A Gaussian process implicit surface on contacts with normals (section 3.2.2).

    It never changes: `append` gives the next one, in O(N²) for N contacts, and shares its factor.
    A strategy that looks ahead may append imagined contacts to one surface as often as it likes.

    Create it by `ContactSurface.of`.
    """

    noise: ContactNoise
    posterior: Posterior
    p_WC: Array  # (n, 3) contacts [m]
    n_WC: Array = field(repr=False)  # (n, 3) outward unit normals

    @classmethod
    def of(
        cls,
        p_WC: Array,
        n_WC: Array,
        *,
        kernel: Kernel | None = None,
        noise: ContactNoise | None = None,
    ) -> "ContactSurface":
        """The surface through first contacts.

        Args:
            p_WC: (n, 3) contacts, n at least 1 [m].
            n_WC: (n, 3) outward unit normals.
            kernel: by default a thin plate of radius 0.5 m, which suits contacts up to 0.41 m
                apart, with a prior standard deviation of one for gradients.
            noise: of every contact.

        Raises:
            BadInput: no contact, numbers that are not finite, or normals not of unit length.
            IllConditionedKernel: the kernel can't hold the contacts; the message names remedies.
        """
        noise = noise or ContactNoise()
        kernel = kernel or ThinPlate(0.5, 0.5 / math.sqrt(6.0))
        observations = surface_observations(
            *_checked(p_WC, n_WC), value_std_m=noise.position_std_m, gradient_std=noise.normal_std
        )
        posterior = fit(kernel, observations)
        return cls(noise, posterior, observations.p, observations.gradient)

    def __len__(self) -> int:
        return len(self.p_WC)

    def append(self, p_WC: Array, n_WC: Array) -> "ContactSurface":
        """The surface with one contact more, or several: (3,) or (n, 3) places [m] and normals.

        Raises:
            BadInput: numbers that are not finite, or normals not of unit length.
            IllConditionedKernel: as `of`; this surface stays usable.
        """
        observations = surface_observations(
            *_checked(p_WC, n_WC),
            value_std_m=self.noise.position_std_m,
            gradient_std=self.noise.normal_std,
        )
        posterior = self.posterior.append(observations)
        return ContactSurface(
            self.noise, posterior, posterior.observations.p, posterior.observations.gradient
        )

    def follow(self, *, spacing_m: float = 0.005, margin_m: float = 0.01) -> Sheet:
        """Vertices, outward normals and triangles of the surface, see `follow_surface`.

        Args:
            spacing_m: between vertices [m].
            margin_m: how far the surface may go beyond the box around the contacts [m]; the
                default keeps spurious sheets away. For candidates of a next touch give what the
                fingertip may reach, such as 0.03.
        """
        return follow_surface(self.posterior, self.p_WC, spacing_m=spacing_m, margin_m=margin_m)

    def variance(self, p_W: Array) -> Array:
        """Posterior variance of the potential (m,) at points (m, 3) [m²], eq. 3.57."""
        return self.posterior.variance(p_W)


def _checked(p: Array, n: Array) -> tuple[Array, Array]:
    p, n = np.asarray(p, float).reshape(-1, 3), np.asarray(n, float).reshape(-1, 3)
    if len(p) != len(n):
        raise BadInput(f"{len(p)} contacts with {len(n)} normals; give each contact its normal")
    length = np.einsum("ij,ij->i", n, n)
    if not (np.isfinite(p).all() and (np.abs(length - 1.0) < 0.02).all()):
        raise BadInput("contacts hold numbers that are not finite, or normals not of unit length")
    return p, n
