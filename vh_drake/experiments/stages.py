"""`reproduce stages`: what each stage of the pipeline is worth, in paired trials.

Every variant leaves one stage out or puts another in its place, and meets the same objects, poses
and sensor noise as the whole pipeline: what differs is due to that stage. One attempt counts.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from vh_drake.catalog import Options
from vh_drake.experiments.lift_trials import (
    chosen_objects,
    run_trials,
    share,
    trial_settings,
    wilson_interval,
)
from vh_drake.experiments.robustness import scenes
from vh_drake.reports import Report, Row
from vh_drake.types import Array

SCENES = 150
WHOLE = "whole pipeline"
_DRAWS = 10_000  # of the bootstrap
_METRIC = "learned"

# Changes of the scenario by the name of the variant.
VARIANTS: Mapping[str, Mapping[str, Any]] = {
    WHOLE: {},
    "no touch": {"touches": 0},
    "rate and physical sense": {"scorer": "conventional"},
    "rate on the estimate": {"scorer": "rate"},
    "epsilon": {"scorer": "epsilon"},
    "nominal force closure": {"scorer": "nominal"},
    "surface planner only": {"planners": ["surface"]},
    "skeleton planner only": {"planners": ["skeleton"]},
    "top grasps only": {"approaches": ["collect"]},
}


def run(options: Options) -> Report:
    """The same scenes with every variant, one touch unless left out, point contact unless asked.

    Raises:
        BadInput: folder or options are unusable.
    """
    rows, settings = run_variants(VARIANTS, options, touches=1, scorer=_METRIC)
    table = variant_rows(rows, list(VARIANTS), options.seed)
    return Report("stages", settings, gains(table), {}, [*table, *rows])


def run_variants(
    variants: Mapping[str, Mapping[str, Any]], options: Options, **changes: Any
) -> tuple[list[Row], Row]:
    """Trials of the same scenes with every variant, one attempt each.

    Args:
        variants: changes of the scenario by name.
        options: objects, split, scenes, contact, seed, workers, out.
        changes: of the scenario in all variants.

    Returns:
        A row a trial with the variant's name, and the settings that the rows depend on.

    Raises:
        BadInput: folder or options are unusable.
    """
    objects, left_out = chosen_objects(options)
    count, contact = options.scenes or SCENES, options.contact or "point"
    tasks = {
        f"{name}: {item.name} {seed}": trial_settings(
            item, seed, contact, **{"attempts": 1, **changes, **variant}
        )
        for item, seed in scenes(objects, count, options.seed)  # Pairs are done side by side.
        for name, variant in variants.items()
    }
    settings = {
        "objects": [item.name for item in objects],
        "left_out": left_out,
        "variants": {name: dict(variant) for name, variant in variants.items()},
        "scenes": count,
        "seed": options.seed,
        "contact": contact,
        "attempts": 1,
        **changes,
    }
    rows = run_trials(tasks, options, settings, "lifting")
    named = [{"variant": key.split(":")[0], **row} for key, row in zip(tasks, rows, strict=True)]
    return named, settings


def variant_rows(rows: list[Row], names: Sequence[str], seed: int) -> list[Row]:
    """Success of each variant, and the first one's advantage over it."""
    whole = _outcomes(rows, names[0])
    table = []
    for name in names:
        own = [row for row in rows if row["variant"] == name]
        outcomes = _outcomes(rows, name)
        table.append(
            {
                "variant": name,
                "scenes": len(own),
                "success": round(share(own, "lifted"), 4),
                "success_interval": wilson_interval(int(outcomes.sum()), len(own)),
                "difference": round(float((whole - outcomes).mean()), 4),
                "difference_interval": paired_interval(whole, outcomes, seed),
                "only_first": int((whole > outcomes).sum()),
                "only_this": int((whole < outcomes).sum()),
            }
        )
    return table


def _outcomes(rows: list[Row], variant: str) -> Array:
    """1 where lifted, in the order of the scenes."""
    return np.array([float(row["lifted"]) for row in rows if row["variant"] == variant])


def paired_interval(a: Array, b: Array, seed: int) -> list[float]:
    """95 % interval of the mean of a - b (n,) by drawing pairs with replacement.

    Degenerate case: where no pair differs the interval is that of Wilson for 0 of n, both ways.
    """
    difference, n = a - b, len(a)
    if not difference.any():
        most = wilson_interval(0, n)[1]
        return [-most, most]
    rng = np.random.default_rng(seed)
    means = difference[rng.integers(n, size=(_DRAWS, n))].mean(axis=1)
    return [round(float(x), 4) for x in np.percentile(means, (2.5, 97.5))]


def gains(table: list[Row]) -> Row:
    """Success of the first variant, and what it gains over each other one."""
    first, *others = table
    summary: Row = {name: first[name] for name in ("scenes", "success", "success_interval")}
    for row in others:
        summary[f"gain over {row['variant']}"] = row["difference"]
        summary[f"gain over {row['variant']} interval"] = row["difference_interval"]
    return summary
