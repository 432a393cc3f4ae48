"""Means by object, ratios and their intervals, of explorations."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from vh_drake.experiments.contenders import BEYOND, EQUAL_RADIUS, KNOWING
from vh_drake.reports import Row
from vh_drake.types import Array

_DRAWS = 10_000
_SUMMARIZED = (
    "distance_cm",
    "rotation_deg",
    "rmse_mm",
    "prediction_error_mm",
    "motions",
    "contacts_per_closing",
)


@dataclass(frozen=True, eq=False)
class Means:
    """Means over the runs of every object by every contender."""

    objects: tuple[str, ...]
    values: Mapping[str, Mapping[str, Array]]  # [contender][metric] (objects,)

    def of(self, contender: str, metric: str = "distance_cm") -> Array:
        """(objects,) means of a metric."""
        return self.values[contender][metric]


_TEXTS = ("object", "split", "contender", "seed", "end")


def object_means(rows: Sequence[Row]) -> Means:
    """Means of all numbers, with the share of runs that ended at the goal as `reached`."""
    objects = tuple(dict.fromkeys(row["object"] for row in rows))
    values: dict[str, dict[str, Array]] = {}
    for contender in dict.fromkeys(row["contender"] for row in rows):
        own = [row for row in rows if row["contender"] == contender]
        grouped = [[row for row in own if row["object"] == name] for name in objects]
        metrics = [key for key in own[0] if key not in _TEXTS]
        values[contender] = {
            key: np.array([np.mean([row[key] for row in group]) for group in grouped])
            for key in metrics
        }
        values[contender]["reached"] = np.array(
            [np.mean([row["end"] == "goal" for row in group]) for group in grouped]
        )
    return Means(objects, values)


def interval(values: Array, *, seed: int = 0) -> list[float]:
    """95 % interval of the mean by resampling (bootstrap percentiles; Efron 1979)."""
    draws = np.random.default_rng(seed).integers(0, len(values), (_DRAWS, len(values)))
    low, high = np.percentile(values[draws].mean(axis=1), [2.5, 97.5])
    return [round(float(low), 4), round(float(high), 4)]


def compared(means: Means) -> Row:
    """The metrics of table 3.5 of one split, as far as their contenders ran."""
    summary: Row = {}
    for other in means.values if "igef" in means.values else ():
        if other in BEYOND:
            cost, cost_of_igef = BEYOND[other]
            ratio = means.of(other, cost) / means.of("igef", cost_of_igef)
            summary |= _ratio(f"{other}_over_igef", ratio)
        elif other != "igef":
            summary |= _ratio(f"igef_over_{other}", means.of("igef") / means.of(other))
    for knowing in KNOWING if "gp_variance" in means.values else ():
        if knowing in means.values:
            ratio = means.of(knowing) / means.of("gp_variance")
            summary |= _ratio(f"{knowing}_over_gp_variance", ratio)
    summary |= _shortest(means, "igef_shortest_share", ("gp_variance", "random"))
    equal = (f"gp_variance{EQUAL_RADIUS}", "random")
    summary |= _shortest(means, "igef_shortest_share_equal_radius", equal)
    for contender, metrics in means.values.items():
        for metric in _SUMMARIZED:
            if metric in metrics:
                summary[f"{contender}_{metric}"] = _number(np.nanmean(metrics[metric]))
        summary[f"{contender}_contacts"] = _number(metrics["contacts"].mean())
        summary[f"{contender}_reached_share"] = _number(metrics["reached"].mean())
    reached = [metrics["reached"].mean() for metrics in means.values.values()]
    return {
        **summary,
        "reached_coverage_share": _number(min(reached)),
        "objects": len(means.objects),
    }


def _ratio(name: str, ratio: Array) -> Row:
    return {
        f"{name}_mean_ratio": _number(ratio.mean()),
        f"{name}_mean_ratio_interval": interval(ratio),
        f"{name}_median_ratio": _number(np.median(ratio)),
    }


def _shortest(means: Means, name: str, others: Sequence[str]) -> Row:
    """Share of objects on which IGEF needs the least distance in the mean."""
    if not {"igef", *others} <= set(means.values):
        return {}
    least = np.min([means.of(other) for other in others], axis=0)
    return {name: _number(np.mean(means.of("igef") < least))}


def _number(value: np.floating[Any] | float) -> float:
    return round(float(value), 4)
