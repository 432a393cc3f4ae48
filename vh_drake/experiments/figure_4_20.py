"""`reproduce figure-4.20`: the coordinated grasp trajectory, played on the simulated hand.

The hand on a base that goes where it is told takes a flashlight, as in figure 4.19. The text tells
the key points of fingers and thumb and the outline of the rest; the file behind this one
(`models/trajectories/coordinated_top.yaml`) holds the whole. Fingers have different lengths, so
each tip has a height of its own over the table; the deviation is how far a tip leaves the middle
of its range until the hand presses.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context

from vh_drake.catalog import Options
from vh_drake.experiments.figure_files import save_figure
from vh_drake.grasping.base_joints import base_position
from vh_drake.grasping.coordinated import CoordinatedGrasp, key_points_for, shipped_grasp
from vh_drake.grasping.motions import CollectSettings, collect_pose
from vh_drake.hand.description import load_hand
from vh_drake.hand.key_points import KeyPointTrajectory, hand_pose, key_point_at, save_key_points
from vh_drake.hand.model import HandModel, read_hand_model
from vh_drake.hand.shipped import hand_file
from vh_drake.objects.loading import load_object
from vh_drake.objects.model import ObjectModel
from vh_drake.reports import Report, Row
from vh_drake.scenes.moving_hand import MovingHand, make_moving_hand
from vh_drake.types import Array

OBJECT, OBJECT_WIDTH_M = "flashlight", 0.051
AHEAD_M = 0.035  # of the object's middle before the power TCP, along the fingers
TICK_S = 0.02
SETTLE_S, HOLD_S = 0.4, 1.0  # before the trajectory and after it


class Played(NamedTuple):
    """What was seen at k times."""

    time_s: Array  # (k,)
    tips: Array  # (k, f) heights of the fingertips' lowest points over the table [m]
    object_m: Array  # (k,) height of the object's lowest point
    touch_n: Array  # (k, 3) force on the hand, in W


def run(options: Options) -> Report:
    """Play the trajectory and draw it; writes figure-4.20.png and the key points as YAML."""
    hand, grasp = read_hand_model(load_hand(hand_file())), shipped_grasp("top")
    trajectory = key_points_for(grasp, hand)
    played = play(hand, trajectory, load_object(OBJECT))
    pressing = pressing_s(grasp)
    rows = _rows(trajectory, hand, played)
    figure = Figure(figsize=(12.0, 4.2), layout="constrained")
    draw(figure, trajectory, hand, played, pressing)
    save_figure(options.out / "figure-4.20.png", figure)
    save_key_points(options.out / "figure-4.20.yaml", trajectory)
    settings = {"object": OBJECT, "hand": hand.description.name, "seed": options.seed}
    return Report(
        "figure-4.20",
        settings,
        summarized(trajectory, played, pressing),
        {"rotation_deg": 25},
        rows,
    )


def pressing_s(grasp: CoordinatedGrasp) -> float:
    """When the hand begins to go down."""
    before = [point.press_m > 0.0 for point in grasp.key_points].index(True)
    return before * grasp.spacing_s


def play(hand: HandModel, trajectory: KeyPointTrajectory, model: ObjectModel) -> Played:
    """Run a trajectory from the top on the hand alone, over an object that lies across."""
    X_WH0 = start_pose(hand)
    scene = make_moving_hand(hand, contact="point", model=model, X_WO=lying_pose(hand, model))
    simulator = Simulator(scene.diagram)
    context = simulator.get_mutable_context()
    own = scene.plant.GetMyMutableContextFromRoot(context)
    scene.plant.SetPositions(own, scene.base, base_position(hand, X_WH0))
    end_s = trajectory.key_points[-1].time_s
    corners, seen = model.mesh.convex_hull.vertices, []
    for tick in range(round((SETTLE_S + end_s + HOLD_S) / TICK_S)):
        time_s = tick * TICK_S - SETTLE_S
        _command(scene, context, hand, X_WH0, trajectory, time_s)
        if time_s > -TICK_S / 2:
            seen.append((time_s, *_observed(scene, context, hand, corners)))
        simulator.AdvanceTo((tick + 1) * TICK_S)
    return Played(*(np.array(column) for column in zip(*seen, strict=True)))


def start_pose(hand: HandModel) -> Array:
    """X_WH (4, 4): palm down, the lowest fingertip touching the table z = 0."""
    return collect_pose(hand, hand.lower, CollectSettings(clearance_m=0.0))


def lying_pose(hand: HandModel, model: ObjectModel) -> Array:
    """X_WO (4, 4) on the table, the object's long axis across the fingers."""
    vertices = model.mesh.vertices
    X_WO = np.eye(4)
    X_WO[:3, :3] = [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]  # z of the object to -y
    placed = vertices @ X_WO[:3, :3].T
    low, high = placed.min(axis=0), placed.max(axis=0)
    X_WO[:3, 3] = [AHEAD_M - (low[0] + high[0]) / 2, -(low[1] + high[1]) / 2, 5e-4 - low[2]]
    return X_WO


def _command(
    scene: MovingHand,
    context: Context,
    hand: HandModel,
    X_WH0: Array,
    trajectory: KeyPointTrajectory,
    time_s: float,
) -> None:
    """Base and motors go where the trajectory is, the base with its rates."""
    points = trajectory.key_points
    now, later = (key_point_at(points, time_s + dt) for dt in (0.0, TICK_S))
    before = base_position(hand, hand_pose(now, hand.description, X_WH0))
    after = base_position(hand, hand_pose(later, hand.description, X_WH0), before)
    state = np.r_[before, (after - before) / TICK_S]
    scene.diagram.GetInputPort("base_state").FixValue(context, state)
    motors = hand.motor_fractions(now.fingers, now.thumb)
    scene.diagram.GetInputPort("motor_command").FixValue(context, motors)


