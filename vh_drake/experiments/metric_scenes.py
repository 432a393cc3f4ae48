"""Labelled scenes of objects that no metric has learnt from, for figure 4.7 and table 4.5."""

from pathlib import Path
from typing import Any

from vh_drake.catalog import Options
from vh_drake.errors import BadInput
from vh_drake.learning.dataset import DatasetSpec, generate
from vh_drake.learning.evaluating import Judged, judge_dataset
from vh_drake.learning.generating import GeneratorSettings
from vh_drake.learning.labels import LabelSettings
from vh_drake.learning.scene import SceneSettings
from vh_drake.learning.training_objects import TEST_SPLIT, VALIDATION_KINDS
from vh_drake.objects.folders import read_folder

TOUCH_COUNTS = (0, 1, 2, 3, 4, 5)
ORIENTATIONS = 5  # of each object (section 4.4.2)
CANDIDATES = 800
PERTURBATIONS = 400


def judged_scenes(
    options: Options, *, candidates: int = CANDIDATES, perturbations: int = PERTURBATIONS
) -> tuple[list[Judged], dict[str, Any]]:
    """Generate the scenes that are missing in `options.out`, and let every metric rate them.

    Args:
        options: objects, split, scenes, weights, seed, workers, out.
        candidates: of each scene.
        perturbations: of each label.

    Returns:
        The scenes, and the settings that they depend on.

    Raises:
        BadInput: an option is unusable, or the folder holds scenes of other settings.
    """
    names = evaluation_objects(options)
    scenes = options.scenes or len(names) * ORIENTATIONS * len(TOUCH_COUNTS)
    spec = DatasetSpec(
        scenes,
        tuple(names),
        options.objects,
        options.seed,
        scenes_per_shard=len(TOUCH_COUNTS),
        settings=evaluation_settings(candidates, perturbations),
    )
    generate(options.out / "scenes", spec, workers=options.workers, title="scenes")
    judged = judge_dataset(
        options.out / "scenes",
        options.weights,
        journal=options.out / "journal.jsonl",
        workers=options.workers,
        touch_counts=TOUCH_COUNTS,
        title="rating",
    )
    settings = {
        "objects": names,
        "split": options.split or (TEST_SPLIT if options.objects else "validation kinds"),
        "scenes": scenes,
        "candidates": candidates,
        "perturbations": perturbations,
        "touches": list(TOUCH_COUNTS),
        "weights": "shipped" if options.weights is None else Path(options.weights).name,
        "seed": options.seed,
    }
    return judged, settings


def evaluation_objects(options: Options) -> list[str]:
    """The split's objects of a folder, or the embedded ones that no metric learns from.

    Raises:
        BadInput: the folder has none of that split.
    """
    if options.objects is None:
        return sorted(VALIDATION_KINDS)
    split = options.split or TEST_SPLIT
    entries = read_folder(options.objects)
    # A folder without a table has one split, and all of it is unknown to the metric.
    names = [name for name, entry in entries.items() if entry.split in (split, "")]
    if not names:
        raise BadInput(f"{options.objects}: objects.csv has no object of the split {split!r}")
    return sorted(names)


def evaluation_settings(candidates: int, perturbations: int) -> GeneratorSettings:
    """Objects as they are, touches in turn, labels from many disturbances."""
    return GeneratorSettings(
        candidates=candidates,
        touch_counts=list(TOUCH_COUNTS),
        scene=SceneSettings(scale=[1.0, 1.0], stretch=[1.0, 1.0]),
        label=LabelSettings(min_samples=perturbations, max_samples=perturbations),
        estimate=LabelSettings(min_samples=24, max_samples=100, target_error=0.05),
    )
