"""The embedded library: everyday objects as parametric shapes, with real sizes and masses.

The kinds are those of the thesis's two object sets (figures 4.5 and 4.21) and a few more.
Objects stand upright on z = 0 of their frame, about its z axis, unless they are tools,
which lie. Lengths in metres, masses in kg.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from vh_drake.errors import UnknownName
from vh_drake.geometry.meshes import TriMesh
from vh_drake.objects import lathe
from vh_drake.objects.distance_fields import (
    chain,
    cone_capsule,
    cut,
    mesh_field,
    ring,
    rod,
    rounded_box,
    stretched,
    union,
)
from vh_drake.objects.model import ObjectModel, make_object
from vh_drake.objects.primitives import BoxShape, CylinderShape, Primitive, SphereShape


@dataclass(frozen=True)
class _Design:
    """How an object is made."""

    mass_kg: float
    make_mesh: Callable[[], TriMesh]
    primitive: Primitive | None = None


def library_names() -> list[str]:
    """Names of all embedded objects, sorted."""
    return sorted(_DESIGNS)


@cache
def library_object(name: str) -> ObjectModel:
    """Build an embedded object; the same bytes on every call.

    Raises:
        UnknownName: no such object.
    """
    if name not in _DESIGNS:
        raise UnknownName("object", name, library_names())
    design = _DESIGNS[name]
    return make_object(
        name, design.make_mesh(), design.mass_kg, mass_source="library", primitive=design.primitive
    )


def _box(mass_kg: float, x: float, y: float, z: float) -> _Design:
    primitive = BoxShape((x, y, z), (0.0, 0.0, z / 2))
    return _Design(mass_kg, lambda: lathe.box((x, y, z)), primitive)


def _cylinder(mass_kg: float, radius: float, length: float) -> _Design:
    primitive = CylinderShape(radius, length, (0.0, 0.0, length / 2))
    return _Design(mass_kg, lambda: lathe.cylinder(radius, length), primitive)


def _sphere(mass_kg: float, radius: float) -> _Design:
    primitive = SphereShape(radius, (0.0, 0.0, radius))
    return _Design(mass_kg, lambda: lathe.sphere(radius), primitive)


def _apple() -> TriMesh:
    """A ball with dimples at stem and blossom."""
    t = np.linspace(-np.pi / 2, np.pi / 2, 25)
    radius = 0.0375 * np.cos(t) * (1 + 0.08 * np.sin(t))
    z = 0.036 * np.sin(t) * (1 - 0.35 * np.abs(np.sin(t)) ** 12)
    radius[[0, -1]] = 0.0
    return lathe.lathe(list(zip(radius, z - z.min(), strict=True)))


def _bottle() -> TriMesh:
    """A drinking bottle: body, shoulder, neck, cap."""
    return lathe.lathe(
        [
            (0, 0),
            (0.029, 0),
            (0.032, 0.004),
            (0.032, 0.125),
            (0.029, 0.145),
            (0.018, 0.165),
            (0.0135, 0.172),
            (0.0135, 0.183),
            (0.015, 0.184),
            (0.015, 0.202),
            (0, 0.202),
        ]
    )


def _shampoo() -> TriMesh:
    """An oval bottle with a wide cap."""
    return lathe.lathe(
        [
            (0, 0),
            (0.030, 0),
            (0.034, 0.005),
            (0.036, 0.07),
            (0.034, 0.12),
            (0.026, 0.142),
            (0.022, 0.146),
            (0.021, 0.175),
            (0, 0.175),
        ],
        flatten=0.6,
    )


def _flashlight() -> TriMesh:
    """A hand lamp that stands on its tail."""
    return lathe.lathe(
        [
            (0, 0),
            (0.016, 0),
            (0.017, 0.003),
            (0.017, 0.125),
            (0.0255, 0.145),
            (0.0255, 0.185),
            (0, 0.185),
        ]
    )


def _spray_bottle() -> TriMesh:
    """An oval body, a neck, and a head with nozzle and trigger."""
    body = stretched(cone_capsule((0, 0, 0.035), (0, 0, 0.125), 0.042, 0.034), (1, 0.75, 1))
    foot = rounded_box((0, 0, 0.1), (0.12, 0.12, 0.2), 0.002)  # cuts the body flat below
    neck = rod((0, 0, 0.14), (0, 0, 0.2), 0.0125)
    head = rounded_box((0.016, 0, 0.213), (0.085, 0.026, 0.034), 0.008)
    trigger = chain(
        [(0.040, 0, 0.205), (0.036, 0, 0.178), (0.043, 0, 0.155)], [0.007, 0.0055, 0.005]
    )
    trimmed = cut(body, lambda p: -foot(p))
    return mesh_field(
        union(trimmed, neck, head, trigger, blend=0.006),
        (-0.055, -0.045, -0.01),
        (0.07, 0.045, 0.24),
    )


def _mug() -> TriMesh:
    """A hollow mug with a handle."""
    outer = rod((0, 0, 0), (0, 0, 0.09), 0.041, edge=0.0015)
    inner = rod((0, 0, 0.006), (0, 0, 0.13), 0.037)
    handle = stretched(ring((0.044, 0, 0.036), 0.022, 0.0055), (1, 1, 1.25))
    return mesh_field(
        cut(union(outer, handle, blend=0.004), inner), (-0.05, -0.05, -0.01), (0.08, 0.05, 0.1)
    )


def _banana() -> TriMesh:
    """A curved fruit that lies on its side."""
    angles = np.linspace(-0.95, 0.95, 13)
    points = [(float(0.105 * np.sin(a)), float(0.105 * np.cos(a)) - 0.085, 0.0) for a in angles]
    profile = np.interp(np.abs(angles), [0, 0.55, 0.85, 0.95], [0.0185, 0.0165, 0.0085, 0.0065])
    return mesh_field(
        chain(points, profile.tolist(), blend=0.004), (-0.11, -0.06, -0.03), (0.11, 0.05, 0.03)
    )


def _power_drill() -> TriMesh:
    """Motor, chuck, bit, slanted grip and battery, standing on the battery."""
    motor = rod((-0.055, 0, 0.165), (0.065, 0, 0.165), 0.0275, edge=0.006)
    chuck = cone_capsule((0.07, 0, 0.165), (0.1, 0, 0.165), 0.019, 0.0135)
    bit = rod((0.1, 0, 0.165), (0.135, 0, 0.165), 0.004)
    grip = chain([(0.0, 0, 0.15), (-0.018, 0, 0.045)], [0.0195, 0.0185])
    battery = rounded_box((-0.012, 0, 0.0225), (0.1, 0.062, 0.045), 0.007)
    trigger = rounded_box((0.022, 0, 0.125), (0.022, 0.016, 0.03), 0.005)
    return mesh_field(
        union(motor, chuck, bit, grip, battery, trigger, blend=0.006),
        (-0.08, -0.045, -0.01),
        (0.15, 0.045, 0.21),
    )


def _hammer() -> TriMesh:
    """A claw-less hammer that lies on its side."""
    handle = stretched(cone_capsule((-0.19, 0, 0), (0.085, 0, 0), 0.0165, 0.0115), (1, 1, 0.8))
    head = rounded_box((0.092, -0.005, 0), (0.025, 0.075, 0.025), 0.003)
    face = rod((0.092, 0.028, 0), (0.092, 0.055, 0), 0.0145, edge=0.002)
    return mesh_field(
        union(handle, head, face, blend=0.003), (-0.22, -0.06, -0.03), (0.12, 0.07, 0.03)
    )


def _screwdriver() -> TriMesh:
    """A ribless grip and a shaft, lying along x."""
    grip = chain(
        [(-0.085, 0, 0), (-0.04, 0, 0), (0.0, 0, 0)], [0.0145, 0.0165, 0.0115], blend=0.002
    )
    shaft = rod((0, 0, 0), (0.105, 0, 0), 0.004)
    return mesh_field(
        union(grip, shaft, blend=0.003), (-0.11, -0.025, -0.025), (0.115, 0.025, 0.025)
    )


def _pliers() -> TriMesh:
    """Two curved handles, a joint and jaws, lying flat."""
    jaws = chain([(0.03, 0, 0), (0.075, 0, 0)], [0.0145, 0.006])
    sides = [
        chain(
            [(0.03, 0, 0), (0.0, s * 0.016, 0), (-0.05, s * 0.028, 0), (-0.11, s * 0.022, 0)],
            [0.012, 0.0085, 0.0085, 0.0075],
            blend=0.003,
        )
        for s in (-1.0, 1.0)
    ]
    flat = stretched(union(jaws, *sides, blend=0.003), (1, 1, 0.75))
    return mesh_field(flat, (-0.13, -0.05, -0.02), (0.09, 0.05, 0.02))


def _aluminum_profile() -> TriMesh:
    """A piece of 40 mm construction profile with its four grooves, upright."""
    bar = rounded_box((0, 0, 0.08), (0.04, 0.04, 0.16), 0.0015)
    grooves = [
        rounded_box(
            (x * 0.02, y * 0.02, 0.08),
            (0.0085 + abs(x) * 0.0155, 0.0085 + abs(y) * 0.0155, 0.3),
            0.001,
        )
        for x, y in ((1, 0), (-1, 0), (0, 1), (0, -1))
    ]
    return mesh_field(cut(bar, *grooves), (-0.03, -0.03, -0.01), (0.03, 0.03, 0.17))


def _multimeter() -> TriMesh:
    """A rounded case that lies on its back."""
    case = rounded_box((0, 0, 0.02), (0.15, 0.074, 0.036), 0.009)
    knob = rod((-0.015, 0, 0.03), (-0.015, 0, 0.045), 0.0175, edge=0.002)
    return mesh_field(union(case, knob, blend=0.003), (-0.09, -0.05, -0.01), (0.09, 0.05, 0.06))


def _cutter() -> TriMesh:
    """A snap-off knife with a slim nose, lying flat."""
    grip = rounded_box((-0.02, 0, 0), (0.12, 0.03, 0.02), 0.007)
    nose = rounded_box((0.05, 0.002, 0), (0.05, 0.018, 0.011), 0.003)
    return mesh_field(union(grip, nose, blend=0.004), (-0.095, -0.03, -0.02), (0.09, 0.03, 0.02))


_DESIGNS = {
    "aluminum_profile": _Design(0.27, _aluminum_profile),
    "apple": _Design(0.180, _apple),
    "ball": _sphere(0.041, 0.0277),
    "banana": _Design(0.120, _banana),
    "bottle": _Design(0.350, _bottle),
    "can": _cylinder(0.349, 0.0335, 0.101),
    "candy_cylinder": _cylinder(0.075, 0.026, 0.150),
    "cereal_box": _box(0.400, 0.145, 0.055, 0.205),
    "cutter": _Design(0.090, _cutter),
    "flashlight": _Design(0.260, _flashlight),
    "fruit_drink": _box(0.215, 0.048, 0.038, 0.118),
    "gelatin_box": _box(0.097, 0.085, 0.073, 0.028),
    "hammer": _Design(0.550, _hammer),
    "marshmallow_box": _box(0.250, 0.190, 0.110, 0.058),
    "mug": _Design(0.240, _mug),
    "multimeter": _Design(0.320, _multimeter),
    "pliers": _Design(0.220, _pliers),
    "power_drill": _Design(0.895, _power_drill),
    "screw_box": _box(0.350, 0.100, 0.060, 0.040),
    "screwdriver": _Design(0.097, _screwdriver),
    "shampoo": _Design(0.280, _shampoo),
    "spray_bottle": _Design(0.330, _spray_bottle),
    "sugar_box": _box(0.514, 0.092, 0.045, 0.176),
}
