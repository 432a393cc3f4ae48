"""The command `vh-drake plan`: a user's own depth data in, rated grasps and a picture out."""

import dataclasses as dc
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from vh_drake.atomic_files import write_bytes
from vh_drake.errors import BadInput
from vh_drake.experiments.grasp_picture import draw_grasps
from vh_drake.experiments.plan_grasps import GraspPlan, plan_grasps
from vh_drake.hand.description import load_hand
from vh_drake.hand.model import read_hand_model
from vh_drake.hand.shipped import hand_file
from vh_drake.result_files import write_json
from vh_drake.sensing.clouds import load_cloud
from vh_drake.sensing.contact_files import load_contacts, load_table
from vh_drake.types import Array

_DIGITS = 9  # Of written numbers


@dc.dataclass(frozen=True)
class PlanRequest:
    """A user's files and wishes."""

    cloud: Path
    contacts: Path | None = None
    table: Path | None = None  # then the cloud holds the object alone
    p_WCamera: tuple[float, float, float] | None = None  # optical centre [m]
    hand: str = ""  # a shipped one or a description; empty is the right hand of ARMAR-6
    seed: int = 0
    top: int = 10  # grasps that are reported
    weights: str = ""  # of the learned metric; empty: the shipped ones


def plan_from_files(request: PlanRequest, out: Path) -> dict[str, Any]:
    """Reads a user's files, plans, and writes plan.json, timing.json and grasps.png.

    Returns:
        The content of plan.json; the same bytes for the same files and seed. `grasps` is
        empty where the hand finds no place.

    Raises:
        BadInput: a file or number is unusable.
        NothingSeen: no table, or no object on it.
        VhDrakeError: the results can't be written.
    """
    _check_request(request)
    loaded = load_cloud(request.cloud, _camera(request))
    hand = read_hand_model(load_hand(hand_file(request.hand)))
    plan = plan_grasps(
        loaded.cloud,
        contacts=None if request.contacts is None else load_contacts(request.contacts),
        table=None if request.table is None else load_table(request.table),
        hand=hand,
        seed=request.seed,
        weights=request.weights,
    )
    report = {
        "settings": _settings(request),
        "points": {
            "file": len(loaded.cloud.p_WC) + loaded.dropped,
            "dropped": loaded.dropped,
            "object": len(plan.view.p_WO),
        },
        **plan_report(plan, request.top),
    }
    write_json(out / "plan.json", report)
    write_json(out / "timing.json", {"seconds": plan.seconds})
    write_bytes(out / "grasps.png", draw_grasps(plan, loaded.cloud))
    return report


def plan_report(plan: GraspPlan, top: int) -> dict[str, Any]:
    """A plan in numbers that JSON can hold; lengths in metres, in the frame of the cloud."""
    size = np.ptp(plan.surface.vertices, axis=0)
    return {
        "camera": _rounded(plan.view.p_WCamera),
        "contacts": len(plan.contacts),
        "table": {
            "normal": _rounded(plan.view.table.normal),
            "offset": _rounded(np.array(plan.view.table.offset)),
        },
        "surface": {
            "size": _rounded(size),
            "center": _rounded(plan.surface.vertices.min(axis=0) + size / 2),
            "triangles": len(plan.surface.faces),
        },
        "candidates": len(plan.candidates),
        "grasps": [_grasp(plan, index) for index in plan.ranking[:top]],
    }


def grasp_rows(report: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The grasps of a report as rows of a table for people."""
    return [
        {
            "rank": rank,
            "score": f"{grasp['score']:.2f}",
            "standard_error": f"{grasp['standard_error']:.2f}",
            "motion": grasp["motion"],
            "position_m": " ".join(f"{row[3]:.3f}" for row in grasp["X_WH"][:3]),
        }
        for rank, grasp in enumerate(report["grasps"], 1)
    ]


def _grasp(plan: GraspPlan, index: int) -> dict[str, Any]:
    return {
        "score": _rounded(plan.scores.score[index]),
        "standard_error": _rounded(plan.scores.standard_error[index]),
        "motion": plan.candidates.motion[index],
        "planner": plan.candidates.planner[index],
        "X_WH": _rounded(plan.candidates.X_WH[index]),
    }


def _check_request(request: PlanRequest) -> None:
    if not 1 <= request.top <= 10_000:
        raise BadInput(f"--top is {request.top}; choose a number from 1 to 10000")
    if not 0 <= request.seed < 2**31:
        raise BadInput(f"--seed is {request.seed}; choose a number from 0 to {2**31 - 1}")
    if request.p_WCamera is not None and not all(
        math.isfinite(x) and abs(x) < 1000.0 for x in request.p_WCamera
    ):
        raise BadInput(f"--camera {request.p_WCamera} is not a place in metres")


def _camera(request: PlanRequest) -> Array | None:
    return None if request.p_WCamera is None else np.array(request.p_WCamera)


def _settings(request: PlanRequest) -> dict[str, Any]:
    return {
        name: str(value) if isinstance(value, Path) else value
        for name, value in dc.asdict(request).items()
    }


def _rounded(values: Array) -> object:
    """Plain numbers or nested lists."""
    return np.round(values, _DIGITS).tolist()
