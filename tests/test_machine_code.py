import subprocess
import sys
import time
from pathlib import Path

import pytest

import vh_drake
from vh_drake.machine_code import forget_stale

KERNEL = """from numba import njit

@njit(cache=True)
def kernel(x):
    return {factor} * x
"""
CALLER = """from numba import njit

from vh_drake.kernels import kernel

@njit(cache=True)
def caller(x):
    return kernel(x) + 1.0
"""
OTHER = """from numba import njit

@njit(cache=True)
def other(x):
    return x
"""
RUN = "from vh_drake.a.caller import caller; from vh_drake.other import other; other(1.0);"
RUN += "print(caller(3.0))"


@pytest.fixture
def package(tmp_path):
    """A package of that name with a kernel, a function elsewhere that calls it, and another."""
    root = tmp_path / "vh_drake"
    (root / "a").mkdir(parents=True)
    own = Path(vh_drake.__file__).parent
    for name in ("__init__.py", "machine_code.py", "atomic_files.py", "errors.py"):
        (root / name).write_text((own / name).read_text())
    (root / "a" / "__init__.py").write_text("")
    (root / "kernels.py").write_text(KERNEL.format(factor=2.0))
    (root / "a" / "caller.py").write_text(CALLER)
    (root / "other.py").write_text(OTHER)
    return root


def result(package):
    python = [sys.executable, "-c", RUN]
    done = subprocess.run(python, cwd=package.parent, check=True, capture_output=True)
    return float(done.stdout)


def kept(package):
    return {path: path.stat().st_mtime_ns for path in package.rglob("*.nbi")}


def test_a_changed_kernel_changes_what_calls_it_and_nothing_else_is_compiled_again(package):
    assert result(package) == 7.0
    before = kept(package)
    assert len(before) == 3
    (package / "kernels.py").write_text(KERNEL.format(factor=5.0))
    assert result(package) == 16.0
    after = kept(package)
    assert {path.name.split(".")[0] for path in before if before[path] == after[path]} == {"other"}


def test_what_has_not_changed_stays(package):
    result(package)
    before = kept(package)
    assert result(package) == 7.0
    assert kept(package) == before


def test_a_damaged_stamp_costs_a_compilation_and_no_more(package):
    result(package)
    (package / "__pycache__" / "machine_code.json").write_text("{")
    forget_stale(package)
    assert not kept(package)
    assert result(package) == 7.0


def test_looking_costs_little():
    start = time.perf_counter()
    forget_stale(Path(vh_drake.__file__).parent)
    assert time.perf_counter() - start < 0.5
