import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).parents[2] / "tools"))
import check_system


def test_a_whole_system_lacks_nothing(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["check_system.py", "--tests"])
    assert check_system.main() == 0
    assert capsys.readouterr().err == ""


def test_a_missing_library_is_named_by_its_package(monkeypatch, capsys):
    monkeypatch.setattr(check_system, "LIBRARIES", {"libnowhere.so.7": "libnowhere7"})
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr(sys, "argv", ["check_system.py"])
    assert check_system.main() == 1
    assert "apt-get install -y libnowhere7" in capsys.readouterr().err


@pytest.mark.parametrize(("with_tests", "missing"), [(True, ["chromium", "graphviz"]), (False, [])])
def test_programs_are_asked_for_by_the_tests_alone(monkeypatch, with_tests, missing):
    monkeypatch.setattr(check_system.shutil, "which", lambda _: None)
    assert check_system.missing_packages(with_tests=with_tests) == missing


def test_other_platforms_are_not_asked(monkeypatch):
    monkeypatch.setattr(check_system, "LIBRARIES", {"libnowhere.so.7": "libnowhere7"})
    monkeypatch.setattr(sys, "platform", "darwin")
    assert check_system.main() == 0
