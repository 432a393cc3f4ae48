"""`reproduce figure-3.23`: candidates of the surface-based planner on a touched object."""

from matplotlib.figure import Figure

from vh_drake.catalog import Options
from vh_drake.experiments.figure_files import save_figure
from vh_drake.experiments.grasp_gallery import draw_planner
from vh_drake.experiments.touched_grasps import (
    candidate_rows,
    plan_figures,
    planned,
    touched_object,
)
from vh_drake.hand.description import load_hand
from vh_drake.hand.model import read_hand_model
from vh_drake.hand.shipped import DEFAULT_HAND, hand_file
from vh_drake.reports import Report

OBJECT = "bottle"


def run(options: Options) -> Report:
    """Plan and draw; writes figure-3.23.png."""
    return planner_figure("figure-3.23", "surface", options)


def planner_figure(name: str, planner: str, options: Options) -> Report:
    """Plan with one planner, draw all candidates and some hands; writes <name>.png."""
    touched = touched_object(OBJECT, options.seed)
    hand = read_hand_model(load_hand(hand_file(DEFAULT_HAND)))
    plan = planned(touched, hand, planner, options.seed)
    figure = Figure(figsize=(14.0, 7.0), layout="constrained")
    draw_planner(figure, plan)
    number = name.removeprefix("figure-")
    figure.suptitle(
        f"Figure {number}: grasps of the {planner}-based planner on a touched {OBJECT}. "
        "Palm dark, thumb blue, contacts red; the bar is 5 cm long"
    )
    save_figure(options.out / f"{name}.png", figure)
    settings = {
        "object": OBJECT,
        "hand": DEFAULT_HAND,
        "planner": planner,
        "contacts": len(touched.contacts),
        "seed": options.seed,
    }
    return Report(name, settings, plan_figures(plan), {}, candidate_rows([plan]))
