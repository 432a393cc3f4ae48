"""Fills the caches that make a first run slow: compiled kernels, lightened meshes, fonts.

`python -m vh_drake.experiments.warm` is the last step of `make venv`.
"""

import time

from pydrake.systems.analysis import Simulator

from vh_drake.experiments.grasp_trial import make_trial
from vh_drake.experiments.judge import surface_error_mm
from vh_drake.experiments.plan_grasps import GraspPlan, plan_grasps
from vh_drake.geometry.billboard import text_billboard
from vh_drake.grasping.field import object_field
from vh_drake.grasping.motions import hand_axes, side_motion
from vh_drake.grasping.placement import way_to_contact
from vh_drake.scenes.scenario import Scenario
from vh_drake.types import Cloud

TOUCHING = "touch"  # the phase before which the first surface and the first touch are planned
LONGEST_S = 2.0  # simulated
STEP_S = 0.02


def warm(scenario: Scenario | None = None) -> None:
    """Runs a trial up to its first touch, and plans grasps on what its camera sees."""
    trial = make_trial(scenario or Scenario())
    cloud: Cloud = trial.station.GetOutputPort("cloud").Eval(
        trial.station.GetMyContextFromRoot(trial.context)
    )
    simulator = Simulator(trial.diagram, trial.context)
    context = trial.decision.GetMyContextFromRoot(trial.context)
    phase = trial.decision.GetOutputPort("phase")
    while not phase.Eval(context).startswith(TOUCHING) and trial.context.get_time() < LONGEST_S:
        simulator.AdvanceTo(trial.context.get_time() + STEP_S)
    plan = plan_grasps(cloud)
    _approach_from_the_side(plan)
    surface_error_mm(plan.surface, trial.model.mesh, trial.X_WO)
    text_billboard("ready", height_m=0.1)


def _approach_from_the_side(plan: GraspPlan) -> None:
    """What planning does for tall objects alone."""
    field = object_field(plan.surface, plan.view.table)
    way_to_contact(
        plan.hand,
        field,
        side_motion(plan.hand),
        plan.candidates.X_WH[:1],
        direction=hand_axes(plan.hand)[1],
        farthest_m=0.05,
    )


def main() -> None:
    """Warms and says how long it took."""
    start = time.perf_counter()
    print("compiling for the first run ...", flush=True)
    warm()
    print(f"ready after {time.perf_counter() - start:.0f} s")


if __name__ == "__main__":
    main()
