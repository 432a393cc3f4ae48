"""`reproduce table-4.5`: grasp success by the number of touches."""

from collections.abc import Sequence

from vh_drake.catalog import Options
from vh_drake.experiments.metric_scenes import TOUCH_COUNTS, judged_scenes
from vh_drake.learning.evaluating import Judged, by, mean_precision, top1
from vh_drake.reports import Report, Row

_MEANS = (0.89, 0.94, 0.94, 0.93, 0.95, 0.95)
THESIS = {f"success_{touches}": mean for touches, mean in zip(TOUCH_COUNTS, _MEANS, strict=True)}


def run(options: Options) -> Report:
    """Success of what the learned metric selects, on the same poses with 0 to 5 touches.

    Raises:
        BadInput: an option is unusable.
    """
    scenes, settings = judged_scenes(options)
    return report(scenes, settings)


def report(scenes: Sequence[Judged], settings: Row) -> Report:
    """The report of judged scenes."""
    by_touches = by(scenes, lambda scene: scene.touches)
    summary: Row = {}
    for touches, own in by_touches.items():
        summary[f"success_{touches}"] = _rounded(mean_precision(own, "learned"))
        summary[f"top1_success_{touches}"] = _rounded(top1(own, "learned"))
        summary[f"nominal_success_{touches}"] = _rounded(mean_precision(own, "nominal"))
    rows = [
        {"object": name, "split": settings["split"], **_row(own)}
        for name, own in by(scenes, lambda scene: scene.object).items()
    ]
    return Report("table-4.5", settings, summary, THESIS, rows)


def _row(scenes: Sequence[Judged]) -> Row:
    """Success of one object by the number of touches."""
    return {
        f"success_{touches}": _rounded(mean_precision(own, "learned"))
        for touches, own in by(scenes, lambda scene: scene.touches).items()
    }


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 4)
