r"""How a camera whose pose is known badly is corrected by the table.

The robot knows its table: a seen plane that leans or lies higher tells three of the six numbers
of the hand-eye error. What is left moves all points alike: a turn about the vertical, which
shifts the object by :math:`\theta r` sideways at a distance :math:`r`, and a shift along the
table. How large both may be is known from how large the errors were that the table told.
"""

import dataclasses as dc

import numpy as np
from scipy.spatial.transform import Rotation

from vh_drake.types import Array, Cloud, ObjectView, Plane

_SHIFT_M_RAD = 0.13  # of each axis, for each axis's turn: as 10 mm with 3 degrees


@dc.dataclass(frozen=True)
class TableError:
    """How a seen table differs from the known one."""

    turn: Array  # (3,) rotation vector about the camera that takes the seen normal to the known
    rise_m: float  # of the seen table over the known one, after the turn

    @property
    def tilt_rad(self) -> float:
        """Angle between the two planes."""
        return float(np.linalg.norm(self.turn))


def table_error(seen: Plane, known: Plane, p_WCamera: Array) -> TableError:
    """What a turn about the camera and a rise explain of a seen plane."""
    axis = np.cross(seen.normal, known.normal)
    sine = float(np.linalg.norm(axis))
    turn = axis / max(sine, 1e-12) * np.arctan2(sine, seen.normal @ known.normal)
    # The turn keeps the distance between camera and plane.
    return TableError(turn, float(known.height(p_WCamera) - seen.height(p_WCamera)))


def corrected(cloud: Cloud, error: TableError, known: Plane) -> Cloud:
    """The cloud as a camera sees it that sees the table where it is."""
    R = Rotation.from_rotvec(error.turn).as_matrix()
    p_WCamera = cloud.p_WCamera - error.rise_m * known.normal
    p_WC = (cloud.p_WC - cloud.p_WCamera) @ R.T + p_WCamera
    return Cloud(p_WC, p_WCamera, cloud.n_WFrustum @ R.T)


def left_covariance(error: TableError, known: Plane, p_WCamera: Array, p_WO: Array) -> Array:
    """Covariance (3, 3) [m²] of where an object is along the table, after the correction.

    The turn about the vertical is as large as one about another axis; the shift along the table
    as large as the rise, and as what comes with such a tilt.

    Args:
        error: that the table told.
        known: the table.
        p_WCamera: (3,) optical centre [m].
        p_WO: (3,) middle of the object [m].
    """
    sideways = np.cross(known.normal, p_WO - p_WCamera)  # as long as they are apart, level
    level = np.eye(3) - np.outer(known.normal, known.normal)
    turned = 0.5 * error.tilt_rad**2 * np.outer(sideways, sideways)
    shifted = 0.5 * (error.rise_m**2 + (_SHIFT_M_RAD * error.tilt_rad) ** 2) * level
    covariance: Array = turned + shifted
    return covariance


def moved(view: ObjectView, shift_W: Array, covariance: Array) -> ObjectView:
    """The view as a camera has it that is elsewhere by a shift (3,) [m]."""
    return dc.replace(
        view,
        p_WO=view.p_WO + shift_W,
        p_WCamera=view.p_WCamera + shift_W,
        shift_covariance=covariance,
    )
