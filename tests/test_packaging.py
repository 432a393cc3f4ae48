import os
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
UNPACKED = ("LICENSE", "README.md", "pyproject.toml", "vh_drake", "systems", "models")


@pytest.fixture(scope="module")
def sdist(tmp_path_factory) -> Path:
    """The source distribution, built from a copy so that the checkout stays as it is."""
    folder = tmp_path_factory.mktemp("sdist")
    for name in UNPACKED:
        source = ROOT / name
        if source.is_dir():
            ignored = shutil.ignore_patterns("__pycache__")
            shutil.copytree(source, folder / name, symlinks=True, ignore=ignored)
        else:
            shutil.copy(source, folder / name)
    return build("build_sdist", folder)


@pytest.fixture(scope="module")
def wheel(sdist: Path, tmp_path_factory) -> Path:
    """The wheel, built from the source distribution as an installer does."""
    folder = tmp_path_factory.mktemp("wheel")
    with tarfile.open(sdist) as archive:
        archive.extractall(folder, filter="data")
    (unpacked,) = folder.iterdir()
    return build("build_wheel", unpacked)


def build(hook: str, folder: Path) -> Path:
    """Calls a hook of the build backend in a folder; gives the file that it wrote."""
    code = f"from setuptools import build_meta; print('\\n' + build_meta.{hook}('.'))"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr[-2000:]
    return folder / done.stdout.splitlines()[-1]


def tracked(folder: str) -> set[str]:
    """Files of a folder of the checkout that belong into the package."""
    return {
        f"vh_drake/{path.relative_to(ROOT)}"
        for path in (ROOT / folder).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }


def test_the_sdist_holds_every_system_and_model(sdist):
    with tarfile.open(sdist) as archive:
        names = {name.split("/", 1)[-1] for name in archive.getnames()}
    assert tracked("systems") | tracked("models") <= names


def test_the_wheel_holds_every_system_and_model_once(wheel):
    names = zipfile.ZipFile(wheel).namelist()
    assert tracked("systems") | tracked("models") <= set(names)
    assert len(names) == len(set(names))
    folders = {name.split("/")[0] for name in names}
    assert {folder for folder in folders if not folder.endswith(".dist-info")} == {"vh_drake"}


def test_the_wheel_names_its_licence_and_its_command(wheel):
    archive = zipfile.ZipFile(wheel)
    (entry_points,) = (n for n in archive.namelist() if n.endswith("entry_points.txt"))
    assert "vh-drake = vh_drake.cli:main" in archive.read(entry_points).decode()
    assert [n for n in archive.namelist() if n.endswith("licenses/LICENSE")]


def test_an_unpacked_wheel_finds_its_systems_and_models(wheel, tmp_path):
    zipfile.ZipFile(wheel).extractall(tmp_path)
    code = (
        "import vh_drake.systems; from vh_drake.geometry.model_files import models_folder;"
        "print(vh_drake.systems.__file__); print(models_folder())"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
    )
    assert all(Path(line).is_relative_to(tmp_path.resolve()) for line in done.stdout.splitlines())


def test_constraints_pin_every_dependency_of_the_package():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = [name for group in project["optional-dependencies"].values() for name in group]
    wanted = {normal(text) for text in [*project["dependencies"], *extras]}
    lines = (ROOT / "constraints.txt").read_text().splitlines()
    pinned = {normal(line) for line in lines if not line.startswith("#")}
    assert wanted <= pinned
    assert "torch==2.13.0" in lines


def normal(requirement: str) -> str:
    """The name of a requirement as the package index spells it."""
    for sign in "=<>[;":
        requirement = requirement.split(sign)[0]
    return requirement.strip().lower().replace("_", "-")
