"""Scenes in which no candidate succeeds: can the hand grasp the object there at all?"""

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
from vh_drake.learning.shards import LabelledScene, read_shard
from vh_drake.objects.loading import load_object
from vh_drake.reports import Row


def searched_poses(scenes: Sequence[Judged], options: Options, settings: Row) -> list[Row]:
    """A search on the true mesh for each scene whose candidates all fail.

    Args:
        scenes: judged scenes of `judged_scenes`.
        options: those of the command.
        settings: that the scenes depend on.

    Returns:
        For each pose in such scenes the object, their numbers, how many grasps were tried on the
        truth, and the best force-closure rate among them.
    """
    shards = shard_paths(options.out / "scenes")
    failing = by([s for s in scenes if not s.success.any()], _shard_of)
    tasks = {
        str(shard): {
            "shard": str(shards[shard]),
            "scenes": [scene.scene for scene in own],
            "folder": None if options.objects is None else str(options.objects),
            "settings": [settings["candidates"], settings["perturbations"]],
        }
        for shard, own in failing.items()
    }
    found = run_tasks(
        search_rows,
        tasks,
        settings=settings,
        journal=options.out / "searched.jsonl",
        workers=options.workers,
        title="search",
    )
    return [row for rows in found for row in rows]


def _shard_of(scene: Judged) -> int:
    return scene.scene // len(TOUCH_COUNTS)


def search_rows(task: Row) -> list[Row]:
    """A search in each pose that some scenes of a shard show.

    They share one, unless the planners found nothing in it and it was drawn anew.
    """
    folder = None if task["folder"] is None else Path(task["folder"])
    settings = evaluation_settings(*task["settings"])
    poses: dict[bytes, list[LabelledScene]] = {}
    for scene in read_shard(Path(task["shard"])):
        if scene.scene in task["scenes"]:
            poses.setdefault(scene.view.p_WO.tobytes(), []).append(scene)
    rows: list[Row] = []
    for alike in poses.values():
        scene = alike[0]
        mesh = load_object(scene.object, folder=folder).mesh
        truth = true_object(mesh, scene, settings)
        rate, count = best_grasp(truth, hand_model(settings.hand), settings.label, scene.scene)
        rows.append(
            {
                "object": scene.object,
                "scenes_alike": [scene.scene for scene in alike],
                "searched": count,
                "best_rate_on_truth": round(rate, 4),
                "graspable": rate > SUCCESS_RATE,
            }
        )
    return rows
