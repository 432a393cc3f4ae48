import json
import subprocess
import sys
import time

import pytest

from vh_drake import catalog, cli
from vh_drake.errors import BadInput, NothingSeen, UnknownName
from vh_drake.experiments import grasp_command
from vh_drake.reports import Report
from vh_drake.scenes import doctor
from vh_drake.scenes.doctor import Check


def run(monkeypatch, *arguments: str) -> int:
    """Exit status of the command line in this process."""
    monkeypatch.setattr(sys, "argv", ["vh-drake", *arguments])
    with pytest.raises(SystemExit) as end:
        cli.main()
    return int(end.value.code or 0)


def raising(error: BaseException):
    """A check list that raises when it is asked for."""

    def examine():
        raise error

    return examine


def test_help_answers_at_once_and_lists_the_commands():
    start_s = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-m", "vh_drake", "--help"], capture_output=True, text=True, check=True
    )
    assert "doctor" in done.stdout
    assert time.perf_counter() - start_s < 5.0  # 0.3 s on an idle machine.


def test_heavy_modules_are_not_loaded_by_the_command_line():
    code = (
        "import sys, vh_drake.cli; "
        "print([m for m in ('pydrake', 'torch', 'open3d', 'numba') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_version_is_printed(monkeypatch, capsys):
    assert run(monkeypatch, "--version") == 0
    assert capsys.readouterr().out.startswith("vh_drake 0.")


def test_a_healthy_machine_gives_status_0(monkeypatch, capsys):
    monkeypatch.setattr(doctor, "CHECKS", (lambda: Check("Moon", True, "full"),))
    assert run(monkeypatch, "doctor") == 0
    assert "full" in capsys.readouterr().out


def test_a_failed_check_gives_status_1_and_its_remedy(monkeypatch, capsys):
    monkeypatch.setattr(doctor, "CHECKS", (lambda: Check("Moon", False, "new", "wait [14 days]"),))
    assert run(monkeypatch, "doctor") == 1
    assert "[14 days]" in capsys.readouterr().out


def test_json_is_all_that_stands_on_standard_output(monkeypatch, capsys):
    monkeypatch.setattr(doctor, "CHECKS", (lambda: Check("Moon", True, "full"),))
    assert run(monkeypatch, "doctor", "--json") == 0
    assert json.loads(capsys.readouterr().out) == [
        {"name": "Moon", "ok": True, "found": "full", "remedy": ""}
    ]


@pytest.mark.parametrize(
    ("error", "status"),
    [
        (BadInput("mug.obj has no triangles; export it again"), 2),
        (UnknownName("object", "mugg", ["mug"]), 2),
        (NothingSeen("no table in view"), 1),
        (OSError(28, "No space left on device", "out/result.json"), 1),
    ],
)
def test_an_error_is_one_message_on_standard_error_without_a_traceback(
    monkeypatch, capsys, error, status
):
    monkeypatch.setattr(doctor, "examine", raising(error))
    assert run(monkeypatch, "doctor") == status
    output = capsys.readouterr()
    assert output.out == ""
    assert output.err == f"vh-drake: {error}\n"


def test_an_interrupt_gives_status_130(monkeypatch):
    monkeypatch.setattr(doctor, "examine", raising(KeyboardInterrupt()))
    assert run(monkeypatch, "doctor") == 130


@pytest.mark.parametrize("arguments", [["nonsense"], ["doctor", "--nonsense"]])
def test_unknown_arguments_give_status_2(monkeypatch, arguments):
    assert run(monkeypatch, *arguments) == 2


def test_the_embedded_objects_are_listed(monkeypatch, capsys):
    assert run(monkeypatch, "objects") == 0
    assert "sugar_box" in capsys.readouterr().out


def test_the_objects_of_a_folder_are_listed(monkeypatch, capsys, tmp_path):
    (tmp_path / "cup.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    assert run(monkeypatch, "objects", "--objects", str(tmp_path), "--json") == 0
    assert [row["name"] for row in json.loads(capsys.readouterr().out)] == ["cup"]


def test_a_missing_folder_of_objects_gives_status_2(monkeypatch, capsys, tmp_path):
    assert run(monkeypatch, "objects", "--objects", str(tmp_path / "nowhere")) == 2
    assert "nowhere" in capsys.readouterr().err


@pytest.mark.parametrize(("arguments", "seed"), [((), 7), (("--seed", "3"), 3)])
def test_the_seed_of_a_scenario_holds_unless_one_is_given(monkeypatch, tmp_path, arguments, seed):
    file = tmp_path / "mine.yaml"
    file.write_text("seed: 7\nobject: can\n")
    ran = []
    monkeypatch.setattr(
        grasp_command, "grasp_and_report", lambda scenario, *_, **__: ran.append(scenario) or True
    )
    assert run(monkeypatch, "grasp", "--scenario", str(file), *arguments) == 0
    assert (ran[0].seed, ran[0].object) == (seed, "can")


@pytest.mark.parametrize(("arguments", "workers"), [((), 1), (("--workers", "0"), 0)])
def test_benchmarks_run_in_one_process_unless_asked(monkeypatch, tmp_path, arguments, workers):
    asked = []

    def run_entry(_kind, _entries, name, options):
        asked.append((name, options.workers))
        return Report(name, {}, {"trials": 1})

    monkeypatch.setattr(catalog, "run_entry", run_entry)
    assert run(monkeypatch, "bench", "soak", "--out", str(tmp_path), *arguments) == 0
    assert asked == [("soak", workers)]


def test_benchmarks_take_a_folder_of_objects_where_they_use_one(monkeypatch, capsys, tmp_path):
    missing = str(tmp_path / "none")
    assert run(monkeypatch, "bench", "closing", "--objects", missing) == 2
    assert "no such folder" in capsys.readouterr().err
    assert run(monkeypatch, "bench", "tendon", "--objects", str(tmp_path)) == 2
    assert "has no option --objects" in capsys.readouterr().err
