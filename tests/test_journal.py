import json

import pytest

from vh_drake.errors import BadInput
from vh_drake.journal import Journal

SETTINGS = {"seed": 3}


def test_results_are_there_again_after_a_restart(tmp_path):
    path = tmp_path / "deep" / "journal.jsonl"
    Journal(path, SETTINGS).add("a", {"x": 0.1 + 0.2})
    assert Journal(path, SETTINGS).results == {"a": {"x": 0.1 + 0.2}}


@pytest.mark.parametrize("cut", range(1, 30, 4))
def test_a_line_that_a_kill_cut_short_is_dropped_and_nothing_else(tmp_path, cut):
    path = tmp_path / "journal.jsonl"
    journal = Journal(path, SETTINGS)
    journal.add("a", 1)
    journal.add("b", "something that is long enough to cut")
    path.write_bytes(path.read_bytes()[:-cut])
    again = Journal(path, SETTINGS)
    assert again.results == {"a": 1}
    again.add("b", 2)
    assert Journal(path, SETTINGS).results == {"a": 1, "b": 2}


def test_a_journal_of_other_settings_is_refused_and_kept(tmp_path):
    path = tmp_path / "journal.jsonl"
    Journal(path, SETTINGS).add("a", 1)
    with pytest.raises(BadInput, match="other settings"):
        Journal(path, {"seed": 4})
    assert Journal(path, SETTINGS).results == {"a": 1}


@pytest.mark.parametrize("damage", [b"\xff\xfe\n", b"{}\n", b'{"key": 1}\n'])
def test_a_damaged_journal_is_named(tmp_path, damage):
    path = tmp_path / "journal.jsonl"
    Journal(path, SETTINGS)
    path.write_bytes(path.read_bytes() + damage)
    with pytest.raises(BadInput, match=r"journal\.jsonl"):
        Journal(path, SETTINGS)


def test_what_add_keeps_is_what_a_reader_gets(tmp_path):
    journal = Journal(tmp_path / "journal.jsonl", SETTINGS)
    journal.add("a", (1, 2))
    assert journal.results["a"] == [1, 2] == json.loads("[1, 2]")
