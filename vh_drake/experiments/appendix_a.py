"""`reproduce appendix-a`: the distances of table 3.5 by object, beside those of the thesis.

The thesis's distances in appendix A and the averages of its table 3.5 differ by a factor of two, so
that only ratios between strategies are compared.
"""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vh_drake.catalog import Options
from vh_drake.experiments.contenders import chosen_contenders
from vh_drake.experiments.exploration_statistics import compared, object_means
from vh_drake.experiments.exploration_trials import RUNS, explored_objects, run_explorations
from vh_drake.experiments.figure_files import save_figure
from vh_drake.experiments.table_3_5 import by_split, thesis
from vh_drake.experiments.thesis_appendix_a import thesis_row
from vh_drake.reports import Report, Row

_METRICS = ("distance_cm", "rotation_deg", "rmse_mm", "prediction_error_mm", "contacts", "reached")


def run(options: Options) -> Report:
    """Explore every object; writes appendix-a.png. The same explorations as of table-3.5.

    Raises:
        BadInput: folder or options are unusable.
        UnknownName: a strategy.
    """
    objects = explored_objects(options)
    contenders = chosen_contenders(options.strategies)
    settings, rows = run_explorations(options, objects, contenders, runs=options.runs or RUNS)
    table = [row for split in by_split(rows) for row in object_rows(rows, split)]
    figure = Figure(figsize=(7.0, 6.0), layout="constrained")
    draw_ratios(figure.subplots(), table)
    save_figure(options.out / "appendix-a.png", figure)
    return Report("appendix-a", settings, compared(object_means(rows)), thesis(), table)


def object_rows(rows: list[Row], split: str) -> list[Row]:
    """One row an object: every contender's means, ratios, and what the thesis has of it."""
    means = object_means([row for row in rows if row["split"] == split])
    table: list[Row] = []
    for i, name in enumerate(means.objects):
        row: Row = {"object": name, "split": split}
        for contender, metrics in means.values.items():
            row |= {
                f"{contender}_{metric}": round(float(metrics[metric][i]), 4)
                for metric in _METRICS
                if metric in metrics
            }
        table.append(row | _ratios(row) | _thesis_columns(name))
    return table


def _ratios(row: Row) -> Row:
    pairs = [(o, f"{o}_distance_cm") for o in ("gp_variance", "random")]
    if "igef_distance_cm" not in row:
        return {}
    igef = row["igef_distance_cm"]
    return {f"igef_over_{o}": round(igef / row[key], 4) for o, key in pairs if key in row}


def _thesis_columns(name: str) -> Row:
    known = thesis_row(name)
    if known is None:
        return dict.fromkeys(
            [f"thesis_{key}" for key in ("igef_cm", "gp_variance_cm", "random_cm")]
            + ["thesis_igef_over_gp_variance", "thesis_igef_over_random"]
        )
    return {
        "thesis_igef_cm": known.igef_cm,
        "thesis_gp_variance_cm": known.gp_variance_cm,
        "thesis_random_cm": known.random_cm,
        "thesis_igef_over_gp_variance": round(known.igef_cm / known.gp_variance_cm, 4),
        "thesis_igef_over_random": round(known.igef_cm / known.random_cm, 4),
    }


def draw_ratios(axes: Axes, table: list[Row]) -> None:
    """Our ratios over the thesis's, one dot an object that both explored."""
    for other, color in (("gp_variance", "tab:orange"), ("random", "tab:blue")):
        key = f"igef_over_{other}"
        both = [row for row in table if row.get(f"thesis_{key}") and row.get(key)]
        ours, theirs = ([row[k] for row in both] for k in (key, f"thesis_{key}"))
        axes.plot(theirs, ours, "o", color=color, label=f"IGEF / {other.replace('_', ' ')}")
    axes.plot([0, 1.5], [0, 1.5], "--", color="0.6", label="equal")
    axes.axhline(1.0, color="0.8", lw=1)
    axes.set(xlabel="ratio of distances in the thesis", ylabel="ratio of distances here")
    axes.set(xlim=(0, 1.0), ylim=(0, max(1.1, *_largest(table))))
    axes.set_title("Appendix A: what IGEF needs of another strategy's distance, by object")
    axes.legend()


def _largest(table: list[Row]) -> list[float]:
    keys = ("igef_over_gp_variance", "igef_over_random")
    return [1.05 * float(np.max([row.get(key) or 0.0 for row in table])) for key in keys]
