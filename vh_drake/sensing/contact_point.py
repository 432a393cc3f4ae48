r"""Where on the hand a force acts, and how the object's surface stands there.

The thesis infers the place of a contact "from the model of the hand" (section 4.5.3). Here
the torque helps: a force F at p gives :math:`\tau = p \times F`, so p lies on a line along F.
Of the points on the hand's skin, with outward normals m, the one is taken that minimises

.. math:: \frac{w \sum_k \|\tau_k - p \times F_k\|^2}{\sigma_\tau^2 + \|p\|^2 \sigma_F^2}
          + \frac{\|p - \bar p\|^2}{\sigma_p^2} + \frac{\angle(m, d)^2}{\sigma_m^2}

over all readings k of one contact, among candidates whose skin faces the force. The prior knows
the expected place :math:`\bar p` and the direction d in which the hand moves. The sum counts
strong readings most, so that a contact which lasts an instant is placed by its peak, and it
needs three moments of the readings alone:

.. math:: \sum_k \|\tau_k - p \times F_k\|^2 = \sum \|\tau_k\|^2
          + 2 p \cdot \sum \tau_k \times F_k + p^\top (\operatorname{tr} S \, I - S) p,
          \quad S = \sum F_k F_k^\top
"""

import dataclasses as dc

import numpy as np

from vh_drake.errors import BadInput
from vh_drake.types import Array, Immutable


@dc.dataclass(frozen=True, eq=False)
class Skin:
    """Points of the hand that may touch, in H, for the finger posture of the touch."""

    p_H: Array  # (n, 3) [m]
    n_H: Array  # (n, 3) outward unit normals of the hand
    p_HExpected: Array  # (3,) where contact is expected [m]

    def __post_init__(self) -> None:
        if self.p_H.ndim != 2 or self.p_H.shape != self.n_H.shape or len(self.p_H) == 0:
            raise BadInput(
                f"points {self.p_H.shape} and normals {self.n_H.shape} of the hand's skin must "
                "be (n, 3), n > 0"
            )


@dc.dataclass(frozen=True, eq=False)
class Readings(Immutable):
    """Moments of the wrenches that one contact gave, about Ho in H."""

    force: Array = dc.field(default_factory=lambda: np.zeros(3))  # Σ F [N]
    forces: Array = dc.field(default_factory=lambda: np.zeros((3, 3)))  # Σ F Fᵀ [N²]
    moment: Array = dc.field(default_factory=lambda: np.zeros(3))  # Σ τ x F [N² m]
    torque: float = 0.0  # Σ |τ|² [N² m²]

    @staticmethod
    def of(*wrenches: Array) -> "Readings":
        """Of wrenches (6,) [N m; N]."""
        readings = Readings()
        for wrench in wrenches:
            readings = readings.with_wrench(wrench)
        return readings

    def with_wrench(self, wrench_H: Array) -> "Readings":
        """After one more."""
        torque, force = wrench_H[:3], wrench_H[3:]
        return Readings(
            self.force + force,
            self.forces + np.outer(force, force),
            self.moment + np.cross(torque, force),
            self.torque + float(torque @ torque),
        )

    def misfit(self, p_H: Array) -> Array:
        """Σ |τ - p x F|² (n,) [N² m²] for points (n, 3) [m]."""
        across = np.trace(self.forces) * np.eye(3) - self.forces
        misfit: Array = self.torque + 2.0 * p_H @ self.moment + ((p_H @ across) * p_H).sum(axis=1)
        return misfit


def pad_skin(
    p_HPad: Array,
    n_HPad: Array,
    *,
    radius_m: float = 0.0043,
    spacing_m: float = 0.0015,
    rim_lean_rad: float = np.deg2rad(45.0),
) -> Skin:
    """A flat round patch about each pad; the first pad is where contact is expected.

    A pad that does not lie flat presses with the side towards which the object leans, the more
    so the more it leans. So the patch counts as if it were domed: its normals lean outwards from
    the middle to the rim.

    Args:
        p_HPad: (k, 3) middles of the pads in H [m].
        n_HPad: (k, 3) their outward normals.
        radius_m: of the patches [m]; ARMAR-6's pads measure 7.0 by 8.6 mm.
        spacing_m: of the points [m].
        rim_lean_rad: of the normals at the rim [rad].
    """
    p_HPad, n_HPad = np.atleast_2d(p_HPad), np.atleast_2d(n_HPad)
    half = int(radius_m / spacing_m + 1e-9)
    steps = spacing_m * np.arange(-half, half + 1)
    grid = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    grid = grid[np.linalg.norm(grid, axis=1) <= radius_m + 1e-9]
    points, normals = [], []
    for p, n in zip(p_HPad, n_HPad, strict=True):
        unit = n / np.linalg.norm(n)
        _, _, rows = np.linalg.svd(unit[None])
        across = grid @ rows[1:]
        domed = unit + np.tan(rim_lean_rad) / radius_m * across
        points.append(p + across)
        normals.append(domed / np.linalg.norm(domed, axis=1, keepdims=True))
    return Skin(np.concatenate(points), np.concatenate(normals), p_HPad[0].copy())


