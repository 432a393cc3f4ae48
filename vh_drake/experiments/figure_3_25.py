"""`reproduce figure-3.25`: two touched objects, two hands, both planners."""

from collections.abc import Sequence

from matplotlib.figure import Figure

from vh_drake.catalog import Options
from vh_drake.experiments.figure_files import save_figure
from vh_drake.experiments.grasp_gallery import draw_grasp, grasp_title
from vh_drake.experiments.touched_grasps import (
    Planned,
    candidate_rows,
    plan_figures,
    planned,
    shown,
    touched_object,
)
from vh_drake.grasping.planner_settings import PLANNERS
from vh_drake.hand.description import load_hand
from vh_drake.hand.model import read_hand_model
from vh_drake.hand.shipped import hand_file
from vh_drake.reports import Report

OBJECTS = ("bottle", "spray_bottle")
HANDS = ("armar3_right", "armar6_right")


def run(options: Options) -> Report:
    """Plan everything and draw one grasp of each; writes figure-3.25.png."""
    plans = plan_all(OBJECTS, HANDS, options.seed)
    figure = Figure(figsize=(15.0, 8.0), layout="constrained")
    draw_plans(figure, plans, len(HANDS))
    figure.suptitle(
        "Figure 3.25: the same touched surfaces for both hands, by both planners. "
        "Palm dark, thumb blue, contacts red; the bar is 5 cm long"
    )
    save_figure(options.out / "figure-3.25.png", figure)
    summary = {
        f"{plan.touched.name}_{plan.hand.description.name}_{plan.planner}_{metric}": value
        for plan in plans
        for metric, value in plan_figures(plan).items()
    }
    settings = {"objects": list(OBJECTS), "hands": list(HANDS), "seed": options.seed}
    return Report("figure-3.25", settings, summary, {}, candidate_rows(plans))


def plan_all(objects: Sequence[str], hands: Sequence[str], seed: int) -> list[Planned]:
    """Hand by hand, object by object, planner by planner."""
    surfaces = [touched_object(name, seed) for name in objects]
    models = [read_hand_model(load_hand(hand_file(name))) for name in hands]
    return [
        planned(touched, hand, planner, seed)
        for hand in models
        for touched in surfaces
        for planner in PLANNERS
    ]


def draw_plans(figure: Figure, plans: Sequence[Planned], lines: int) -> None:
    """A row of pictures for each hand."""
    columns = len(plans) // lines
    for place, plan in enumerate(plans):
        axes = figure.add_subplot(lines, columns, place + 1, projection="3d")
        title = f"{plan.touched.name}, {plan.hand.description.name}, {plan.planner}"
        best = shown(plan, 1)
        if len(best):
            draw_grasp(axes, plan, int(best[0]))
            title += f"\n{grasp_title(plan, int(best[0]))}"
        else:
            title += "\nno stable candidate"
        axes.set_title(title, fontsize=10)
