"""`reproduce figure-3.24`: candidates of the skeleton-based planner on a touched object."""

from vh_drake.catalog import Options
from vh_drake.experiments.figure_3_23 import planner_figure
from vh_drake.reports import Report


def run(options: Options) -> Report:
    """Plan and draw; writes figure-3.24.png."""
    return planner_figure("figure-3.24", "skeleton", options)
