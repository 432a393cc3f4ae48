"""The estimated surface: prior shape, Gaussian process, mesh."""

from dataclasses import dataclass, field

import numpy as np

from vh_drake.errors import BadInput
from vh_drake.gpis.evidence import farthest_points, require_finite
from vh_drake.gpis.kernels import Kernel, SquaredExponential
from vh_drake.gpis.meshing import closed_mesh
from vh_drake.gpis.observations import Observations, surface_observations
from vh_drake.gpis.posterior import Posterior, fit
from vh_drake.gpis.prior import PriorSettings, node_coordinates, prior_shape, sample
from vh_drake.types import ContactSet, ObjectView, ScalarGrid, Surface


@dataclass(frozen=True)
class SurfaceSettings:
    """How a surface is estimated.

    Kernel and the noise of contacts are those of a small grid with which the error on the train
    split of scanned objects fell with every touch; a wider kernel carries what one touch tells
    of a bulge down to where the object recedes again.
    """

    kernel: Kernel = field(default_factory=lambda: SquaredExponential(0.03, 0.005))
    prior: PriorSettings = field(default_factory=PriorSettings)
    most_points: int = 100  # camera points that enter the Gaussian process
    point_std_m: float = 0.0015
    point_normal_std: float = 0.6
    contact_std_m: float = 0.002
    contact_normal_std: float = 0.2
    margin_m: float = 0.03  # grid beyond the data
    most_extent_m: float = 1.0  # what lies wider apart is no object
    least_spacing_m: float = 0.003
    most_nodes: int = 100_000


def data_grid(view: ObjectView, contacts: ContactSet, settings: SurfaceSettings) -> ScalarGrid:
    """An empty grid around points, contacts and the table below them.

    Raises:
        BadInput: the data are spread wider than any object of this hand.
    """
    p = np.vstack([view.p_WO, contacts.p_WC])
    foot = p - np.outer(view.table.height(p), view.table.normal)
    low, high = np.minimum(p.min(axis=0), foot.min(axis=0)), p.max(axis=0)
    widest = float((high - low).max())
    if widest > settings.most_extent_m:
        raise BadInput(
            f"points and contacts are spread over {widest:.2f} m, more than "
            f"{settings.most_extent_m:g} m; crop them to one object, in metres"
        )
    low = low - settings.margin_m * np.array([1.0, 1.0, 0.3])  # the table clips what is below
    high = high + settings.margin_m
    spacing = max(
        settings.least_spacing_m, float(np.prod(high - low) / settings.most_nodes) ** (1 / 3)
    )
    shape = np.ceil((high - low) / spacing).astype(int) + 1
    return ScalarGrid(low, spacing, np.zeros(shape))


def estimate_surface(
    view: ObjectView, contacts: ContactSet, settings: SurfaceSettings | None = None
) -> Surface:
    """Closed surface of an object from one view and touches.

    The mean of the Gaussian process is the prior shape's signed distance, its data are the
    residuals of camera points and contacts; what reaches below the table is cut off there.

    Args:
        view: object points with normals, table, camera; without points the contacts count alone.
        contacts: touches with normals.
        settings: kernel, noise, resolution.

    Returns:
        Watertight mesh with outward normals and the potential's variance [m²] at the vertices,
        and the potential on a grid [m].

    Raises:
        BadInput: neither points nor contacts, numbers that are not finite, normals that are not
            of unit length, or data wider than `most_extent_m`.
        IllConditionedKernel: the kernel can't hold the data.
    """
    settings = settings or SurfaceSettings()
    require_finite(view, contacts)
    grid = data_grid(view, contacts, settings)
    prior = prior_shape(view, contacts, grid, settings.prior)
    posterior = fit(settings.kernel, _residuals(prior, view, contacts, settings))
    values = prior.values + posterior.mean_on_grid(*node_coordinates(grid))
    return _mesh(ScalarGrid(grid.origin, grid.spacing, values), posterior, view)


def _residuals(
    prior: ScalarGrid, view: ObjectView, contacts: ContactSet, s: SurfaceSettings
) -> Observations:
    """Observations less the prior's value and gradient at them."""
    chosen = farthest_points(view.p_WO, s.most_points)
    seen = surface_observations(
        view.p_WO[chosen],
        view.n_WO[chosen],
        value_std_m=s.point_std_m,
        gradient_std=s.point_normal_std,
    )
    touched = surface_observations(
        contacts.p_WC, contacts.n_WC, value_std_m=s.contact_std_m, gradient_std=s.contact_normal_std
    )
    both = seen.joined(touched)
    value, gradient = sample(prior, both.p)
    return Observations(
        both.p,
        both.value - value,
        both.value_variance,
        both.gradient - gradient,
        both.gradient_variance,
    )


def _mesh(potential: ScalarGrid, posterior: Posterior, view: ObjectView) -> Surface:
    x, y, z = np.meshgrid(*node_coordinates(potential), indexing="ij", sparse=True)
    n = view.table.normal
    below = view.table.offset - (n[0] * x + n[1] * y + n[2] * z)
    clipped = ScalarGrid(potential.origin, potential.spacing, np.maximum(potential.values, below))
    vertices, faces, normals = closed_mesh(clipped, posterior.observations.p)
    return Surface(vertices, faces, normals, posterior.variance(vertices), clipped)
