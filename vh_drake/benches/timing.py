"""Times of short computations on a machine that does other things too."""

import time
from collections.abc import Callable


def best_ms(function: Callable[[], object], *, repeats: int = 7, budget_s: float = 2.0) -> float:
    """The least processor time of a few calls [ms]; the first warms up unless it is long.

    Args:
        function: what to measure, on one thread.
        repeats: calls at most.
        budget_s: no further call is started after so much processor time.
    """
    start = time.process_time()
    best = float("inf")
    for call in range(repeats + 1):
        before = time.process_time()
        function()
        after = time.process_time()
        if call > 0 or after - start > budget_s:
            best = min(best, after - before)
        if after - start > budget_s:
            break
    return 1e3 * best
