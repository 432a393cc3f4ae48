"""`reproduce hand-eye`: what a touch is worth to a robot whose camera is badly calibrated."""

from vh_drake.catalog import Options
from vh_drake.experiments.robustness import HAND_EYE
from vh_drake.experiments.stages import gains, run_variants, variant_rows
from vh_drake.reports import Report, Row

TOUCHES = {"one touch": 1, "no touch": 0}


def run(options: Options) -> Report:
    """The same scenes with one touch and with none, one attempt each, point contact unless asked.

    Raises:
        BadInput: folder or options are unusable.
    """
    variants = {
        f"{touch}, {name}": {"touches": count, "camera": error}
        for name, error in HAND_EYE.items()
        for touch, count in TOUCHES.items()
    }
    rows, settings = run_variants(variants, options)
    summary: Row = {}
    table: list[Row] = []
    for name in HAND_EYE:
        pair = variant_rows(rows, [f"{touch}, {name}" for touch in TOUCHES], options.seed)
        table += pair
        summary |= {f"one touch, {name}": pair[0]["success"], **gains(pair)}
    del summary["success"], summary["success_interval"]  # of the last error alone
    return Report("hand-eye", settings, summary, {}, [*table, *rows])
