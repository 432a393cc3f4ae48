"""`reproduce figure-3.37`: surface area over distance, one dot a run, with regressions."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vh_drake.catalog import Options
from vh_drake.experiments.example_objects import STRATEGIES
from vh_drake.experiments.exploration_pictures import COLORS, label
from vh_drake.experiments.exploration_trials import RUNS, explored_objects, run_explorations
from vh_drake.experiments.figure_files import save_figure
from vh_drake.reports import Report, Row
from vh_drake.types import Array


def run(options: Options) -> Report:
    """Explore every object; writes figure-3.37.png.

    Raises:
        BadInput: folder or options are unusable.
    """
    objects = explored_objects(options)
    settings, rows = run_explorations(options, objects, STRATEGIES, runs=options.runs or RUNS)
    figure = Figure(figsize=(8.0, 6.0), layout="constrained")
    draw(figure.subplots(), rows)
    save_figure(options.out / "figure-3.37.png", figure)
    return Report("figure-3.37", settings, summary(rows), {}, rows)


def distance_and_area(rows: list[Row], strategy: str) -> Array:
    """(2, n) distances [cm] and surface areas [cm²] of the runs of a strategy."""
    own = [row for row in rows if row["contender"] == strategy]
    return np.array([[row["distance_cm"], row["area_cm2"]] for row in own]).T


def regression(distance: Array, area: Array) -> tuple[float, float, float]:
    """Slope [cm], offset [cm] of distance = slope * area + offset by least squares, and R²."""
    slope, offset = np.polyfit(area, distance, 1)
    rest = distance - slope * area - offset
    spread = float(np.sum((distance - distance.mean()) ** 2))
    return float(slope), float(offset), 1.0 - float(rest @ rest) / max(spread, 1e-12)


def summary(rows: list[Row]) -> dict[str, float]:
    """Slopes per 100 cm², offsets, and what the regression explains."""
    figures = {}
    for strategy in STRATEGIES:
        slope, offset, r2 = regression(*distance_and_area(rows, strategy))
        figures[f"{strategy}_cm_per_100_cm2"] = round(100.0 * slope, 3)
        figures[f"{strategy}_offset_cm"] = round(offset, 3)
        figures[f"{strategy}_r2"] = round(r2, 4)
    return figures


def draw(axes: Axes, rows: list[Row]) -> None:
    """Dots and regression lines; what lies left is explored on shorter ways."""
    for strategy in STRATEGIES:
        distance, area = distance_and_area(rows, strategy)
        slope, offset, _ = regression(distance, area)
        axes.plot(distance, area, ".", color=COLORS[strategy], ms=4, alpha=0.5)
        ends = np.array([area.min(), area.max()])
        line = slope * ends + offset
        axes.plot(line, ends, color=COLORS[strategy], lw=2.5, label=label(strategy))
    axes.set(xlabel="distance to 80 % coverage [cm]", ylabel="surface area [cm²]")
    axes.set(xlim=(0, None), ylim=(0, None))
    axes.set_title("Figure 3.37: one dot a run, lines by linear regression")
    axes.legend()
