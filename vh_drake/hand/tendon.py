r"""Underactuated closing in free space: one tendon, many sprung joints.

A motor pulls its fingers through an equalising pulley, so that every finger's tendon
carries the same force F, and every joint has the constant lever R. With the torsion spring
of eq. 4.14, pretensioned by θ_0, equilibrium (eq. 4.9 to 4.11) is

.. math:: R F = K_i (θ_i + θ_{0,i}), \quad 0 ≤ θ_i ≤ θ_{max,i}

so that each joint angle is a clipped line in F. The motor's travel is the mean over its
fingers of the tendon shortening Σ R θ_i (eq. 4.15, 4.16), which grows with F and is
piecewise linear: it is inverted exactly at its breakpoints.
"""

import dataclasses as dc
from functools import cached_property

import numpy as np

from vh_drake.errors import BadInput
from vh_drake.types import Array


@dc.dataclass(frozen=True, eq=False)
class SprungJoints:
    """The joints that one motor closes.

    Symbols: K `stiffness` [N m/rad], θ_0 `preload` [rad], θ_max `upper` [rad]; all (n,).
    """

    stiffness: Array
    preload: Array
    upper: Array

    def __post_init__(self) -> None:
        if not (np.all(self.stiffness > 0) and np.all(self.upper > 0)):
            raise BadInput(
                f"joints need positive spring stiffness and range; got stiffness "
                f"{self.stiffness} N m/rad and range {self.upper} rad"
            )

    def angles_at_torque(self, torque: Array) -> Array:
        """Joint angles (..., n) [rad] where each joint's tendon torque R F is given [N m]."""
        free = np.asarray(torque)[..., None] / self.stiffness - self.preload
        # Faster than np.clip, which a closing hand calls in every period.
        return np.minimum(np.maximum(free, 0.0), self.upper)

    def angles_at_fraction(self, fraction: Array | float) -> Array:
        """Joint angles (..., n) [rad] where a fraction 0..1 of the whole travel is pulled.

        Below 0 and above 1 the joints rest at their stops. The lever cancels, as it is the
        same in all joints.
        """
        travels, torques = self._breakpoints
        # Beyond both ends np.interp gives the value at the end.
        return self.angles_at_torque(np.asarray(np.interp(fraction, travels, torques)))

    @cached_property
    def _breakpoints(self) -> tuple[Array, Array]:
        """Fractions of the travel, from 0 to 1, at which joints start or stop, and torques."""
        starts = self.stiffness * self.preload
        stops = self.stiffness * (self.preload + self.upper)
        torques = np.unique(np.concatenate([starts, stops]))
        return self.angles_at_torque(torques).sum(axis=-1) / self.upper.sum(), torques
