"""Implicit surfaces in the plane z = 0, drawn: potential, zero set, contacts."""

import numpy as np
from matplotlib.axes import Axes

from vh_drake.gpis.posterior import Posterior
from vh_drake.types import Array

_NODES = 160
_CM = 100.0


def in_plane(points: Array) -> Array:
    """Places (n, 2) as points in space (n, 3)."""
    return np.column_stack([points, np.zeros(len(points))])


def potential_in_plane(posterior: Posterior, low: Array, high: Array) -> tuple[Array, Array, Array]:
    """Coordinates x (n,) and y (n,) [m], and the potential (n, n) [m], rows along y."""
    x, y = np.linspace(low[0], high[0], _NODES), np.linspace(low[1], high[1], _NODES)
    return x, y, posterior.mean_on_grid(x, y, np.zeros(1))[:, :, 0].T


def draw_plane(
    axes: Axes,
    posterior: Posterior,
    p: Array,
    *,
    n: Array | None = None,
    truth: Array | None = None,
    low: Array,
    high: Array,
) -> None:
    """Draw a potential in the plane.

    Args:
        axes: to draw on.
        posterior: negative inside.
        p: (k, 3) contacts [m].
        n: (k, 3) normals that were observed, drawn as arrows.
        truth: (m, 2) outline of the true object [m].
        low: (2,) lower left corner [m].
        high: (2,) upper right corner [m].
    """
    x, y, f = potential_in_plane(posterior, low, high)
    most = float(np.abs(f).max())
    axes.pcolormesh(_CM * x, _CM * y, f, cmap="coolwarm", vmin=-most, vmax=most, rasterized=True)
    axes.contour(_CM * x, _CM * y, f, [0.0], colors="k", linewidths=2.0)
    axes.plot([], [], "k", lw=2.0, label="estimate, f = 0")
    if truth is not None:
        axes.plot(_CM * truth[:, 0], _CM * truth[:, 1], "--", color="gold", lw=2.0, label="truth")
    if n is not None:
        axes.quiver(_CM * p[:, 0], _CM * p[:, 1], n[:, 0], n[:, 1], color="tab:green", scale=14)
    axes.plot(_CM * p[:, 0], _CM * p[:, 1], "o", ms=5, color="tab:green", label="contacts")
    axes.set(
        xlabel="x [cm]",
        ylabel="y [cm]",
        xlim=(_CM * low[0], _CM * high[0]),
        ylim=(_CM * low[1], _CM * high[1]),
        aspect="equal",
    )
