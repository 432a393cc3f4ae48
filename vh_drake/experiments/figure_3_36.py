"""`reproduce figure-3.36`: how far predicted and actual contacts are apart, by strategy."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vh_drake.catalog import Options
from vh_drake.experiments.example_objects import STRATEGIES, Task, example_runs, explored_rows
from vh_drake.experiments.exploration_pictures import COLORS, label
from vh_drake.experiments.figure_files import save_figure
from vh_drake.reports import Report, Row


def run(options: Options) -> Report:
    """Explore three objects; writes figure-3.36.png.

    Raises:
        BadInput: the folder of objects is unusable.
    """
    settings, rows = explored_rows(error_row, options, journal="errors.jsonl", title="figure 3.36")
    figure = Figure(figsize=(7.5, 5.0), layout="constrained")
    draw_errors(figure.subplots(), rows)
    save_figure(options.out / "figure-3.36.png", figure)
    return Report("figure-3.36", settings, summary(rows), {}, rows)


def error_row(task: Task) -> Row:
    """Mean distance of predicted and actual contacts of one exploration [mm]."""
    name, folder, strategy, seed = task
    (result,) = example_runs(name, folder, strategy, [seed])
    touches = [step.touch for step in result.steps]
    errors = [1e3 * float(np.linalg.norm(touch.p_WT - touch.p_WC)) for touch in touches]
    mean = round(float(np.mean(errors)), 4)
    return {"object": name, "strategy": strategy, "seed": seed, "prediction_error_mm": mean}


def errors_of(rows: list[Row], name: str, strategy: str) -> list[float]:
    """Errors of the runs of one object by one strategy [mm]."""
    return [
        row["prediction_error_mm"]
        for row in rows
        if row["object"] == name and row["strategy"] == strategy
    ]


def summary(rows: list[Row]) -> dict[str, float]:
    """Means over the runs."""
    return {
        f"{name}_{strategy}_mm": round(float(np.mean(errors_of(rows, name, strategy))), 3)
        for name in dict.fromkeys(row["object"] for row in rows)
        for strategy in STRATEGIES
    }


def draw_errors(axes: Axes, rows: list[Row]) -> None:
    """Bars with the standard deviation over the runs."""
    names = list(dict.fromkeys(row["object"] for row in rows))
    width = 0.8 / len(STRATEGIES)
    for i, strategy in enumerate(STRATEGIES):
        errors = [errors_of(rows, name, strategy) for name in names]
        at = np.arange(len(names)) + (i - 1) * width
        mean, spread = [np.mean(e) for e in errors], [np.std(e) for e in errors]
        color = COLORS[strategy]
        axes.bar(at, mean, width, yerr=spread, capsize=3, color=color, label=label(strategy))
    axes.set_xticks(range(len(names)), names)
    axes.set(ylabel="distance of predicted and actual contact [mm]", ylim=(0, None))
    axes.set_title("Figure 3.36: means of the runs, with their standard deviation")
    axes.legend()