def _observed(
    scene: MovingHand, context: Context, hand: HandModel, corners: Array
) -> tuple[Array, float, Array]:
    """Heights of the true tips and of the object's lowest point, and the force on the hand."""
    own = scene.plant.GetMyContextFromRoot(context)
    joints = [scene.plant.GetJointByName(name, scene.instance) for name in hand.joints]
    angles = scene.plant.GetPositions(own)[[joint.position_start() for joint in joints]]
    base = scene.plant.GetBodyByName(hand.description.base, scene.instance)
    X_WH = scene.plant.EvalBodyPoseInWorld(own, base).GetAsMatrix4()
    tips = hand.tips(angles) @ X_WH[2, :3] + X_WH[2, 3]
    X_WO: RigidTransform = scene.plant.EvalBodyPoseInWorld(own, scene.object)
    lowest = float((corners @ X_WO.rotation().matrix()[2]).min() + X_WO.translation()[2])
    touch = scene.diagram.GetOutputPort("touch").Eval(context)
    return tips - hand.arrays.sphere_radius[hand.tip_spheres], lowest, np.array(touch)


def deviations_mm(played: Played, until_s: float) -> Array:
    """(f,) how far each tip leaves the middle of its range while it closes [mm]."""
    closing = played.tips[played.time_s <= until_s + 1e-9]
    return np.asarray(1e3 * np.ptp(closing, axis=0) / 2)


def summarized(trajectory: KeyPointTrajectory, played: Played, pressing: float) -> Row:
    """Metrics of the figure."""
    pitch = [point.rpy_deg[1] for point in trajectory.key_points]
    return {
        "largest_deviation_mm": round(float(deviations_mm(played, pressing).max()), 3),
        "rotation_deg": round(max(pitch) - min(pitch), 2),
        "key_points": len(trajectory.key_points) - 1,
        "lowest_tip_mm": round(1e3 * float(played.tips[played.time_s <= pressing].min()), 2),
        "object_raised_mm": round(1e3 * float(played.object_m[-1]), 2),
        "largest_press_n": round(float(played.touch_n[:, 2].max()), 1),
    }


def _rows(trajectory: KeyPointTrajectory, hand: HandModel, played: Played) -> list[Row]:
    names = [finger.name for finger in hand.description.fingers]
    rows = []
    for k in range(0, len(played.time_s), 5):
        point = key_point_at(trajectory.key_points, float(played.time_s[k]))
        tips = {
            f"{n}_mm": round(1e3 * float(h), 3) for n, h in zip(names, played.tips[k], strict=True)
        }
        rows.append(
            {
                "time_s": round(float(played.time_s[k]), 3),
                "fingers": round(point.fingers, 5),
                "thumb": round(point.thumb, 5),
                "up_mm": round(1e3 * point.position_m[2], 3),
                "pitch_deg": round(point.rpy_deg[1], 3),
                **tips,
                "object_mm": round(1e3 * float(played.object_m[k]), 3),
            }
        )
    return rows


def draw(
    figure: Figure, trajectory: KeyPointTrajectory, hand: HandModel, played: Played, pressing: float
) -> None:
    """Fingers and thumb, the hand's way, and what comes of it."""
    fingers, way, tips = figure.subplots(1, 3)
    points = trajectory.key_points
    times = [point.time_s for point in points]
    line: Callable[..., object] = fingers.plot
    line(times, [point.fingers for point in points], "o-", label="fingers")
    line(times, [point.thumb for point in points], "s-", label="thumb")
    fingers.set(ylabel="share of the motor's travel (0 open, 1 closed)", title="Fingers and thumb")
    _draw_way(way, trajectory, hand)
    for name, heights in zip(
        [finger.name for finger in hand.description.fingers], played.tips.T, strict=True
    ):
        tips.plot(played.time_s, 1e3 * heights, label=f"tip of {name}")
    tips.plot(played.time_s, 1e3 * played.object_m, "k--", label=f"{OBJECT}, lowest point")
    tips.axvline(pressing, color="grey", lw=1)
    tips.text(
        pressing,
        0.97,
        " presses",
        color="grey",
        fontsize="small",
        va="top",
        transform=tips.get_xaxis_transform(),
    )
    tips.set(ylabel="height over the table [mm]", title="Simulated tips and object", xlim=(0, 5.5))
    for axes in (fingers, way, tips):
        axes.set_xlabel("time [s]")
        axes.grid(alpha=0.3)
        axes.legend(fontsize="small")


def _draw_way(axes: Axes, trajectory: KeyPointTrajectory, hand: HandModel) -> None:
    """Height and place of the hand's frame, and its turn."""
    X_WH0 = start_pose(hand)
    times = np.linspace(0.0, trajectory.key_points[-1].time_s, 101)
    poses = [
        hand_pose(key_point_at(trajectory.key_points, t), hand.description, X_WH0) for t in times
    ]
    p_mm = 1e3 * np.array([X[:3, 3] - X_WH0[:3, 3] for X in poses])
    axes.plot(times, p_mm[:, 2], label="height z [mm]")
    axes.plot(times, -p_mm[:, 0], label="towards the robot y [mm]")
    turns = [-key_point_at(trajectory.key_points, t).rpy_deg[1] for t in times]
    axes.plot(times, turns, label="fingers turned up [degrees]")
    axes.set(ylabel="from the start [mm or degrees]", title="The hand's frame")
