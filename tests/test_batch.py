import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from vh_drake import batch
from vh_drake.batch import run_tasks
from vh_drake.errors import BadInput

TASKS = {f"task {i}": i for i in range(12)}


def slow_square(number):
    time.sleep(0.01 * ((number * 7) % 5))
    return number * number


def failing(number):
    if number == 7:
        raise ValueError("seven")
    return number


def process_id(_number):
    return os.getpid()


SQUARES = [i * i for i in range(12)]


@pytest.mark.parametrize("workers", [1, 2, 3])
def test_results_stand_in_the_order_of_the_tasks_for_any_number_of_workers(workers):
    assert run_tasks(slow_square, TASKS, settings={}, workers=workers) == SQUARES


def test_a_given_executor_computes_and_stays_open():
    with ThreadPoolExecutor(2) as executor:
        assert run_tasks(slow_square, TASKS, settings={}, executor=executor) == SQUARES
        assert executor.submit(slow_square, 3).result() == 9


def test_what_was_done_before_a_failure_is_kept_and_not_done_again(tmp_path):
    journal = tmp_path / "journal.jsonl"
    with pytest.raises(ValueError, match="seven"):
        run_tasks(failing, TASKS, settings={}, journal=journal, workers=1)
    done = journal.read_text().count('"key"')
    assert done == 7
    results = run_tasks(slow_square, TASKS, settings={}, journal=journal, workers=1)
    assert results[:7] == list(range(7))  # As `failing` gave them
    assert results[7:] == SQUARES[7:]


def test_workers_are_replaced_after_their_share():
    pids = run_tasks(process_id, TASKS, settings={}, workers=2, tasks_per_process=3)
    assert os.getpid() not in pids
    assert len(set(pids)) >= 4


def test_a_negative_number_of_workers_is_refused():
    with pytest.raises(BadInput, match="workers"):
        run_tasks(slow_square, TASKS, settings={}, workers=-1)


def test_without_a_terminal_lines_tell_how_far_it_is(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(batch, "_LINE_EVERY_S", 0.0)
    journal = tmp_path / "journal.jsonl"
    with pytest.raises(ValueError, match="seven"):
        run_tasks(failing, TASKS, settings={}, journal=journal, workers=1, title="squares")
    assert capsys.readouterr().err.splitlines() == [f"squares: {i} of 12" for i in range(1, 8)]
    run_tasks(slow_square, TASKS, settings={}, journal=journal, workers=1, title="squares")
    assert capsys.readouterr().err.splitlines() == [f"squares: {i} of 12" for i in range(8, 13)]


def test_short_work_writes_one_line_and_work_without_a_title_none(capsys):
    run_tasks(slow_square, TASKS, settings={}, workers=1, title="squares")
    assert capsys.readouterr().err == "squares: 12 of 12\n"
    run_tasks(slow_square, TASKS, settings={}, workers=1)
    assert capsys.readouterr().err == ""


def test_killed_at_random_moments_it_ends_with_the_same_bytes(tmp_path):
    code = (
        "import sys; sys.path.insert(0, sys.argv[2])\n"
        "from pathlib import Path; from test_batch import *\n"
        "if __name__ == '__main__':\n"
        "    run_tasks(slow_square, TASKS, settings={}, journal=Path(sys.argv[1]), workers=1)\n"
    )
    journal = tmp_path / "journal.jsonl"
    command = [sys.executable, "-c", code, str(journal), str(Path(__file__).parent)]
    for delay in (0.3, 0.35, 0.4, 0.45, 0.5):
        process = subprocess.Popen(command)
        time.sleep(delay)
        process.send_signal(signal.SIGKILL)
        process.wait()
    subprocess.run(command, check=True)
    whole = tmp_path / "whole.jsonl"
    run_tasks(slow_square, TASKS, settings={}, journal=whole, workers=1)
    assert journal.read_bytes() == whole.read_bytes()
