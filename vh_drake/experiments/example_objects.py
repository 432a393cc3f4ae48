"""The three objects of figures 3.30 to 3.36, from a softball to a figure of finer shape."""

from collections.abc import Callable, Sequence

from vh_drake.batch import run_tasks
from vh_drake.catalog import Options
from vh_drake.experiments.contenders import subject
from vh_drake.experiments.exploration_trials import explored_objects
from vh_drake.exploration.loop import Exploration, explore
from vh_drake.exploration.tuned import tuned
from vh_drake.reports import Row

Task = tuple[str, str, str, int]  # object, its folder, strategy, seed

STRATEGIES = ("igef", "gp_variance", "random")
RUNS = 20
# Each with its stand-in of the embedded library; the power drill is there for the tortoise.
_EXAMPLES = (("054_softball", "ball"), ("011_banana", "banana"), ("", "power_drill"))


def example_objects(options: Options) -> dict[str, str]:
    """Folders by the names of the objects; empty ones stand for the library.

    Raises:
        BadInput: the folder of the options is unusable.
    """
    known = {} if options.objects is None else explored_objects(options)
    return {
        real if real in known else own: str(options.objects) if real in known else ""
        for real, own in _EXAMPLES
    }


def example_runs(name: str, folder: str, strategy: str, seeds: Sequence[int]) -> list[Exploration]:
    """Explorations of one example in the thesis's setting."""
    body = subject(name, folder).body
    return [explore(body, tuned(strategy), seed=seed) for seed in seeds]


def explored_rows(
    work: Callable[[Task], Row], options: Options, *, journal: str, title: str
) -> tuple[Row, list[Row]]:
    """Rows of many explorations of all examples by all strategies, and what they depend on.

    Args:
        work: makes the row of one exploration.
        options: objects, runs, seed, workers, out.
        journal: name of the file of finished rows.
        title: of the progress bar.

    Raises:
        BadInput: the folder of the options is unusable.
    """
    examples, runs = example_objects(options), options.runs or RUNS
    tasks = {
        f"{name} {strategy} {seed}": (name, folder, strategy, seed)
        for name, folder in examples.items()
        for strategy in STRATEGIES
        for seed in range(options.seed, options.seed + runs)
    }
    settings: Row = {"objects": list(examples), "runs": runs, "seed": options.seed}
    rows: list[Row] = run_tasks(
        work,
        tasks,
        settings=settings,
        journal=options.out / journal,
        workers=options.workers,
        title=title,
    )
    return settings, rows
