r"""What a structured-light camera adds to a perfect depth image.

The figures are those published for PrimeSense sensors (Kinect v1, Carmine 1.08):

- axial noise, Nguyen, Izadi & Lovell 2012, eq. 3 and 4 (z in m, θ the angle of incidence):

  .. math:: \sigma_z = 0.0012 + 0.0019 (z - 0.4)^2
            + \frac{0.0001}{\sqrt z} \frac{\theta^2}{(\pi/2 - \theta)^2}

- disparity steps of 1/8 pixel at 580 pixels of focal length and 75 mm between projector and
  camera, Khoshelham & Elberink 2012;
- at depth edges the outline frays by about 0.8 pixel (Nguyen's lateral noise) and pixels drop
  out; so do grazing surfaces, whose pattern cannot be matched.

Left out: the projector's shadow, correlated noise among neighbouring pixels, materials.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from vh_drake.sensing.intrinsics import Intrinsics

Depth = NDArray[np.float32]


@dataclass
class DepthNoiseSettings:
    """Knobs of the noise model; the defaults describe a PrimeSense Carmine."""

    axial_m: float = 0.0012  # standard deviation at 0.4 m, head on [m]
    axial_per_m: float = 0.0019  # its growth with (z - 0.4 m)^2 [1/m]
    grazing: float = 0.0001  # weight of the angle of incidence [m^1.5]
    disparity_step_px: float = 0.125  # 0 switches the steps off [pixel]
    focal_baseline_m: float = 580.0 * 0.075  # focal length times baseline [pixel m]
    edge_m: float = 0.03  # a jump in depth that counts as an edge [m]
    lateral_px: float = 0.8  # fraying of edges [pixel]
    edge_dropout: float = 0.3  # share of edge pixels that measure nothing
    max_incidence_deg: float = 82.0  # beyond this every pixel drops out


def add_depth_noise(
    depth: NDArray[np.floating],
    intrinsics: Intrinsics,
    rng: np.random.Generator,
    settings: DepthNoiseSettings | None = None,
) -> Depth:
    """A noisy copy of a depth image.

    Args:
        depth: (height, width) distance along the optical axis [m]; 0, infinite and NaN
            pixels measured nothing and stay 0.
        intrinsics: the camera.
        rng: the source of all noise; the same generator state gives the same image.
        settings: the model's knobs.

    Returns:
        (height, width) float32 [m], 0 where nothing was measured.
    """
    settings = settings or DepthNoiseSettings()
    measured = np.isfinite(depth) & (depth > 0.0)
    clean = np.where(measured, depth, 0.0).astype(np.float32)
    edges = _edges(clean, settings.edge_m)
    frayed = _fray(clean, edges, rng, settings)
    incidence = _incidence(clean, intrinsics, edges)
    z = frayed + _axial_std(frayed, incidence, settings) * rng.standard_normal(
        frayed.shape, dtype=np.float32
    )
    z = _quantise(z, settings)
    lost = (frayed <= 0.0) | (incidence > np.deg2rad(settings.max_incidence_deg))
    lost |= edges & (rng.random(frayed.shape, dtype=np.float32) < settings.edge_dropout)
    z[lost | ~np.isfinite(z) | (z < 0.0)] = 0.0
    return z


def _edges(depth: Depth, jump_m: float) -> NDArray[np.bool_]:
    """Pixels whose 3 x 3 neighbourhood spans more than a jump."""
    span = ndimage.maximum_filter(depth, 3) - ndimage.minimum_filter(depth, 3)
    edges: NDArray[np.bool_] = span > jump_m
    return edges


def _fray(
    depth: Depth,
    edges: NDArray[np.bool_],
    rng: np.random.Generator,
    settings: DepthNoiseSettings,
) -> Depth:
    """Edge pixels take the depth of a pixel nearby."""
    v, u = np.nonzero(edges & (depth > 0.0))
    shift = np.rint(settings.lateral_px * rng.standard_normal((2, len(v)))).astype(int)
    frayed = depth.copy()
    height, width = depth.shape
    frayed[v, u] = depth[np.clip(v + shift[0], 0, height - 1), np.clip(u + shift[1], 0, width - 1)]
    return frayed


def _incidence(depth: Depth, intrinsics: Intrinsics, edges: NDArray[np.bool_]) -> Depth:
    """Angle [rad] between ray and surface normal; 0 at edges, where it is unknown.

    With q = 1/z, a plane has constant derivatives of q in the image, and its normal is
    proportional to (fx q_u, fy q_v, q - (u - cx) q_u - (v - cy) q_v).
    """
    q = np.where(depth > 0.0, 1.0 / np.maximum(depth, 1e-6), 0.0).astype(np.float32)
    q_v, q_u = np.gradient(q)
    u = (np.arange(intrinsics.width, dtype=np.float32) - np.float32(intrinsics.cx))[None, :]
    v = (np.arange(intrinsics.height, dtype=np.float32) - np.float32(intrinsics.cy))[:, None]
    n_x, n_y = np.float32(intrinsics.fx) * q_u, np.float32(intrinsics.fy) * q_v
    n_z = q - u * q_u - v * q_v
    ray = np.sqrt((u / np.float32(intrinsics.fx)) ** 2 + (v / np.float32(intrinsics.fy)) ** 2 + 1)
    norm = np.sqrt(n_x**2 + n_y**2 + n_z**2) * ray
    # The normal's product with the ray ((u - cx)/fx, (v - cy)/fy, 1) is q itself.
    cosine = np.divide(q, norm, out=np.ones_like(q), where=norm > 0.0)
    cosine[edges] = 1.0
    incidence: Depth = np.arccos(np.clip(cosine, 0.0, 1.0))
    return incidence


def _axial_std(depth: Depth, incidence: Depth, settings: DepthNoiseSettings) -> Depth:
    head_on = settings.axial_m + settings.axial_per_m * (depth - np.float32(0.4)) ** 2
    angle = np.minimum(incidence, np.float32(np.deg2rad(settings.max_incidence_deg)))
    slope = (angle / (np.float32(np.pi / 2) - angle)) ** 2
    std = head_on + settings.grazing / np.sqrt(np.maximum(depth, 0.1)) * slope
    return std.astype(np.float32)


def _quantise(depth: Depth, settings: DepthNoiseSettings) -> Depth:
    """Rounds the disparity focal x baseline / z to its step."""
    if settings.disparity_step_px <= 0.0:
        return depth
    with np.errstate(divide="ignore"):
        steps = np.rint(settings.focal_baseline_m / settings.disparity_step_px / depth)
        quantised: Depth = np.float32(
            settings.focal_baseline_m / settings.disparity_step_px
        ) / steps.astype(np.float32)
    return quantised
