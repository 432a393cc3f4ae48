r"""The shape that camera, table and gravity suggest before any touch.

One view shows only one side; a Gaussian process with normals alone runs away behind it. The
prior shape closes it from four pieces of evidence:

1. Free space: a ray that passed beside or in front of the seen points met nothing, so the object
   lies inside the *shadow* of its seen points.
2. The table: the object stands on it and does not reach below.
3. Gravity: what was seen is held up by something. The object fills the *columns* from the seen
   points down to the table, as far as they lie in the shadow.
4. Depth: a view from the side shows a face without depth. The columns are then carried on into
   the shadow until the object is as deep as a share of its visible width or height.

The signed distance to this shape is the mean function of the Gaussian process (geometric priors,
Martens et al. 2017, cited in section 3.2.2), negative inside.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.spatial import cKDTree

from vh_drake.types import Array, ContactSet, ObjectView, ScalarGrid

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class PriorSettings:
    """What is believed of the side that nobody has seen."""

    side_view_below_rad: float = 0.25  # camera's elevation over the object's top
    depth_share: float = 0.8  # of the lesser of width and height, in a view from the side
    ball_radius_m: float = 0.03  # behind each contact, where nothing was seen


@dataclass(frozen=True, eq=False)
class DepthImage:
    """The object as a picture of square pixels around the direction to its middle."""

    p_WCamera: Array  # (3,) [m]
    R_WC: Array  # (3, 3), z along the view
    first_pixel: Array  # (2,) tangent of the first pixel's centre
    pixel: float  # tangent of a pixel's width
    depth: Array  # (rows, columns) along z [m], inf where the object was not seen

    def depth_at(self, p_W: Array) -> tuple[Array, Array]:
        """Depth of points (n, 3) and what was seen in their pixels, inf for nothing [m]."""
        p_C = (p_W - self.p_WCamera) @ self.R_WC
        z = np.maximum(p_C[:, 2], 1e-6)
        index = np.rint((p_C[:, :2] / z[:, None] - self.first_pixel) / self.pixel).astype(int)
        inside = ((index >= 0) & (index < self.depth.shape)).all(axis=1)
        seen = np.full(len(p_W), np.inf)
        seen[inside] = self.depth[index[inside, 0], index[inside, 1]]
        return p_C[:, 2], seen


def point_spacing(p: Array) -> float:
    """The spacing that nine of ten points (n, 3) keep to a neighbour; 0 for fewer than two [m]."""
    if len(p) < 2:
        return 0.0
    distance, _ = cKDTree(p).query(p, k=2)
    return float(np.quantile(distance[:, 1], 0.9))


def look_at_rotation(p_from: Array, p_to: Array) -> Array:
    """A rotation R_WC whose z axis points from one place to another."""
    z = (p_to - p_from) / np.linalg.norm(p_to - p_from)
    helper = np.eye(3)[int(np.argmin(np.abs(z)))]
    x = np.cross(helper, z) / np.linalg.norm(np.cross(helper, z))
    return np.column_stack([x, np.cross(z, x), z])


def depth_image(view: ObjectView, *, least_pixel_m: float) -> DepthImage:
    """Picture of the seen points, with pixels wide enough to leave no hole between them."""
    p_WO = view.p_WO
    R_WC = look_at_rotation(view.p_WCamera, p_WO.mean(axis=0))
    p_C = (p_WO - view.p_WCamera) @ R_WC
    pixel = max(least_pixel_m, point_spacing(p_WO)) / float(np.median(p_C[:, 2]))
    tangent = p_C[:, :2] / p_C[:, 2:]
    first = tangent.min(axis=0) - 2 * pixel
    index = np.rint((tangent - first) / pixel).astype(int)
    depth = np.full(index.max(axis=0) + 3, np.inf)
    np.minimum.at(depth, (index[:, 0], index[:, 1]), p_C[:, 2])
    return DepthImage(view.p_WCamera, R_WC, first, pixel, _closed(depth, np.minimum))


def column_tops(view: ObjectView, grid: ScalarGrid) -> Array:
    """Height of the highest seen point above each ground cell (nx, ny), -inf where none [m]."""
    tops = np.full(grid.values.shape[:2], -np.inf)
    cell = np.rint((view.p_WO[:, :2] - grid.origin[:2]) / grid.spacing).astype(int)
    np.maximum.at(tops, (cell[:, 0], cell[:, 1]), view.p_WO[:, 2])
    sparse = point_spacing(view.p_WO) / grid.spacing
    return -_closed(-tops, np.minimum, rounds=max(1, int(np.ceil(sparse))))


def _closed(image: Array, least: np.ufunc, rounds: int = 1) -> Array:
    """Fill holes (inf) that a morphological closing of the known pixels covers."""
    cross = ndimage.generate_binary_structure(2, 2)
    known = np.pad(np.isfinite(image), rounds)
    covered = ndimage.binary_closing(known, cross, iterations=rounds)
    covered = ndimage.binary_fill_holes(covered)[rounds:-rounds, rounds:-rounds]
    filled = image
    while (covered & ~np.isfinite(filled)).any():
        spread = ndimage.grey_erosion(filled, footprint=cross, mode="nearest")
        filled = np.where(np.isfinite(filled), filled, np.where(covered, spread, np.inf))
    return filled


def node_coordinates(grid: ScalarGrid) -> tuple[Array, Array, Array]:
    """Coordinates of the nodes along each axis [m]."""
    x, y, z = (grid.origin[i] + grid.spacing * np.arange(grid.values.shape[i]) for i in range(3))
    return x, y, z


def nodes(grid: ScalarGrid) -> Array:
    """All nodes (nx * ny * nz, 3) [m]."""
    axes = np.meshgrid(*node_coordinates(grid), indexing="ij")
    return np.stack(axes, axis=-1).reshape(-1, 3)


def shadow(view: ObjectView, grid: ScalarGrid, p_W: Array) -> Mask:
    """Which nodes may be solid: above the table and behind seen points (nx, ny, nz)."""
    image = depth_image(view, least_pixel_m=0.5 * grid.spacing)
    z, seen = image.depth_at(p_W)
    solid = (z >= seen - 0.5 * grid.spacing) & (view.table.height(p_W) > -grid.spacing)
    return np.asarray(solid.reshape(grid.values.shape))


def signed_distance(solid: Mask, spacing: float) -> Array:
    """Signed distance to the border of a set of nodes, negative inside [m]."""
    outside = ndimage.distance_transform_edt(~solid)
    inside = ndimage.distance_transform_edt(solid)
    steps = np.where(solid, 0.5 - inside, outside - 0.5)
    smooth: Array = spacing * ndimage.gaussian_filter(steps, 0.7)
    return smooth


def deepened(tops: Array, view: ObjectView, grid: ScalarGrid, settings: PriorSettings) -> Array:
    """Carry columns on away from the camera where a view from the side shows no depth.

    The wanted depth is a share of the lesser of visible width and height.
    """
    sight = view.p_WO.mean(axis=0) - view.p_WCamera
    along = sight[:2] / max(float(np.linalg.norm(sight[:2])), 1e-9)
    height = view.table.height(view.p_WO)
    slope = view.table.height(view.p_WCamera) - height.max()
    if np.arctan2(slope, np.linalg.norm(sight[:2])) > settings.side_view_below_rad:
        return tops
    depth = np.ptp(view.p_WO[:, :2] @ along)
    width = np.ptp(view.p_WO[:, :2] @ np.array([-along[1], along[0]]))
    missing = settings.depth_share * min(width, height.max()) - depth
    deep = tops
    for step in range(1, int(missing / grid.spacing) + 1):
        moved = ndimage.shift(tops, along * step, order=0, cval=-np.inf, prefilter=False)
        deep = np.maximum(deep, moved)
    return deep


def seen_solid(view: ObjectView, grid: ScalarGrid, settings: PriorSettings) -> Mask:
    """The columns below the seen points within their shadow, as nodes (nx, ny, nz)."""
    p_W = nodes(grid)
    tops = deepened(column_tops(view, grid), view, grid, settings)
    below = p_W[:, 2].reshape(grid.values.shape) <= tops[:, :, None]
    return np.asarray(below & shadow(view, grid, p_W))


def touched_solid(contacts: ContactSet, grid: ScalarGrid, radius_m: float) -> Mask:
    """Balls that touch the contacts from inside, as nodes (nx, ny, nz)."""
    solid = np.zeros(grid.values.size, bool)
    p_W = nodes(grid)
    for centre in contacts.p_WC - radius_m * contacts.n_WC:
        solid |= np.sum((p_W - centre) ** 2, axis=1) < radius_m**2
    return solid.reshape(grid.values.shape)


def prior_shape(
    view: ObjectView, contacts: ContactSet, grid: ScalarGrid, settings: PriorSettings
) -> ScalarGrid:
    """Signed distance to the shape that view (or contacts, where nothing was seen) suggest [m]."""
    if len(view.p_WO):
        solid = seen_solid(view, grid, settings)
    else:
        solid = touched_solid(contacts, grid, settings.ball_radius_m)
    return ScalarGrid(grid.origin, grid.spacing, signed_distance(solid, grid.spacing))


def sample(grid: ScalarGrid, p_W: Array) -> tuple[Array, Array]:
    """Value (n,) and gradient (n, 3) of a field at points (n, 3), by trilinear interpolation."""
    index = ((p_W - grid.origin) / grid.spacing).T
    value = ndimage.map_coordinates(grid.values, index, order=1, mode="nearest")
    slopes = [
        ndimage.map_coordinates(slope, index, order=1, mode="nearest")
        for slope in np.gradient(grid.values, grid.spacing)
    ]
    return value, np.column_stack(slopes)
