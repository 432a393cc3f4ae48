r"""`reproduce figure-3.13`: figures 3.13 to 3.16, exploring a function of one variable.

.. math:: f(x) = \cos(4 x) e^{-x^2 / 9} \qquad (3.58)

The variance-based explorer touches where the variance is highest, the linear one goes from left
to right. Both condition the same Gaussian process, which this package evaluates along a line in
space.
"""

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vh_drake.catalog import Options
from vh_drake.experiments.figure_files import save_figure
from vh_drake.gpis.kernels import SquaredExponential
from vh_drake.gpis.observations import Observations, value_observations
from vh_drake.gpis.posterior import Posterior, fit
from vh_drake.reports import Report, Row
from vh_drake.types import Array

STEPS = 30
SHOWN = (1, 5, 10, 30)
KERNEL = SquaredExponential(0.5, 1.0)  # σ = 1/2 of the text; numbers have no unit here
NOISE_STD = 1e-3
X = np.linspace(-5.0, 5.0, 1001)
THESIS = {"variance_halved_after_touches": 7, "variance_based_leads_after_touches": 15}
STRATEGIES = {"variance": "variance-based", "linear": "linear"}


@dataclass(frozen=True, eq=False)
class Step:
    """What is believed after a touch."""

    touched: Array  # (n,) places so far
    mean: Array  # (1001,)
    variance: Array  # (1001,)

    @property
    def mean_variance(self) -> float:
        """Average over the interval, eq. 3.59."""
        return float(self.variance.mean())

    @property
    def rmse(self) -> float:
        """Root mean squared error over the interval, eq. 3.60."""
        return float(np.sqrt(np.mean((self.mean - truth(X)) ** 2)))


def run(options: Options) -> Report:
    """Explore with both strategies; writes figure-3.13.png to figure-3.16.png."""
    runs = {name: explore(name) for name in STRATEGIES}
    for number, draw in enumerate([draw_truth, draw_variance, draw_linear, draw_errors], start=13):
        figure = Figure(figsize=(10.0, 6.0), layout="constrained")
        draw(figure, runs)
        save_figure(options.out / f"figure-3.{number}.png", figure)
    rows = [_row(name, i, step) for name, steps in runs.items() for i, step in enumerate(steps)]
    return Report("figure-3.13", {"steps": STEPS}, summary(runs), THESIS, rows)


def truth(x: Array) -> Array:
    """The function of eq. 3.58."""
    f: Array = np.cos(4.0 * x) * np.exp(-(x**2) / 9.0)
    return f


def explore(strategy: str) -> list[Step]:
    """Thirty touches by a strategy, "variance" or "linear"."""
    x = 0.0 if strategy == "variance" else X[0]
    touched: list[float] = []
    steps: list[Step] = []
    posterior: Posterior | None = None
    for count in range(1, STEPS + 1):
        touched.append(x)
        seen = observed(np.array([x]), truth(np.array([x])), NOISE_STD)
        posterior = fit(KERNEL, seen) if posterior is None else posterior.append(seen)
        line = on_line(X)
        steps.append(Step(np.array(touched), posterior.mean(line), posterior.variance(line)))
        if strategy == "variance":
            x = float(X[np.argmax(steps[-1].variance)])
        else:
            x = float(X[0] + count * (X[-1] - X[0]) / (STEPS - 1))
    return steps


def on_line(x: Array) -> Array:
    """Places (n,) as points in space (n, 3)."""
    return np.column_stack([x, np.zeros_like(x), np.zeros_like(x)])


def observed(x: Array, y: Array, noise_std: float) -> Observations:
    """Values (n,) of a function of one variable."""
    return value_observations(on_line(x), y, value_std_m=noise_std)


def summary(runs: dict[str, list[Step]]) -> dict[str, float | int]:
    """When the variance is halved, and when the variance-based error falls below the other."""
    variance, linear = runs["variance"], runs["linear"]
    halved = next(i for i, step in enumerate(variance, 1) if step.mean_variance < 0.5)
    behind = [i for i in range(5, 20) if variance[i].rmse > linear[i].rmse]  # after a fair start
    return {
        "variance_halved_after_touches": halved,
        "variance_based_leads_after_touches": max(behind, default=4) + 2,
        "rmse_variance_based_after_20": variance[19].rmse,
        "rmse_linear_after_20": linear[19].rmse,
    }


def _row(name: str, i: int, step: Step) -> Row:
    return {
        "strategy": STRATEGIES[name],
        "touches": i + 1,
        "mean_variance": step.mean_variance,
        "rmse": step.rmse,
    }


def draw_truth(figure: Figure, runs: dict[str, list[Step]]) -> None:
    """Figure 3.13."""
    axes = figure.subplots()
    axes.plot(X, truth(X), "k")
    axes.set(xlabel="x [-]", ylabel="f(x) [-]", title="Figure 3.13: the function to explore")
    axes.grid(alpha=0.3)


def draw_variance(figure: Figure, runs: dict[str, list[Step]]) -> None:
    """Figure 3.14."""
    _draw_steps(figure, runs["variance"], "Figure 3.14: touching where the variance is highest")


def draw_linear(figure: Figure, runs: dict[str, list[Step]]) -> None:
    """Figure 3.15."""
    _draw_steps(figure, runs["linear"], "Figure 3.15: touching from left to right")


def _draw_steps(figure: Figure, steps: list[Step], title: str) -> None:
    for axes, count in zip(
        figure.subplots(2, 2, sharex=True, sharey=True).flat, SHOWN, strict=True
    ):
        draw_step(axes, steps[count - 1])
        axes.set_title(f"after {count} touch{'es' if count > 1 else ''}")
        axes.set(xlabel="x [-]", ylabel="f(x) [-]")
    figure.axes[0].legend(loc="lower left", fontsize=8)
    figure.suptitle(title)


def draw_step(axes: Axes, step: Step) -> None:
    """Mean with the variance above and below it, touches, truth."""
    axes.plot(X, truth(X), "k--", lw=0.8, label="truth")
    axes.plot(X, step.mean, "tab:blue", label="mean")
    low, high = step.mean - step.variance, step.mean + step.variance
    axes.fill_between(X, low, high, color="tab:blue", alpha=0.25, label="± variance")
    axes.plot(step.touched, truth(step.touched), "o", ms=4, color="tab:red", label="touches")


def draw_errors(figure: Figure, runs: dict[str, list[Step]]) -> None:
    """Figure 3.16."""
    left, right = figure.subplots(1, 2)
    for name, label in STRATEGIES.items():
        touches = np.arange(1, STEPS + 1)
        left.plot(touches, [step.mean_variance for step in runs[name]], ".-", label=label)
        right.plot(touches, [step.rmse for step in runs[name]], ".-", label=label)
    left.set(xlabel="touches", ylabel="mean variance [-] (eq. 3.59)", ylim=(0, None))
    right.set(xlabel="touches", ylabel="RMSE [-] (eq. 3.60)", ylim=(0, None))
    left.legend()
    figure.suptitle("Figure 3.16: low variance comes early, low error later")
