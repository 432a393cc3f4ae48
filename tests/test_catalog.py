import importlib
from pathlib import Path

import pytest

from vh_drake.catalog import BENCHES, REPRODUCTIONS, Entry, Options, run_entry
from vh_drake.errors import BadInput, UnknownName
from vh_drake.reports import Report

ENTRIES = {"here": Entry(__name__, "A test.", ("runs",))}


def run(options):
    return Report("here", {"runs": options.runs}, {"answer": 42})


def test_a_command_runs_and_its_report_is_saved(tmp_path):
    report = run_entry("reproduction", ENTRIES, "here", Options(runs=2, out=tmp_path))
    assert report.summary == {"answer": 42}
    assert (tmp_path / "here.json").is_file()


def test_an_unknown_name_lists_the_choices(tmp_path):
    with pytest.raises(UnknownName, match="choose one of: here"):
        run_entry("reproduction", ENTRIES, "there", Options(out=tmp_path))


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"scenes": 3}, "no option --scenes"),
        ({"runs": 0}, "--runs is 0"),
        ({"seed": -1}, "negative"),
        ({"workers": -1}, "negative"),
    ],
)
def test_an_option_that_can_not_be_is_refused(tmp_path, wrong, message):
    with pytest.raises(BadInput, match=message):
        run_entry("reproduction", ENTRIES, "here", Options(**wrong, out=tmp_path))


def test_a_missing_folder_of_objects_is_named(tmp_path):
    entries = {"here": Entry(__name__, "A test.", ("objects",))}
    with pytest.raises(BadInput, match="no such folder"):
        run_entry("reproduction", entries, "here", Options(objects=Path("none"), out=tmp_path))


def test_every_entry_names_a_module_with_a_run_function():
    for entry in [*BENCHES.values(), *REPRODUCTIONS.values()]:
        assert callable(importlib.import_module(entry.module).run)
        assert entry.help.endswith(".")
