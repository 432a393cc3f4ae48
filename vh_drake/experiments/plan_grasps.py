"""Rated grasps for one view of an object, by the deciding systems alone."""

import dataclasses as dc
import time

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, Diagram

from vh_drake.errors import BadInput, NothingSeen
from vh_drake.hand.description import load_hand
from vh_drake.hand.model import HandModel, read_hand_model
from vh_drake.scenes.planning import STAGES, make_planning
from vh_drake.scenes.plant import default_hand
from vh_drake.sensing.object_points import object_points
from vh_drake.sensing.segmentation import SegmentationSettings
from vh_drake.types import (
    Candidates,
    Cloud,
    ContactSet,
    GraspScores,
    ObjectView,
    Plane,
    Surface,
)

_REACH_M = 1.0  # Points farther from the middle of the cloud are not searched
_LARGEST_SPREAD_M = 20.0  # Of most of the points
_LEAST_CAMERA_HEIGHT_M = 0.02  # Over the table


@dc.dataclass(frozen=True, eq=False)
class GraspPlan:
    """All that was found out on the way to rated grasps."""

    hand: HandModel
    view: ObjectView
    contacts: ContactSet
    surface: Surface
    candidates: Candidates
    scores: GraspScores
    ranking: tuple[int, ...]  # indices of the candidates, best first
    seconds: dict[str, float]  # wall time of each stage [s]


def plan_grasps(
    cloud: Cloud,
    *,
    contacts: ContactSet | None = None,
    table: Plane | None = None,
    hand: HandModel | None = None,
    seed: int = 0,
    weights: str = "",
) -> GraspPlan:
    """Estimates an object's surface and rates grasps on it.

    Args:
        cloud: one view in the world frame, z up: the object on its table, or with `table`
            the object alone.
        contacts: places that were touched.
        table: the plane that the object stands on.
        hand: that shall grasp; the right hand of ARMAR-6 unless given.
        seed: of every random choice; the same seed gives the same plan.
        weights: file of the learned metric, with its lift model beside it; empty: the shipped.

    Raises:
        NothingSeen: no table, or no object on it.
        BadInput: the camera is not over the table, the object is too large, contacts far
            from it, or unusable weights.
    """
    start = time.perf_counter()
    hand = hand or read_hand_model(load_hand(default_hand()))
    contacts = contacts or ContactSet()
    segmentation = None if table else widened_workspace(cloud, seed)
    diagram = make_planning(hand, seed, segmentation, weights=weights)
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    diagram.GetInputPort("contacts").FixValue(context, Value[object](contacts))
    view = _look(diagram, context, cloud, table)
    _check_camera(view)
    seconds = {"look": time.perf_counter() - start} | _serve(diagram, simulator)
    outputs = {
        name: diagram.GetOutputPort(name).Eval(context)
        for name in ("surface", "candidates", "scores", "ranking")
    }
    return GraspPlan(hand=hand, view=view, contacts=contacts, seconds=seconds, **outputs)


def widened_workspace(cloud: Cloud, seed: int = 0) -> SegmentationSettings:
    """Settings that search a user's whole cloud, up to 1 m about its middle.

    Raises:
        BadInput: the cloud is empty, or larger than any room.
    """
    if len(cloud.p_WC) == 0:
        raise BadInput("the cloud holds no points")
    spread = float(np.ptp(np.quantile(cloud.p_WC, [0.1, 0.9], axis=0), axis=0).max())
    if spread > _LARGEST_SPREAD_M:
        raise BadInput(
            f"the middle 80 % of the points are spread over {spread:.4g} m; are they in "
            "millimetres? Scale them to metres"
        )
    middle = np.median(cloud.p_WC, axis=0)
    margin = 0.05  # The object may reach the last point.
    low = np.maximum(cloud.p_WC.min(axis=0) - margin, middle - _REACH_M)
    high = np.minimum(cloud.p_WC.max(axis=0) + margin, middle + _REACH_M)
    return SegmentationSettings(workspace_min=low.tolist(), workspace_max=high.tolist(), seed=seed)


def _look(diagram: Diagram, context: Context, cloud: Cloud, table: Plane | None) -> ObjectView:
    """Feed the diagram and tell what it sees."""
    if table is not None:
        view = object_points(cloud, table)
        diagram.GetInputPort("object_view").FixValue(context, Value[object](view))
        return view
    diagram.GetInputPort("cloud").FixValue(context, Value[object](cloud))
    status: str = diagram.GetOutputPort("status").Eval(context)
    if status != "ok":
        raise NothingSeen(
            f"{status}; where the cloud holds the object alone, give its table with --table"
        )
    seen: ObjectView = diagram.GetOutputPort("object_view").Eval(context)
    return seen


def _check_camera(view: ObjectView) -> None:
    """Which side of the object is seen follows from where the camera stood."""
    if float(view.table.height(view.p_WCamera)) < _LEAST_CAMERA_HEIGHT_M:
        raise BadInput(
            f"the camera at {np.round(view.p_WCamera, 3)} m is not over the table "
            f"(at z = {_table_height(view):.3f} m); give its optical centre "
            "with --camera X Y Z, in the frame of the cloud"
        )


def _table_height(view: ObjectView) -> float:
    """Height z [m] of the table below the middle of the object."""
    x, y = view.p_WO[:, :2].mean(axis=0)
    n = view.table.normal
    return float((view.table.offset - n[0] * x - n[1] * y) / n[2])


def _serve(diagram: Diagram, simulator: Simulator) -> dict[str, float]:
    """Advance until all stages have answered; their wall times [s]."""
    context = simulator.get_context()
    seconds = {}
    for stage in STAGES:
        start = time.perf_counter()
        system = diagram.GetSubsystemByName(stage)
        served = system.GetOutputPort("served")
        while served.Eval(system.GetMyContextFromRoot(context))[0] == 0.0:
            simulator.AdvanceTo(context.get_time() + 0.005)
        seconds[stage] = time.perf_counter() - start
    return seconds
