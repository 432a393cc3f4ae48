r"""`reproduce figure-3.1`: figures 3.1 to 3.3, exploring a plane greedily or with balance.

The region A is a square of 5 cm. The greedy strategy touches the place that is farthest from all
touched ones. The balanced one weighs what it gains by what it travels, by the metrics Ψ1 to Ψ3 of
section 3.3.2 with lengths that suit the region. Coverage is the mean distance to the nearest
touch:

.. math:: D = \frac{1}{|A|} \sum_{x \in A} \min_{c \in C} |x - c| \qquad (3.1)
"""

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from scipy.spatial.distance import cdist

from vh_drake.catalog import Options
from vh_drake.experiments.figure_files import save_figure
from vh_drake.exploration.ratings import locality, travel, uncertainty
from vh_drake.reports import Report, Row
from vh_drake.types import Array

SIDE_M = 0.05
NODES = 51  # a side of the region
TOUCHES = 30
SHOWN = (5, 10, 15, 20, 25, 30)
STRATEGIES = ("greedy", "balanced")
SIGMA1_M, MU3_M, SIGMA3_M = 0.02, 0.0095, 0.002  # for steps of about a fifth of the region
_CM = 100.0


@dataclass(frozen=True, eq=False)
class Progress:
    """Touches of a strategy, in order."""

    p: Array  # (n, 2) [m]

    @property
    def lengths_m(self) -> Array:
        """(n,) distance covered after each touch [m]; none to the first."""
        steps = np.linalg.norm(np.diff(self.p, axis=0), axis=1)
        return np.concatenate([[0.0], np.cumsum(steps)])

    def coverage_m(self, count: int) -> float:
        """D of eq. 3.1 after some touches [m]."""
        return float(distance_to_touches(self.p[:count]).mean())


def run(options: Options) -> Report:
    """Explore with both strategies; writes figure-3.1.png to figure-3.3.png."""
    runs = {name: explore(name) for name in STRATEGIES}
    figure = Figure(figsize=(15.0, 5.6), layout="constrained")
    draw_snapshots(figure, runs)
    save_figure(options.out / "figure-3.1.png", figure)
    for number, draw in ((2, draw_lengths), (3, draw_coverage)):
        figure = Figure(figsize=(7.0, 5.0), layout="constrained")
        draw(figure.subplots(), runs)
        save_figure(options.out / f"figure-3.{number}.png", figure)
    rows = [
        row(name, progress, i) for name, progress in runs.items() for i in range(1, TOUCHES + 1)
    ]
    settings = {"side_m": SIDE_M, "touches": TOUCHES, "sigma1_m": SIGMA1_M, "mu3_m": MU3_M}
    return Report("figure-3.1", settings, summary(runs), {}, rows)


def region() -> Array:
    """All places (NODES², 2) that may be touched [m]."""
    side = np.linspace(0.0, SIDE_M, NODES)
    return np.stack(np.meshgrid(side, side, indexing="ij"), axis=-1).reshape(-1, 2)


def distance_to_touches(p: Array) -> Array:
    """Distance of every place of the region to the nearest touch (NODES²,) [m]."""
    nearest: Array = cdist(region(), p).min(axis=1)
    return nearest


def rate(strategy: str, p: Array) -> Array:
    """Rating of every place of the region (NODES²,) after touches (n, 2)."""
    if strategy == "greedy":
        return distance_to_touches(p)
    places = region()
    rating: Array = (
        uncertainty(places, p, sigma1_m=SIGMA1_M)
        * locality(places, p, mu3_m=MU3_M, sigma3_m=SIGMA3_M)
        * travel(np.linalg.norm(places - p[-1], axis=1))
    )
    return rating


def explore(strategy: str) -> Progress:
    """Algorithm 1, from the centre of the region."""
    p = np.full((1, 2), 0.5 * SIDE_M)
    while len(p) < TOUCHES:
        p = np.vstack([p, region()[np.argmax(rate(strategy, p))]])
    return Progress(p)


def row(name: str, progress: Progress, count: int) -> Row:
    """State of a strategy after some touches."""
    return {
        "strategy": name,
        "touches": count,
        "path_mm": 1e3 * float(progress.lengths_m[count - 1]),
        "mean_distance_mm": 1e3 * progress.coverage_m(count),
    }


def summary(runs: dict[str, Progress]) -> dict[str, float]:
    """Path and coverage of both at the end."""
    figures = {}
    for name, progress in runs.items():
        figures[f"{name}_path_mm"] = 1e3 * float(progress.lengths_m[-1])
        figures[f"{name}_mean_distance_mm"] = 1e3 * progress.coverage_m(TOUCHES)
    figures["path_ratio"] = figures["balanced_path_mm"] / figures["greedy_path_mm"]
    return figures


def draw_snapshots(figure: Figure, runs: dict[str, Progress]) -> None:
    """Figure 3.1."""
    grid = figure.subplots(len(runs), len(SHOWN), sharex=True, sharey=True)
    for line, (name, progress) in zip(grid, runs.items(), strict=True):
        for axes, count in zip(line, SHOWN, strict=True):
            image = draw_snapshot(axes, progress.p[:count])
            axes.set_title(f"{name}, {count} touches", fontsize=10)
        line[0].set_ylabel("y [cm]")
    for axes in grid[-1]:
        axes.set_xlabel("x [cm]")
    figure.colorbar(image, ax=grid, label="distance to the nearest touch [mm]")
    figure.suptitle("Figure 3.1: exploring a square for information alone, and for its price")


def draw_snapshot(axes: Axes, p: Array) -> AxesImage:
    """Touches, the way between them, and the uncertainty below."""
    image = axes.imshow(
        1e3 * distance_to_touches(p).reshape(NODES, NODES).T,
        origin="lower",
        extent=(0.0, _CM * SIDE_M, 0.0, _CM * SIDE_M),
        vmin=0.0,
        vmax=20.0,
    )
    axes.plot(_CM * p[:, 0], _CM * p[:, 1], "w-", lw=0.8)
    axes.plot(_CM * p[:, 0], _CM * p[:, 1], "o", color="tab:red", ms=4, clip_on=False)
    return image


def draw_lengths(axes: Axes, runs: dict[str, Progress]) -> None:
    """Figure 3.2."""
    for (name, progress), color in zip(runs.items(), ("tab:red", "tab:green"), strict=True):
        axes.plot(range(1, TOUCHES + 1), _CM * progress.lengths_m, ".-", color=color, label=name)
    axes.set(xlabel="touches", ylabel="path [cm]", title="Figure 3.2: what the touches cost")
    axes.legend()


def draw_coverage(axes: Axes, runs: dict[str, Progress]) -> None:
    """Figure 3.3."""
    touches = range(1, TOUCHES + 1)
    for (name, progress), color in zip(runs.items(), ("tab:red", "tab:green"), strict=True):
        coverage = [1e3 * progress.coverage_m(count) for count in touches]
        axes.plot(touches, coverage, ".-", color=color, label=name)
    axes.set(xlabel="touches", ylabel="D [mm]", ylim=(0, None))
    axes.set_title("Figure 3.3: mean distance to the nearest touch, eq. 3.1")
    axes.legend()
