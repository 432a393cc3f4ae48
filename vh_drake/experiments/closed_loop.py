"""`reproduce closed-loop`: what closing by motor positions and wrist force gains over a tape."""

from vh_drake.catalog import Options
from vh_drake.experiments.stages import gains, run_variants, variant_rows
from vh_drake.reports import Report

VARIANTS = {"closed loop": {"closing": "closed_loop"}, "open loop": {"closing": "open_loop"}}


def run(options: Options) -> Report:
    """Both modes on the same scenes, one attempt each, point contact unless asked.

    Raises:
        BadInput: folder or options are unusable.
    """
    rows, settings = run_variants(VARIANTS, options)
    table = variant_rows(rows, list(VARIANTS), options.seed)
    return Report("closed-loop", settings, gains(table), {}, [*table, *rows])