def capsule_skin(p_HA: Array, p_HB: Array, radius_m: float, *, spacing_m: float = 0.003) -> Skin:
    """The skin of a finger link from A to B, with the round end at B, where contact is expected.

    Args:
        p_HA: (3,) start of the capsule's axis in H [m].
        p_HB: (3,) its end [m].
        radius_m: of the capsule [m].
        spacing_m: of the points [m].
    """
    axis = np.asarray(p_HB, dtype=float) - p_HA
    length = float(np.linalg.norm(axis))
    _, _, rows = np.linalg.svd(axis[None] / length)
    number = max(8, round(2.0 * np.pi * radius_m / spacing_m))
    angles = np.linspace(0.0, 2.0 * np.pi, number, endpoint=False)
    rim = np.outer(np.cos(angles), rows[1]) + np.outer(np.sin(angles), rows[2])
    points, normals = [], []
    for s in np.linspace(0.0, 1.0, max(2, round(length / spacing_m) + 1)):
        points.append(p_HA + s * axis + radius_m * rim)
        normals.append(rim)
    rings = max(3, round(0.5 * np.pi * radius_m / spacing_m) + 1)
    for polar in np.linspace(0.0, 0.5 * np.pi, rings)[1:]:
        cap = np.cos(polar) * rim + np.sin(polar) * axis / length
        points.append(p_HB + radius_m * cap)
        normals.append(cap)
    expected = np.asarray(p_HB, dtype=float).copy()
    return Skin(np.concatenate(points), np.concatenate(normals), expected)


def contact_point(
    skin: Skin,
    readings: Readings,
    *,
    force_std_n: float,
    torque_std_nm: float,
    independent: float = 1.0,
    prior_std_m: float = 0.02,
    approach_H: Array | None = None,
    facing_std_rad: float = np.deg2rad(40.0),
) -> tuple[Array, Array]:
    """The likeliest contact on the skin.

    Args:
        skin: candidates.
        readings: what acts on the hand from outside, about Ho in H.
        force_std_n: of one reading, per axis [N].
        torque_std_nm: of one reading, per axis [N m].
        independent: share w of the readings that count; a filter makes them alike.
        prior_std_m: how far from the expected place contacts happen [m].
        approach_H: (3,) direction of motion of the hand; None or zero where unknown.
        facing_std_rad: how far the touching skin's normal is from that direction [rad].

    Returns:
        Point (3,) [m] and the hand's outward normal (3,) there, in H.
    """
    variance = torque_std_nm**2 + (skin.p_H**2).sum(axis=1) * force_std_n**2
    cost = independent * readings.misfit(skin.p_H) / variance
    cost += ((skin.p_H - skin.p_HExpected) ** 2).sum(axis=1) / prior_std_m**2
    if approach_H is not None and (speed := float(np.linalg.norm(approach_H))) > 1e-12:
        angle = np.arccos(np.clip(skin.n_H @ approach_H / speed, -1.0, 1.0))
        cost += (angle / facing_std_rad) ** 2
    facing = skin.n_H @ readings.force < 0.0  # The object pushes into the skin, never pulls.
    if facing.any():
        cost = np.where(facing, cost, np.inf)
    best = int(cost.argmin())
    return skin.p_H[best], skin.n_H[best]


def expected_approach(approach_W: Array, n_WSkin: Array) -> Array:
    """The direction (3,) in which the hand's skin meets the object.

    Where two surfaces touch, their normals are opposite. The skin's own is known as well as
    the place on it, so it counts half as much as the direction of motion.

    Args:
        approach_W: (3,) direction of motion; zero where unknown.
        n_WSkin: (3,) outward unit normal of the hand where it touches.
    """
    speed = float(np.linalg.norm(approach_W))
    return approach_W / speed + 0.5 * n_WSkin if speed > 1e-12 else approach_W


def contact_normal(force_W: Array, approach_W: Array, friction: float) -> Array:
    """The object's outward unit normal (3,) where it is touched.

    The finger comes against the normal that was expected. Friction turns the force away from
    the true normal by up to its cone's angle, so the force tells no more than that the normal
    lies within a cone about it: of that cone the direction next to the expected one is taken.

    Args:
        force_W: (3,) on the hand [N].
        approach_W: (3,) direction of motion; zero where unknown, then it is the force's direction.
        friction: largest coefficient of friction.
    """
    size, speed = float(np.linalg.norm(force_W)), float(np.linalg.norm(approach_W))
    if size < 1e-12:
        return -approach_W / speed if speed > 1e-12 else np.array([0.0, 0.0, 1.0])
    direction = force_W / size
    if speed < 1e-12:
        return direction
    expected = -approach_W / speed
    across = expected - (expected @ direction) * direction
    lean, most = float(np.linalg.norm(across)), float(np.arctan(friction))
    if np.arctan2(lean, expected @ direction) <= most:
        return expected
    if lean < 1e-9:  # The force points the wrong way altogether.
        return direction
    normal: Array = np.cos(most) * direction + np.sin(most) * across / lean
    return normal
