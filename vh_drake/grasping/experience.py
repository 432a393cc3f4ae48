r"""Learning from failures within a trial (section 5.2).

A grasp like one that failed is worth less: its score is multiplied by

.. math:: \prod_k \left(1 - e^{-\|p - p_k\|^2 / \sigma_p^2 - \phi_k^2 / \sigma_\phi^2}\right)

over the failed grasps k of the same motion, with the distance of the hand's positions and the
angle :math:`\phi_k` between its orientations.
"""

from collections.abc import Sequence

import numpy as np

from vh_drake.types import Array, Candidates

POSITION_M, ANGLE_RAD = 0.04, 0.6


def discounts(candidates: Candidates, failed: Sequence[tuple[Array, str]]) -> Array:
    """Factors 0..1 (n,) on the candidates' scores.

    Args:
        candidates: what is to be ranked.
        failed: hand poses (4, 4) and motions that did not hold the object, where it lies now.
    """
    factor = np.ones(len(candidates))
    for X_WH, motion in failed:
        distance = np.linalg.norm(candidates.X_WH[:, :3, 3] - X_WH[:3, 3], axis=1)
        trace = np.einsum("nij,ij->n", candidates.X_WH[:, :3, :3], X_WH[:3, :3])
        angle = np.arccos(np.clip((trace - 1.0) / 2.0, -1.0, 1.0))
        like = np.exp(-((distance / POSITION_M) ** 2) - (angle / ANGLE_RAD) ** 2)
        same = np.array([name == motion for name in candidates.motion])
        factor *= np.where(same, 1.0 - like, 1.0)
    return factor
