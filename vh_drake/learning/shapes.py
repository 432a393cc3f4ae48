"""Everyday shapes drawn at random, so that a metric learns from more than one can and one box.

A shape's name holds its kind and the number that draws it, such as "shape_lathe_07"; the same
name gives the same mesh. Lengths in metres; shapes stand on z = 0.
"""

from collections.abc import Callable, Mapping

import numpy as np

from vh_drake.errors import UnknownName
from vh_drake.geometry.meshes import TriMesh
from vh_drake.objects import lathe
from vh_drake.objects.distance_fields import (
    Field,
    ball,
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

Rng = np.random.Generator
_MARGIN_M = 0.01  # of the box in which a field is meshed


def shape_names(count: int) -> list[str]:
    """The first names, all kinds in turn."""
    kinds = list(_KINDS)
    return [f"shape_{kinds[i % len(kinds)]}_{i // len(kinds):02d}" for i in range(count)]


def shape_mesh(name: str) -> TriMesh:
    """The watertight mesh of a drawn shape.

    Raises:
        UnknownName: no such kind.
    """
    parts = name.split("_")
    if len(parts) != 3 or parts[0] != "shape" or parts[1] not in _KINDS or not parts[2].isdigit():
        raise UnknownName("shape", name, [f"shape_{kind}_00" for kind in _KINDS])
    return _KINDS[parts[1]](np.random.default_rng([list(_KINDS).index(parts[1]), int(parts[2])]))


def _box(rng: Rng) -> TriMesh:
    """A package, its edges sharp."""
    short, middle, tall = np.sort(rng.uniform([0.025, 0.04, 0.06], [0.085, 0.13, 0.21]))
    return lathe.box((float(middle), float(short), float(tall)))


def _cylinder(rng: Rng) -> TriMesh:
    """A can, a tin or a roll."""
    return lathe.cylinder(float(rng.uniform(0.018, 0.048)), float(rng.uniform(0.035, 0.19)))


def _lathe(rng: Rng) -> TriMesh:
    """A bottle, cup or knob: radii that wander along a height, maybe with a neck, maybe oval."""
    height, width = rng.uniform(0.07, 0.23), rng.uniform(0.024, 0.044)
    knots = rng.integers(3, 7)
    radii = width * np.clip(1 + np.cumsum(rng.normal(0, 0.13, knots)), 0.55, 1.35)
    if rng.random() < 0.5:
        radii[-1] *= rng.uniform(0.3, 0.6)
    z = np.linspace(0, 1, 4 * knots)
    smooth = np.interp(z, np.linspace(0, 1, knots), radii)
    smooth = np.convolve(np.pad(smooth, 1, mode="edge"), [0.25, 0.5, 0.25], mode="valid")
    profile = [(0.0, 0.0), *zip(smooth, height * z, strict=True), (0.0, float(height))]
    return lathe.lathe([(float(r), float(h)) for r, h in profile], flatten=rng.uniform(0.6, 1.0))


def _fruit(rng: Rng) -> TriMesh:
    """An egg, a lemon, a potato."""
    radius = rng.uniform(0.016, 0.032)
    factors = rng.uniform(0.7, 1.5, 3)
    lump = float(rng.uniform(0.5, 0.9) * radius)
    offset = 0.5 * radius * rng.normal(size=3)
    body = union(ball((0, 0, 0), radius), ball(tuple(offset), lump), blend=0.6 * radius)
    return _meshed(stretched(body, tuple(factors)), 2.2 * radius * factors.max() * np.ones(3))


def _tool(rng: Rng) -> TriMesh:
    """A grip with something at its end."""
    grip, length = rng.uniform(0.010, 0.019), rng.uniform(0.07, 0.13)
    reach, thin = rng.uniform(0.04, 0.1), rng.uniform(0.004, 0.012)
    shaft = rod((0, 0, 0), (reach, 0, 0), float(thin))
    handle = chain(
        [(0, 0, 0), (-length / 2, 0, 0), (-length, 0, 0)],
        [float(grip * f) for f in rng.uniform(0.75, 1.1, 3)],
    )
    x, y, z = (float(side) for side in rng.uniform(0.014, 0.06, 3))
    head = rounded_box((float(reach), 0, 0), (x, y, z), 0.003)
    parts = [shaft, handle, head] if rng.random() < 0.6 else [shaft, handle]
    size = np.array([max(length, reach) + 0.04, 0.05, 0.05])
    return _meshed(union(*parts, blend=0.004), size)


def _angle(rng: Rng) -> TriMesh:
    """Two blocks that meet at an angle: an L, a T or a step."""
    long, tall = rng.uniform(0.08, 0.16), rng.uniform(0.06, 0.15)
    thick = rng.uniform(0.022, 0.045, 2)
    depth = float(rng.uniform(0.025, 0.06))
    foot = rounded_box((0, 0, float(thick[0]) / 2), (float(long), depth, float(thick[0])), 0.004)
    x = float(rng.choice([0.0, 0.5, 1.0]) * (long - thick[1]) / 2)
    post = rounded_box((x, 0, float(tall) / 2), (float(thick[1]), depth, float(tall)), 0.004)
    return _meshed(union(foot, post, blend=0.004), np.array([long / 2, depth / 2, tall]) + 0.01)


def _vessel(rng: Rng) -> TriMesh:
    """A cup or bowl, hollow, maybe with a handle."""
    radius, height = rng.uniform(0.028, 0.048), rng.uniform(0.04, 0.11)
    wall = rng.uniform(0.004, 0.007)
    outer = rod((0, 0, 0), (0, 0, float(height)), float(radius), edge=0.0015)
    inner = rod((0, 0, float(1.5 * wall)), (0, 0, float(height) + 0.05), float(radius - wall))
    if rng.random() < 0.6:
        loop = 0.3 * height
        handle = ring((float(radius), 0, float(height / 2)), float(loop), 0.0055)
        outer = union(outer, handle, blend=0.004)
    return _meshed(cut(outer, inner), np.array([radius + 0.4 * height, radius, height]))


def _compound(rng: Rng) -> TriMesh:
    """A body with a slimmer neck and a head: sprayers, dispensers, toys, figures."""
    body, head = rng.uniform(0.022, 0.042), rng.uniform(0.014, 0.03)
    low, high = rng.uniform(0.04, 0.1), rng.uniform(0.02, 0.07)
    flat = float(rng.uniform(0.65, 1.0))
    trunk = stretched(
        cone_capsule((0, 0, 0), (0, 0, float(low)), float(body), float(body * 0.85)), (1, flat, 1)
    )
    neck = rod((0, 0, float(low)), (0, 0, float(low + body + high)), float(0.5 * head))
    top = float(low + body + high)
    lean = float(rng.uniform(-0.02, 0.03))
    crown = rounded_box(
        (lean, 0, top), (float(2.4 * head), float(1.4 * head), float(1.5 * head)), 0.004
    )
    foot = rounded_box((0, 0, 0.3), (0.2, 0.2, 0.6 + body), 0.002)  # cuts the body flat below
    flattened = cut(union(trunk, neck, crown, blend=0.006), lambda p: -foot(p))
    return _meshed(flattened, np.array([body + 0.05, body, top + 0.04]))


def _slab(rng: Rng) -> TriMesh:
    """What lies low: a bar of soap, a tin, a phone, a tray."""
    thick = float(rng.uniform(0.012, 0.035))
    if rng.random() < 0.35:
        return lathe.cylinder(float(rng.uniform(0.022, 0.07)), thick)
    x, y = (float(side) for side in rng.uniform([0.06, 0.035], [0.19, 0.1]))
    edge = float(rng.uniform(0.1, 0.45) * thick)
    return _meshed(rounded_box((0, 0, 0), (x, y, thick), edge), np.array([x, y, thick]) / 2)


def _tongs(rng: Rng) -> TriMesh:
    """Two legs that meet or cross: clamps, pliers, scissors, pegs."""
    leg, cross = float(rng.uniform(0.05, 0.11)), float(rng.uniform(0.0, 0.05))
    spread = rng.uniform(0.2, 0.65)  # of each leg from the middle, in rad
    radii = rng.uniform(0.005, 0.012, 3)
    parts = []
    for side in (-1.0, 1.0):
        x, y = float(np.cos(spread)), float(side * np.sin(spread))
        end, tip = (-leg * x, -leg * y, 0.0), (cross * x, cross * y, 0.0)
        parts.append(cone_capsule(end, tip, float(radii[0]), float(radii[1])))
    pivot = 1.5 * float(radii[2])
    parts.append(rod((0, 0, -pivot), (0, 0, pivot), float(rng.uniform(0.007, 0.014))))
    return _meshed(union(*parts, blend=0.003), np.array([leg, leg, 0.02]) + 0.015)


def _meshed(field: Field, half: np.ndarray) -> TriMesh:
    """The mesh of a field within a box of half sides about the origin."""
    reach = np.asarray(half, float) + _MARGIN_M
    x, y, z = (float(r) for r in reach)
    return mesh_field(field, (-x, -y, -z), (x, y, z))


_KINDS: Mapping[str, Callable[[Rng], TriMesh]] = {
    "box": _box,
    "lathe": _lathe,
    "tool": _tool,
    "cylinder": _cylinder,
    "angle": _angle,
    "fruit": _fruit,
    "vessel": _vessel,
    "compound": _compound,
    "slab": _slab,
    "tongs": _tongs,
}
