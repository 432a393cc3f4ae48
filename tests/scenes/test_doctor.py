import socket
import subprocess
import sys
from collections import namedtuple
from pathlib import Path

import numpy as np
import pytest
from safetensors.numpy import save_file

from vh_drake.scenes import doctor
from vh_drake.scenes.doctor import Check


def missing(name: str) -> str:
    raise doctor.PackageNotFoundError(name)


def process(returncode: int, stdout: str = "", stderr: str = ""):
    """A stand-in for `subprocess.run` that ends as told."""
    return lambda *_, **__: subprocess.CompletedProcess([], returncode, stdout, stderr)


def test_this_machine_passes_every_check():
    checks = doctor.examine()
    assert [check.name for check in checks if not check.ok] == []
    assert len(checks) == 8


def test_an_old_python_is_named_with_its_remedy(monkeypatch):
    info = namedtuple("info", "major minor micro releaselevel serial")(3, 9, 2, "final", 0)
    monkeypatch.setattr(doctor.sys, "version_info", info)
    check = doctor.check_python()
    assert (check.ok, check.found) == (False, "3.9.2")
    assert "3.11" in check.remedy


@pytest.mark.parametrize("found", ["1.50.2", "0.99.0"])
def test_an_old_drake_is_named_with_its_remedy(monkeypatch, found):
    monkeypatch.setattr(doctor, "version", lambda _: found)
    check = doctor.check_drake()
    assert (check.ok, check.found) == (False, found)
    assert "pip install 'drake>=1.51'" in check.remedy


def test_a_missing_drake_is_named_with_its_remedy(monkeypatch):
    monkeypatch.setattr(doctor, "version", missing)
    check = doctor.check_drake()
    assert not check.ok
    assert "pip install 'drake" in check.remedy


def test_a_drake_that_does_not_load_is_named_with_its_remedy(monkeypatch):
    monkeypatch.setitem(sys.modules, "pydrake.multibody.plant", None)
    check = doctor.check_drake()
    assert not check.ok
    assert "does not load" in check.found
    assert "pip install 'drake" in check.remedy


@pytest.mark.parametrize(
    ("run", "fault"),
    [
        (process(-11), "exit status -11"),
        (process(1, stderr="Traceback\nRuntimeError: no EGL device"), "no EGL device"),
        (process(0, stdout="0.0\n"), "depth 0 m"),
    ],
)
def test_ray_casting_stands_in_for_broken_rendering(monkeypatch, run, fault):
    monkeypatch.setattr(doctor.subprocess, "run", run)
    check = doctor.check_rendering()
    assert check.ok
    assert "ray casting" in check.found
    assert fault in check.found
    assert "libegl1" in check.remedy


def test_broken_rendering_without_ray_casting_fails(monkeypatch):
    monkeypatch.setattr(doctor.subprocess, "run", process(-6))
    monkeypatch.setattr(doctor.importlib.util, "find_spec", lambda _: None)
    check = doctor.check_rendering()
    assert not check.ok
    assert "libegl1" in check.remedy


def test_rendering_that_hangs_counts_as_broken(monkeypatch):
    def hang(*_, **__):
        raise subprocess.TimeoutExpired("probe", doctor.PROBE_SECONDS)

    monkeypatch.setattr(doctor.subprocess, "run", hang)
    assert "no image within 60 s" in doctor.check_rendering().found


def test_models_that_do_not_parse_are_named_with_their_remedy(monkeypatch, tmp_path):
    hand = Path(__file__).parents[2] / "models" / "armar6_hand"
    (tmp_path / "armar6_hand").symlink_to(hand)
    (tmp_path / "robot").mkdir()
    (tmp_path / "robot" / "robot.urdf").write_text("<robot")
    monkeypatch.setattr(doctor, "models_folder", lambda: tmp_path)
    check = doctor.check_models()
    assert not check.ok
    assert "install vh_drake again" in check.remedy


def test_missing_models_are_named_with_their_remedy(monkeypatch, tmp_path):
    monkeypatch.setattr(doctor, "models_folder", lambda: tmp_path)
    check = doctor.check_models()
    assert not check.ok
    assert "0 hands and 0 robots" in check.found


def test_weights_that_are_cut_short_are_named_with_their_remedy(monkeypatch, tmp_path):
    (tmp_path / "weights").mkdir()
    (tmp_path / "weights" / "metric.safetensors").write_bytes(b"\x10\x00\x00")
    monkeypatch.setattr(doctor, "models_folder", lambda: tmp_path)
    check = doctor.check_weights()
    assert not check.ok
    assert "metric.safetensors" in check.found
    assert check.remedy


def test_whole_weights_are_listed(monkeypatch, tmp_path):
    (tmp_path / "weights").mkdir()
    save_file({"w": np.ones(3)}, tmp_path / "weights" / "metric.safetensors")
    monkeypatch.setattr(doctor, "models_folder", lambda: tmp_path)
    assert doctor.check_weights() == Check("Weights", True, "metric")


def test_absent_weights_are_reported_and_are_no_failure(monkeypatch, tmp_path):
    monkeypatch.setattr(doctor, "models_folder", lambda: tmp_path)
    check = doctor.check_weights()
    assert check.ok
    assert "no learned metric" in check.found


def test_too_little_memory_is_named_with_its_remedy(monkeypatch):
    monkeypatch.setattr(doctor, "free_memory_gb", lambda: 1.5)
    check = doctor.check_memory()
    assert (check.ok, check.found) == (False, "1.5 GB")
    assert "at least 4 GB" in check.remedy


def test_unknown_memory_is_no_failure(monkeypatch):
    monkeypatch.setattr(doctor, "free_memory_gb", lambda: None)
    assert doctor.check_memory().ok


def test_taken_ports_are_named_with_their_remedy(monkeypatch):
    with socket.socket() as server:
        server.bind(("127.0.0.1", 0))
        server.listen()
        port = server.getsockname()[1]
        monkeypatch.setattr(doctor, "MESHCAT_PORTS", range(port, port + 1))
        check = doctor.check_meshcat_port()
    assert not check.ok
    assert str(port) in check.found
    assert "--no-meshcat" in check.remedy


def test_missing_robot_meshes_are_no_failure(monkeypatch):
    monkeypatch.setattr(doctor, "version", missing)
    check = doctor.check_visuals()
    assert check.ok
    assert "vh_drake[visuals]" in check.remedy


def test_a_check_that_breaks_counts_as_failed(monkeypatch):
    def check_moon() -> Check:
        raise RuntimeError("eclipse")

    monkeypatch.setattr(doctor, "CHECKS", (check_moon,))
    (check,) = doctor.examine()
    assert (check.name, check.ok) == ("moon", False)
    assert "eclipse" in check.found
