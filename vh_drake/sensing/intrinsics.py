"""The pinhole camera that turns pixels into rays."""

import math
from dataclasses import dataclass

import numpy as np

from vh_drake.errors import BadInput
from vh_drake.types import Array


@dataclass(frozen=True)
class Intrinsics:
    """A pinhole without distortion; optical frame C has +z forward, +x right, +y down.

    Pixel (u, v) sees along ((u - cx) / fx, (v - cy) / fy, 1); its centre has integer u and v.
    """

    width: int  # [pixel]
    height: int  # [pixel]
    fx: float  # focal length [pixel]
    fy: float
    cx: float  # principal point [pixel]
    cy: float

    @classmethod
    def from_fov(cls, width: int, height: int, fov_y_rad: float) -> "Intrinsics":
        """Square pixels, the principal point in the middle.

        Raises:
            BadInput: the image is empty or the angle lies outside (0, pi).
        """
        if width < 1 or height < 1 or not 0.0 < fov_y_rad < math.pi:
            raise BadInput(
                f"a camera of {width} x {height} pixels with fov_y_rad={fov_y_rad:g} sees "
                "nothing; give a size above 0 and an angle between 0 and pi"
            )
        focal = 0.5 * height / math.tan(0.5 * fov_y_rad)
        return cls(width, height, focal, focal, 0.5 * (width - 1), 0.5 * (height - 1))

    def rays(self) -> Array:
        """Directions (height, width, 3) in C with z = 1, so that a point is depth times ray."""
        u = (np.arange(self.width) - self.cx) / self.fx
        v = (np.arange(self.height) - self.cy) / self.fy
        rays = np.ones((self.height, self.width, 3))
        rays[..., 0] = u[None, :]
        rays[..., 1] = v[:, None]
        return rays

    def frustum(self) -> Array:
        """Inward unit normals (4, 3) in C of the planes that bound the view.

        Order: left, right, top, bottom; each plane runs through the optical centre and half
        a pixel outside the outermost pixel centres.
        """
        left, right = (-0.5 - self.cx) / self.fx, (self.width - 0.5 - self.cx) / self.fx
        top, bottom = (-0.5 - self.cy) / self.fy, (self.height - 0.5 - self.cy) / self.fy
        normals = np.array([[1, 0, -left], [-1, 0, right], [0, 1, -top], [0, -1, bottom]])
        unit: Array = normals / np.linalg.norm(normals, axis=1, keepdims=True)
        return unit
