"""Pictures of web pages and what they show."""

from pathlib import Path

import numpy as np
from matplotlib.image import imread
from numpy.typing import NDArray

from vh_drake.experiments.browser import screenshot

__all__ = ["pixels", "screenshot", "share_of_hue"]


def pixels(picture: Path) -> NDArray[np.float64]:
    """(height, width, 3) red, green and blue of a PNG, each in 0..1."""
    return np.asarray(imread(picture), dtype=float)[..., :3]


def share_of_hue(picture: Path, rgb: tuple[float, float, float], tolerance: float = 0.12) -> float:
    """Share of the pixels that have the hue of a colour, however light or shade falls on it."""
    image = pixels(picture)
    lit = image.max(axis=-1) > 0.15
    direction = image / np.maximum(np.linalg.norm(image, axis=-1, keepdims=True), 1e-9)
    wanted = np.asarray(rgb) / np.linalg.norm(rgb)
    return float(np.mean(lit & (np.linalg.norm(direction - wanted, axis=-1) < tolerance)))
