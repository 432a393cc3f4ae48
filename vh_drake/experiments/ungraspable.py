"""Poses in which no candidate succeeds: can the hand grasp the object there at all?"""

from collections.abc import Sequence
from pathlib import Path

from vh_drake.batch import run_tasks
from vh_drake.catalog import Options
from vh_drake.experiments.metric_scenes import TOUCH_COUNTS, evaluation_settings
from vh_drake.learning.dataset import shard_paths
from vh_drake.learning.evaluating import Judged, by
from vh_drake.learning.generating import hand_model, true_object
from vh_drake.learning.labels import SUCCESS_RATE
from vh_drake.learning.searching import best_grasp
from vh_drake.learning.shards import read_shard
from vh_drake.objects.loading import load_object
from vh_drake.reports import Row


def pose_of(scene: Judged) -> int:
    """The number of a scene's pose, which scenes with more or fewer touches share."""
    return scene.scene // len(TOUCH_COUNTS)


def searched_poses(scenes: Sequence[Judged], options: Options, settings: Row) -> list[Row]:
    """A search on the true mesh for each pose whose candidates all fail.

    Args:
        scenes: judged scenes of `judged_scenes`.
        options: those of the command.
        settings: that the scenes depend on.

    Returns:
        For each such pose its number, object, how many grasps were tried on the truth, and the
        best force-closure rate among them.
    """
    poses = by(scenes, pose_of)
    failing = [pose for pose, own in poses.items() if not any(s.success.any() for s in own)]
    shards = shard_paths(options.out / "scenes")
    tasks = {
        str(pose): {
            "pose": pose,
            "shard": str(shards[pose]),
            "folder": None if options.objects is None else str(options.objects),
            "settings": [settings["candidates"], settings["perturbations"]],
        }
        for pose in failing
    }
    return run_tasks(
        search_row,
        tasks,
        settings=settings,
        journal=options.out / "search.jsonl",
        workers=options.workers,
        title="search",
    )


def search_row(task: Row) -> Row:
    """The search in one pose."""
    scene = next(s for s in read_shard(Path(task["shard"])) if len(s.candidates))
    folder = None if task["folder"] is None else Path(task["folder"])
    mesh = load_object(scene.object, folder=folder).mesh
    settings = evaluation_settings(*task["settings"])
    truth = true_object(mesh, scene, settings)
    rate, count = best_grasp(truth, hand_model(settings.hand), settings.label, scene.scene)
    return {
        "pose": task["pose"],
        "object": scene.object,
        "searched": count,
        "best_rate_on_truth": round(rate, 4),
        "graspable": rate > SUCCESS_RATE,
    }
