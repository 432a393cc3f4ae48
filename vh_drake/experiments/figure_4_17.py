"""`reproduce figure-4.17`: the finger's shape for several shortenings of the tendon."""

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vh_drake.catalog import Options
from vh_drake.experiments.figure_files import save_figure
from vh_drake.hand.tendon_finger import SEGMENT_LENGTHS_M, thesis_finger
from vh_drake.reports import Report, Row
from vh_drake.types import Array

SHARES = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)
ENDS = ("medial", "distal", "tip")  # At the end of each segment


def run(options: Options) -> Report:
    """Segments of table 4.4 at angles of the model; writes figure-4.17.png."""
    finger = thesis_finger()
    angles = finger.equilibrium(np.array(SHARES) * finger.closed_m).angles
    rows = [shape_row(share, own) for share, own in zip(SHARES, angles, strict=True)]
    figure = Figure(figsize=(7.0, 5.0), layout="constrained")
    draw_shapes(figure.subplots(), rows)
    save_figure(options.out / "figure-4.17.png", figure)
    summary = {
        "open_length_mm": rows[0]["tip_x_mm"],
        "closed_tip_x_mm": rows[-1]["tip_x_mm"],
        "closed_tip_y_mm": rows[-1]["tip_y_mm"],
    }
    return Report("figure-4.17", {"shares": SHARES}, summary, {}, rows)


def segment_ends(angles: Array) -> Array:
    """Points (4, 2) from the proximal joint to the tip [m]: x along the open finger, y closing."""
    directions = np.cumsum(angles)
    steps = SEGMENT_LENGTHS_M[:, None] * np.column_stack([np.cos(directions), np.sin(directions)])
    return np.vstack([np.zeros(2), np.cumsum(steps, axis=0)])


def shape_row(share: float, angles: Array) -> Row:
    """Where the ends of the segments are."""
    ends = 1e3 * segment_ends(angles)[1:]
    row: Row = {"share": share}
    for name, (x, y) in zip(ENDS, ends, strict=True):
        row |= {f"{name}_x_mm": round(float(x), 4), f"{name}_y_mm": round(float(y), 4)}
    return row


def draw_shapes(axes: Axes, rows: list[Row]) -> None:
    """The finger as a chain for each shortening."""
    for i, row in enumerate(rows):
        x = [0.0, *(row[f"{name}_x_mm"] for name in ENDS)]
        y = [0.0, *(row[f"{name}_y_mm"] for name in ENDS)]
        color = colormaps["viridis"](0.9 * i / (len(rows) - 1))
        label = f"{100 * row['share']:.0f} %"
        axes.plot(x, y, "o-", color=color, lw=3, ms=7, label=label)
    axes.set(xlabel="along the open finger [mm]", ylabel="towards the palm's side [mm]")
    axes.set(title="Shapes of the finger; in the legend the share of 45 mm of tendon")
    axes.set_aspect("equal")
    axes.grid(alpha=0.3)
    axes.legend(loc="upper right")
