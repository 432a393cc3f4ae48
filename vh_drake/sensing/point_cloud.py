"""From a depth image to points in the world."""

import numpy as np
from numpy.typing import NDArray

from vh_drake.errors import BadInput
from vh_drake.sensing.intrinsics import Intrinsics
from vh_drake.types import Array, Cloud


def cloud_from_depth(depth: NDArray[np.floating], intrinsics: Intrinsics, X_WC: Array) -> Cloud:
    """Back-projects every pixel that measured something.

    Args:
        depth: (height, width) distance along the optical axis [m]; 0, negative, infinite
            and NaN pixels measured nothing and are dropped.
        intrinsics: the camera that took it.
        X_WC: (4, 4) pose of the optical frame C (+z forward, +y down) in W.

    Returns:
        The points, the optical centre and the bounds of the view, in W.

    Raises:
        BadInput: the image has another size than the camera's.
    """
    if depth.shape != (intrinsics.height, intrinsics.width):
        raise BadInput(
            f"depth image of shape {depth.shape} does not fit a camera of "
            f"{intrinsics.height} x {intrinsics.width} pixels"
        )
    measured = np.isfinite(depth) & (depth > 0.0)
    p_C = intrinsics.rays()[measured] * depth[measured, None].astype(float)
    R_WC, p_WC = X_WC[:3, :3], X_WC[:3, 3]
    return Cloud(p_C @ R_WC.T + p_WC, p_WC.copy(), intrinsics.frustum() @ R_WC.T)
