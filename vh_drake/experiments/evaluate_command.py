"""`vh-drake evaluate`: a metric on any labelled data set, such as one of a user's own objects."""

from pathlib import Path

from vh_drake.catalog import Options
from vh_drake.experiments.figure_4_7 import report
from vh_drake.learning.evaluating import judge_dataset
from vh_drake.reports import Report


def evaluate(
    dataset: Path, weights: Path | None, out: Path, *, seed: int = 0, workers: int = 0
) -> Report:
    """Rate all candidates of a data set by every metric; writes evaluate.png into a folder.

    Args:
        dataset: folder of `vh-drake dataset generate`; objects that the weights have learnt from
            flatter the learned metric.
        weights: None takes the shipped ones.
        out: for figure, journal and, once saved, the report.
        seed: of the bootstrap.
        workers: processes; 0 takes every core.

    Raises:
        BadInput: data set or weights are missing or damaged.
    """
    scenes = judge_dataset(
        dataset, weights, journal=out / "journal.jsonl", workers=workers, title="rating"
    )
    settings = {
        "dataset": dataset.name,
        "split": "data set",
        "weights": "shipped" if weights is None else weights.name,
        "seed": seed,
    }
    return report(scenes, settings, Options(seed=seed, out=out), name="evaluate")
