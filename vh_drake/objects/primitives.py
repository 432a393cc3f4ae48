"""Exact shapes that stand in for a mesh in contact where an object is one."""

from dataclasses import dataclass


@dataclass(frozen=True)
class BoxShape:
    """A box about its centre, sides along the axes of the object."""

    size: tuple[float, float, float]  # [m]
    center: tuple[float, float, float] = (0.0, 0.0, 0.0)  # p_OP [m]


@dataclass(frozen=True)
class CylinderShape:
    """A cylinder about its centre, along z of the object."""

    radius: float  # [m]
    length: float  # [m]
    center: tuple[float, float, float] = (0.0, 0.0, 0.0)  # p_OP [m]


@dataclass(frozen=True)
class SphereShape:
    """A sphere."""

    radius: float  # [m]
    center: tuple[float, float, float] = (0.0, 0.0, 0.0)  # p_OP [m]


Primitive = BoxShape | CylinderShape | SphereShape
