"""What the evaluation measures of an exploration (section 3.6.1, table 3.5)."""

import dataclasses as dc

import numpy as np

from vh_drake.exploration.explorer import ExplorerSettings
from vh_drake.exploration.loop import Body, Exploration
from vh_drake.geometry.closest_points import closest_points
from vh_drake.gpis.following import follow_surface

_MESH_MARGIN_M = (
    0.01  # of the final estimate beyond the contacts' box (errata, "far from the data")
)


@dc.dataclass(frozen=True)
class Measures:
    """Numbers of one exploration."""

    end: str  # "goal", "stuck", "touches" or "lost"
    explored_share: float
    distance_cm: float  # without the first approach
    rotation_deg: float
    rmse_mm: float  # of the estimated mesh's vertices from the true surface
    prediction_error_mm: float  # mean distance of predicted and actual contact
    contacts: int
    missed: int


def measure(result: Exploration, body: Body, settings: ExplorerSettings) -> Measures:
    """The metrics of table 3.5, and how the exploration ended."""
    touches = [step.touch for step in result.steps]
    errors = [float(np.linalg.norm(touch.p_WT - touch.p_WC)) for touch in touches]
    return Measures(
        result.end,
        float(result.shares[-1]),
        100.0 * float(result.lengths_m[-1]),
        float(np.degrees(sum(touch.turn_rad for touch in touches))),
        1000.0 * surface_rmse(result, body, settings),
        1000.0 * float(np.mean(errors)) if errors else 0.0,
        len(result.known.contacts),
        sum(touch.missed for touch in touches),
    )


def surface_rmse(result: Exploration, body: Body, settings: ExplorerSettings) -> float:
    """Root mean square distance of the estimated mesh's vertices from the true surface [m]."""
    sheet = follow_surface(
        result.known.posterior,
        result.known.contacts.p_WC,
        spacing_m=settings.spacing_m,
        margin_m=_MESH_MARGIN_M,
    )
    if len(sheet.vertices) == 0:
        return float("nan")
    gap = closest_points(body.tree, sheet.vertices) - sheet.vertices
    return float(np.sqrt(np.mean(np.sum(gap**2, axis=1))))
