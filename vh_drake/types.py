"""Values that cross ports: frozen, in metres, expressed in the world frame W.

Frames: W world, H hand base (the frame that the wrist carries), T fingertip.
Normals are of unit length and point out of the object; the implicit surface
potential is negative inside (errata to eq. 3.5).
"""

from dataclasses import dataclass, field
from typing import Self

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]


def _empty(*shape: int) -> Array:
    return np.zeros(shape)


class Immutable:
    """A value that is replaced, never mutated, so that its copy is itself.

    Drake copies every abstract state of a diagram before each unrestricted update, values of
    Python by `copy.deepcopy`; sharing spares that, and keeps the identity of an unchanged value.
    """

    def __deepcopy__(self, memo: object) -> Self:
        return self


@dataclass(frozen=True, eq=False)
class Cloud(Immutable):
    """What a depth camera sees, background and table included."""

    p_WC: Array = field(default_factory=lambda: _empty(0, 3))  # (n, 3) points [m]
    p_WCamera: Array = field(default_factory=lambda: _empty(3))  # (3,) optical centre [m]
    # (4, 3) inward unit normals of the planes that bound the view; empty where unknown
    n_WFrustum: Array = field(default_factory=lambda: _empty(0, 3))


@dataclass(frozen=True, eq=False)
class Plane(Immutable):
    """The points x with normal · x = offset."""

    normal: Array = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))  # (3,), up
    offset: float = 0.0  # [m]

    def height(self, p_W: Array) -> Array:
        """Signed distance of points (..., 3) above the plane [m]."""
        height: Array = p_W @ self.normal - self.offset
        return height

    def z_below(self, p_W: Array) -> float:
        """World height of the plane under a point (3,), or over it [m]."""
        return float(p_W[2] - self.height(p_W) / self.normal[2])


@dataclass(frozen=True, eq=False)
class ObjectView(Immutable):
    """The segmented object and the table it stands on."""

    p_WO: Array = field(default_factory=lambda: _empty(0, 3))  # (n, 3) object points [m]
    n_WO: Array = field(default_factory=lambda: _empty(0, 3))  # (n, 3) outward normals
    table: Plane = field(default_factory=Plane)
    p_WCamera: Array = field(default_factory=lambda: _empty(3))  # (3,) optical centre [m]
    # (3, 3) of an error of the camera's pose, which moves all points alike [m²]
    shift_covariance: Array = field(default_factory=lambda: _empty(3, 3))


@dataclass(frozen=True, eq=False)
class ContactSet(Immutable):
    """Touched places, oldest first."""

    p_WC: Array = field(default_factory=lambda: _empty(0, 3))  # (n, 3) positions [m]
    n_WC: Array = field(default_factory=lambda: _empty(0, 3))  # (n, 3) outward normals

    def __len__(self) -> int:
        return len(self.p_WC)

    def with_contact(self, p_WC: Array, n_WC: Array) -> "ContactSet":
        """The set with one contact more."""
        return ContactSet(np.vstack([self.p_WC, p_WC]), np.vstack([self.n_WC, n_WC]))


@dataclass(frozen=True, eq=False)
class ScalarGrid(Immutable):
    """A scalar field sampled on a regular grid: values[i, j, k] at origin + spacing (i, j, k)."""

    origin: Array = field(default_factory=lambda: _empty(3))  # (3,) [m]
    spacing: float = 1.0  # [m]
    values: Array = field(default_factory=lambda: _empty(2, 2, 2))  # (nx, ny, nz)


@dataclass(frozen=True, eq=False)
class Surface(Immutable):
    """Snapshot of the estimated surface; `faces` is empty where nothing is known yet."""

    vertices: Array = field(default_factory=lambda: _empty(0, 3))  # (v, 3) [m]
    faces: IntArray = field(default_factory=lambda: np.zeros((0, 3), np.int64))  # (f, 3)
    normals: Array = field(default_factory=lambda: _empty(0, 3))  # (v, 3) outward
    variance: Array = field(default_factory=lambda: _empty(0))  # (v,) of the potential
    potential: ScalarGrid = field(default_factory=ScalarGrid)  # negative inside


@dataclass(frozen=True, eq=False)
class TouchPlan(Immutable):
    """Where the fingertip shall touch next, and the curve that leads there (eq. 3.83)."""

    p_WT: Array = field(default_factory=lambda: _empty(3))  # (3,) target [m]
    n_WT: Array = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))  # (3,) outward there
    control_points: Array = field(default_factory=lambda: _empty(4, 3))  # cubic Bezier [m]
    rating: float = 0.0  # Ψ, eq. 3.68


@dataclass(frozen=True, eq=False)
class Candidates(Immutable):
    """Grasp candidates: hand base poses in which the closing starts."""

    X_WH: Array = field(default_factory=lambda: _empty(0, 4, 4))  # (n, 4, 4) homogeneous
    motion: tuple[str, ...] = ()  # (n,) closing motion: "collect" (from the top) or "side"
    planner: tuple[str, ...] = ()  # (n,) who proposed it

    def __len__(self) -> int:
        return len(self.X_WH)

    def taken(self, chosen: IntArray) -> "Candidates":
        """Some of the candidates, by their indices (k,)."""
        return Candidates(
            self.X_WH[chosen],
            tuple(self.motion[i] for i in chosen),
            tuple(self.planner[i] for i in chosen),
        )


@dataclass(frozen=True, eq=False)
class GraspScores(Immutable):
    """Ratings of candidates, in their order; higher is better."""

    score: Array = field(default_factory=lambda: _empty(0))  # (n,) in 0..1
    standard_error: Array = field(default_factory=lambda: _empty(0))  # (n,)
