"""`reproduce figure-4.7`: precision of the learned metric and of the baselines, by object."""

import dataclasses as dc
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vh_drake.atomic_files import write_bytes
from vh_drake.catalog import Options
from vh_drake.experiments.metric_scenes import judged_scenes
from vh_drake.experiments.ungraspable import searched_poses
from vh_drake.learning.calibration import reliability
from vh_drake.learning.evaluating import (
    METRICS,
    THRESHOLD,
    Judged,
    by,
    group_rows,
    mean_precision,
    pooled,
    precision_at,
    summarize,
    top1,
)
from vh_drake.learning.pictures import draw_reliability, png
from vh_drake.reports import Report, Row

THESIS = {"learned_precision": 0.95, "nominal_precision": 0.65, "failure_ratio": 7.0}
_COLORS = {
    "learned": "tab:blue",
    "blind": "tab:cyan",
    "rate": "tab:green",
    "epsilon": "tab:purple",
    "nominal": "tab:orange",
}
LABELS = {
    "learned": "learned",
    "blind": "learned, without the rate on the estimate",
    "rate": "rate on the estimate",
    "epsilon": "epsilon",
    "nominal": "force closure on the estimate",
}


def run(options: Options) -> Report:
    """Let all metrics rate the candidates of objects that none has learnt from.

    Raises:
        BadInput: an option is unusable.
    """
    scenes, settings = judged_scenes(options)
    searched = searched_poses(scenes, options, settings)
    figures = report(scenes, settings, options)
    summary = {**figures.summary, **possible(scenes, searched)}
    return dc.replace(figures, summary=summary, rows=[*figures.rows, *searched])


def possible(scenes: Sequence[Judged], searched: Sequence[Row]) -> Row:
    """Top-1 success against what this hand can reach at most.

    Args:
        scenes: all of them.
        searched: of `searched_poses`.
    """
    hopeless = {scene for row in searched if not row["graspable"] for scene in row["scenes_alike"]}
    others = [scene for scene in scenes if scene.scene not in hopeless]
    best = top1(others, "learned")
    return {
        "top1_ceiling": round(len(others) / len(scenes), 4),
        "top1_success_below_ceiling": None if best is None else round(best, 4),
        "scenes_without_any_grasp_on_truth": len(hopeless),
    }


def report(
    scenes: Sequence[Judged], settings: Row, options: Options, *, name: str = "figure-4.7"
) -> Report:
    """The report of judged scenes; writes a figure of that name."""
    split = settings["split"]
    by_object = group_rows(scenes, "object", lambda scene: scene.object)
    rows = [{**row, "split": split} for row in by_object]
    rows += group_rows(scenes, "touches", lambda scene: scene.touches)
    summary = {
        **summarize(scenes, options.seed),
        "objects": len(by_object),
        "objects_not_worse_than_nominal": _not_worse(scenes),
        "scenes": len(scenes),
        "candidates": int(sum(len(scene.success) for scene in scenes)),
    }
    write_bytes(options.out / f"{name}.png", draw(by_object, scenes))
    return Report(name, settings, summary, THESIS, rows)


def draw(rows: Sequence[Row], scenes: Sequence[Judged]) -> bytes:
    """Bars by object, precision over the share selected, and reliability."""
    figure = Figure(figsize=(13.0, 9.0), layout="constrained")
    places = figure.subplot_mosaic([["bars", "bars"], ["curve", "reliable"]])
    draw_bars(places["bars"], rows)
    draw_precision(places["curve"], scenes)
    every = pooled(scenes)
    diagrams = {
        LABELS[name]: reliability(every.scores[name], every.success) for name in ("learned", "rate")
    }
    draw_reliability(places["reliable"], diagrams)
    return png(figure)


def draw_bars(axes: Axes, rows: Sequence[Row]) -> None:
    """Precision of what each metric selects, by object; nothing where it selects nothing."""
    names = ("learned", "rate", "nominal")
    places, width = np.arange(len(rows)), 0.8 / len(names)
    for i, name in enumerate(names):
        heights = [100 * (row[f"{name}_precision"] or 0.0) for row in rows]
        label = LABELS[name] if name == "nominal" else f"{LABELS[name]} > {THRESHOLD:g}"
        axes.bar(places + (i - 1) * width, heights, width, color=_COLORS[name], label=label)
    axes.set_xticks(places, [str(row["object"]) for row in rows], rotation=20, ha="right")
    axes.set(
        ylabel="selected grasps that succeed [%]",
        ylim=(0, 118),
        title="By object; no bar: nothing selected",
    )
    axes.legend(loc="upper right", ncols=len(names))


def draw_precision(axes: Axes, scenes: Sequence[Judged]) -> None:
    """Precision over the share of candidates that a metric may select."""
    every = pooled(scenes)
    shares = np.linspace(0.02, 1.0, 50)
    for name in METRICS:
        values = [100 * (precision_at(every, name, share) or 0.0) for share in shares]
        axes.plot(100 * shares, values, color=_COLORS[name], label=LABELS[name])
    axes.set(
        xlabel="best rated candidates that are selected [%]",
        ylabel="of these, succeed [%]",
        xlim=(0, 100),
        title="All candidates",
    )
    axes.legend(loc="lower left")


def _not_worse(scenes: Sequence[Judged]) -> int:
    """Of how many objects the learned metric's precision is not below force closure's."""
    count = 0
    for own in by(scenes, lambda scene: scene.object).values():
        learned, nominal = mean_precision(own, "learned"), mean_precision(own, "nominal")
        count += learned is not None and learned >= (nominal or 0.0)
    return count
