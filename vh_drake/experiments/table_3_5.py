"""`reproduce table-3.5`: what exploring costs by each strategy, on all objects of a folder.

In the thesis's setting IGEF and chance choose among candidates within R_0 = 5 cm of the last
contact, and the variance of the Gaussian process among all; with equal radii all choose within
R_0. Every strategy has the settings that suited it best on the train split
(`vh_drake.exploration.tuned`), and ends by the same rules. A run that does not reach the goal
counts with the distance that it used.

`--strategies shortest_way,igef_knowing,gp_variance,igef` sets two beside them that know the object:
a way that was planned on it (`vh_drake.exploration.shortest_way`), for no strategy could save much
more, and IGEF that rates the true surface (`vh_drake.exploration.knowing_strategy`), for no better
estimate could do so.
"""

import dataclasses as dc

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vh_drake.catalog import Options
from vh_drake.experiments.contenders import chosen_contenders
from vh_drake.experiments.exploration_pictures import COLORS, label
from vh_drake.experiments.exploration_statistics import Means, compared, object_means
from vh_drake.experiments.exploration_trials import (
    RESULT_SPLIT,
    RUNS,
    explored_objects,
    run_explorations,
)
from vh_drake.experiments.figure_files import save_figure
from vh_drake.experiments.thesis_appendix_a import TABLE_3_5, appendix_a
from vh_drake.exploration.tuned import TUNED
from vh_drake.reports import Report, Row


def run(options: Options) -> Report:
    """Explore every object; writes table-3.5.png.

    The summary is the test split's where there is one; that of the train split stands beside it,
    its metrics begin with `train_`.

    Raises:
        BadInput: folder or options are unusable.
        UnknownName: a strategy.
    """
    objects = explored_objects(options)
    contenders = chosen_contenders(options.strategies)
    settings, rows = run_explorations(options, objects, contenders, runs=options.runs or RUNS)
    parts = by_split(rows)
    result = RESULT_SPLIT if RESULT_SPLIT in parts else next(iter(parts))
    summary: Row = compared(parts[result])
    for split, means in parts.items():
        if split != result:
            summary |= {f"{split or 'other'}_{key}": v for key, v in compared(means).items()}
    figure = Figure(figsize=(9.0, 2.8 + 0.3 * len(parts[result].objects)), layout="constrained")
    draw_distances(figure.subplots(), parts[result])
    save_figure(options.out / "table-3.5.png", figure)
    return Report("table-3.5", {**settings, "split": result}, summary, thesis(), rows)


def by_split(rows: list[Row]) -> dict[str, Means]:
    """Means of the objects of each split."""
    splits = dict.fromkeys(row["split"] for row in rows)
    return {split: object_means([row for row in rows if row["split"] == split]) for split in splits}


def thesis() -> dict[str, float]:
    """The same metrics of table 3.5; ratios and shares from the rows of appendix A."""
    rows = [dc.astuple(row) for row in appendix_a().values()]
    random, variance, igef = np.array(rows).T
    return {
        "igef_over_gp_variance_mean_ratio": round(float(np.mean(igef / variance)), 4),
        "igef_over_random_mean_ratio": round(float(np.mean(igef / random)), 4),
        "igef_shortest_share": float(np.mean(igef < np.minimum(random, variance))),
        **TABLE_3_5,
    }


def draw_distances(axes: Axes, means: Means) -> None:
    """One line an object, the largest on top, with each contender's mean distance."""
    order = np.argsort(next(iter(means.values.values()))["area_cm2"])
    places = np.arange(len(order))
    for contender, metrics in means.values.items():
        if "distance_cm" in metrics:
            marker = "o" if contender in TUNED else "x"
            color = COLORS.get(contender, "0.5")
            distances = metrics["distance_cm"][order]
            axes.plot(distances, places, marker, color=color, label=label(contender))
    axes.set_yticks(places, [means.objects[i] for i in order])
    axes.set_xscale("log")
    axes.set(xlabel="distance to 80 % coverage, mean of the runs [cm]")
    axes.set_title("Table 3.5: what exploring an object costs; objects by surface area")
    axes.grid(axis="x", which="both", alpha=0.3)
    axes.figure.legend(loc="outside lower center", ncols=2)
