"""`reproduce hand-eye`: what a touch is worth to a robot whose camera is badly calibrated."""

from vh_drake.catalog import Options
from vh_drake.experiments.robustness import hand_eye
from vh_drake.experiments.stages import run_variants, variant_rows
from vh_drake.reports import Report, Row

ERRORS = hand_eye((0.01, 3.0), (0.02, 6.0))
TOUCHES = {"one touch": 1, "no touch": 0}


def run(options: Options) -> Report:
    """The same scenes with one touch and with none, one attempt each, point contact unless asked.

    Raises:
        BadInput: folder or options are unusable.
    """
    variants = {
        f"{touch}, {name}": {"touches": count, "camera": error}
        for name, error in ERRORS.items()
        for touch, count in TOUCHES.items()
    }
    rows, settings = run_variants(variants, options)
    summary: Row = {"scenes": len(rows) // len(variants)}
    table: list[Row] = []
    for name in ERRORS:
        touched, plain = variant_rows(rows, [f"{touch}, {name}" for touch in TOUCHES], options.seed)
        table += [touched, plain]
        summary |= {
            f"one touch, {name}": touched["success"],
            f"gain over no touch, {name}": plain["difference"],
            f"gain over no touch, {name} interval": plain["difference_interval"],
        }
    return Report("hand-eye", settings, summary, {}, [*table, *rows])
