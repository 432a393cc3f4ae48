"""Many independent tasks on all cores: resumable, and the same for any number of workers."""

import multiprocessing
import os
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import (
    FIRST_COMPLETED,
    Executor,
    Future,
    ProcessPoolExecutor,
    wait,
)
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from vh_drake.errors import BadInput
from vh_drake.journal import Journal

_TASKS_PER_PROCESS = 200  # Whatever tasks leave behind ends with their process
_QUEUED_PER_WORKER = 3
_LINE_EVERY_S = 30.0  # of progress, where no terminal shows a bar


def run_tasks(
    function: Callable[[Any], Any],
    tasks: Mapping[str, Any],
    *,
    settings: Mapping[str, Any],
    journal: Path | None = None,
    workers: int = 0,
    executor: Executor | None = None,
    tasks_per_process: int = _TASKS_PER_PROCESS,
    title: str = "",
) -> list[Any]:
    """Apply a function to every task.

    Args:
        function: of the top level of a module; deterministic in its argument; returns what
            JSON can hold.
        tasks: arguments by a unique key.
        settings: all that the results depend on; a journal of others is refused.
        journal: file of finished tasks. A second call with the same settings does only what
            is missing.
        workers: processes; 1 computes in this one, 0 takes every core.
        executor: computes the tasks instead, such as Dask's; stays open.
        tasks_per_process: after so many a worker is replaced.
        title: of the progress on standard error, a bar on a terminal and else lines; none without.

    Returns:
        The results in the order of `tasks`, whatever the order in which they came.

    Raises:
        BadInput: `workers` is negative, or the journal does not belong to the settings.
        VhDrakeError: the journal can't be written.
        Exception: what `function` raised; finished tasks are kept.
    """
    if workers < 0:
        raise BadInput(f"workers is {workers}; take 0 for every core, or a positive number")
    kept = None if journal is None else Journal(journal, settings)
    results = {} if kept is None else dict(kept.results)
    missing = {key: task for key, task in tasks.items() if key not in results}
    with _progress(title, len(tasks) - len(missing), len(tasks)) as advance:
        for key, result in _computed(function, missing, workers, executor, tasks_per_process):
            if kept is not None:
                kept.add(key, result)
            results[key] = result
            advance()
    return [results[key] for key in tasks]


def _computed(
    function: Callable[[Any], Any],
    tasks: Mapping[str, Any],
    workers: int,
    executor: Executor | None,
    tasks_per_process: int,
) -> Iterator[tuple[str, Any]]:
    workers = min(workers or _cores(), len(tasks))
    if executor is not None:
        yield from _by_executor(executor, function, tasks, max(workers, _cores()))
    elif workers <= 1:
        yield from ((key, function(task)) for key, task in tasks.items())
    else:
        with _pool(workers, tasks_per_process) as pool:
            yield from _by_executor(pool, function, tasks, workers)


def _by_executor(
    executor: Executor, function: Callable[[Any], Any], tasks: Mapping[str, Any], workers: int
) -> Iterator[tuple[str, Any]]:
    """Results as they come; few tasks are queued, so that an interruption ends soon."""
    waiting = iter(tasks.items())
    running: dict[Future[Any], str] = {}
    try:
        while True:
            while len(running) < workers * _QUEUED_PER_WORKER and (item := next(waiting, None)):
                running[executor.submit(function, item[1])] = item[0]
            if not running:
                return
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                yield running.pop(future), future.result()
    finally:
        for future in running:
            future.cancel()


def _pool(workers: int, tasks_per_process: int) -> ProcessPoolExecutor:
    """Fresh processes with one thread each: forking a process with threads may hang."""
    return ProcessPoolExecutor(
        workers,
        mp_context=multiprocessing.get_context("forkserver"),
        initializer=_use_one_thread,
        max_tasks_per_child=tasks_per_process,
    )


def _use_one_thread() -> None:
    from threadpoolctl import threadpool_limits

    threadpool_limits(1)


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextmanager
def _progress(title: str, done: int, total: int) -> Iterator[Callable[[], None]]:
    """What to call after each task: a bar moves on a terminal, elsewhere lines are written."""
    if not title:
        yield lambda: None
    elif sys.stderr.isatty():
        columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
        console = Console(file=sys.stderr)
        with Progress(*columns, TimeRemainingColumn(), console=console) as bar:
            task = bar.add_task(title, total=total, completed=done)
            yield lambda: bar.advance(task)
    else:
        yield _lines(title, done, total)


def _lines(title: str, done: int, total: int) -> Callable[[], None]:
    """Writes how many tasks are done on standard error, now and then, and after the last."""
    count, written = done, time.monotonic()

    def advance() -> None:
        nonlocal count, written
        count += 1
        if count == total or time.monotonic() - written >= _LINE_EVERY_S:
            written = time.monotonic()
            print(f"{title}: {count} of {total}", file=sys.stderr, flush=True)

    return advance
