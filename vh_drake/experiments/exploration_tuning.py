"""`reproduce exploration-tuning`: which settings suit each exploration strategy best.

Every strategy is tried with the same margins of the estimate and both departure rules, times as
many values of its own parameters where it has any, on the train split. The winner has the least
geometric mean, over the objects, of the distance to the goal, among those settings with which at
least 95 % of the runs reach it, or, where there are none, nearly as many as with the best: so few
runs tell a share to five points, and one unlucky run shall not decide for a setting that costs a
third more. A run that does not reach the goal is charged in proportion to what it left unexplored.
"""

import dataclasses as dc
import math
from collections.abc import Mapping, Sequence
from itertools import product

import numpy as np

from vh_drake.batch import run_tasks
from vh_drake.catalog import Options
from vh_drake.experiments.contenders import subject
from vh_drake.experiments.exploration_trials import explored_objects
from vh_drake.exploration.choosing import DEPARTURES
from vh_drake.exploration.explorer import ExplorerSettings
from vh_drake.exploration.loop import EndSettings, explore
from vh_drake.exploration.ratings import IgefSettings
from vh_drake.exploration.strategies import (
    GpVariance,
    Igef,
    PotentialField,
    Random,
    Strategy,
    UncertaintyCost,
)
from vh_drake.exploration.tuned import RADIUS_M
from vh_drake.reports import Report, Row

RUNS = 2
MARGINS_M = (0.01, 0.03, 0.05)
REACHED_SHARE = 0.95
SHARE_ERROR = 0.05  # of so few runs
_LEAST_SHARE = 0.05

# A strategy's own parameters, and its candidate radius where the thesis leaves it open.
OWN: Mapping[str, Sequence[tuple[Strategy, float]]] = {
    "igef": [(Igef(IgefSettings(mu3_m=mu)), RADIUS_M) for mu in (0.025, 0.03, 0.035)],
    "gp_variance": [(GpVariance(), math.inf)],
    "random": [(Random(), RADIUS_M)],
    "uncertainty_cost": [
        (UncertaintyCost(theta), radius)
        for theta, radius in ((0.5, RADIUS_M), (1.0, RADIUS_M), (1.0, math.inf))
    ],
    "potential_field": [
        (PotentialField(repulsion=repulsion), radius)
        for repulsion, radius in ((0.3, RADIUS_M), (1.0, RADIUS_M), (1.0, math.inf))
    ],
}


def run(options: Options) -> Report:
    """Try all settings; one row each.

    Raises:
        BadInput: folder or options are unusable.
    """
    split = options.split or ("train" if options.objects else None)
    objects = list(explored_objects(dc.replace(options, split=split)))
    folder, runs = str(options.objects or ""), options.runs or RUNS
    grid = settings_grid()
    tasks = {
        f"{key} {name} {seed}": (key, name, folder, seed)
        for key in grid
        for name in objects
        for seed in range(options.seed, options.seed + runs)
    }
    settings: Row = {"objects": objects, "runs": runs, "seed": options.seed, "grid": list(grid)}
    costs = run_tasks(
        cost_row,
        tasks,
        settings=settings,
        journal=options.out / "tuning.jsonl",
        workers=options.workers,
        title="exploration tuning",
    )
    rows = [grid_row(key, [cost for cost in costs if cost["key"] == key]) for key in grid]
    return Report("exploration-tuning", settings, winners(rows), {}, rows)


def settings_grid() -> dict[str, ExplorerSettings]:
    """All settings that are tried, by a name that says what is in them."""
    grid = {}
    for name, own in OWN.items():
        for (strategy, radius), margin, departure in product(own, MARGINS_M, DEPARTURES):
            settings = ExplorerSettings(
                strategy, candidate_radius_m=radius, margin_m=margin, departure=departure
            )
            words = f"{name}: {strategy!r}, radius {radius:g} m, margin {margin:g} m, {departure}"
            grid[words] = settings
    return grid


def cost_row(task: tuple[str, str, str, int]) -> Row:
    """Distance of one exploration, charged where it did not reach the goal [cm]."""
    key, name, folder, seed = task
    result = explore(subject(name, folder).body, settings_grid()[key], seed=seed)
    missing = max(1.0, EndSettings().goal / max(float(result.shares[-1]), _LEAST_SHARE))
    return {
        "key": key,
        "object": name,
        "cost_cm": round(100.0 * float(result.lengths_m[-1]) * missing, 4),
        "reached": result.end == "goal",
    }


def grid_row(key: str, costs: Sequence[Row]) -> Row:
    """What one setting costs."""
    objects = dict.fromkeys(cost["object"] for cost in costs)
    means = [np.mean([c["cost_cm"] for c in costs if c["object"] == name]) for name in objects]
    return {
        "strategy": key.partition(":")[0],
        "setting": key.partition(": ")[2],
        "cost_cm": round(float(np.exp(np.mean(np.log(means)))), 3),
        "reached_share": round(float(np.mean([cost["reached"] for cost in costs])), 4),
    }


def winners(rows: Sequence[Row]) -> Row:
    """The best setting of each strategy, its cost, and how many of its runs reach the goal."""
    summary: Row = {}
    for name in OWN:
        own = [row for row in rows if row["strategy"] == name]
        enough = min(REACHED_SHARE, max(row["reached_share"] for row in own) - SHARE_ERROR)
        good = [row for row in own if row["reached_share"] >= enough]
        best = min(good, key=lambda row: row["cost_cm"])
        summary |= {f"{name}_{key}": best[key] for key in ("cost_cm", "reached_share", "setting")}
    return summary
