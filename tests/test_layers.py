"""The import direction of the package, and what no module of it may use."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]

# A module may import from its own folder and from earlier rows, never from later ones.
LAYERS = (
    (
        "types",
        "errors",
        "yaml_files",
        "atomic_files",
        "machine_code",
        "result_files",
        "reports",
        "journal",
        "batch",
        "catalog",
    ),
    ("geometry",),
    ("objects", "gpis", "hand", "sensing", "control"),
    ("exploration", "grasping"),
    ("learning",),
    ("systems",),
    ("scenes",),
    ("experiments",),
    ("benches",),
    ("cli",),
)
RANK = {name: rank for rank, row in enumerate(LAYERS) for name in row}
OUTSIDE = ("__init__", "__main__", "models")  # They import one module each, or nothing.

FORBIDDEN_MODULES = ("pydrake.all", "systems", "pickle", "cPickle", "dill", "shelve", "marshal")
FORBIDDEN_CALLS = ("yaml.load", "yaml.unsafe_load", "torch.load", "StartMeshcat")
FORBIDDEN_BUILTINS = ("eval", "exec")  # Not as methods: `network.eval()` is something else.


def imported_modules(tree: ast.AST, package: tuple[str, ...]) -> Iterator[tuple[int, str]]:
    """Lines and absolute names of all that a module imports, wherever it stands."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            start = package[: len(package) + 1 - node.level] if node.level else ()
            base = ".".join([*start, *filter(None, [node.module])])
            yield node.lineno, base
            yield from ((node.lineno, f"{base}.{alias.name}") for alias in node.names)


def layer_faults(source: str, module: str) -> list[str]:
    """What in a module breaks the direction of imports; `module` as in `vh_drake.gpis.kernels`."""
    parts = module.split(".")
    own = parts[1]
    faults = []
    for line, name in imported_modules(ast.parse(source), tuple(parts[:-1])):
        target = name.split(".")[1] if name.startswith("vh_drake.") else ""
        if target in RANK and target != own and not is_below(target, own):
            faults.append(f"{module}:{line} imports {name}, which is not below {own}")
    return faults


def is_below(target: str, own: str) -> bool:
    """Whether a folder may be imported; the modules of the lowest row may import each other."""
    return RANK[target] < RANK[own] or RANK[target] == RANK[own] == 0


def forbidden_faults(source: str, module: str) -> list[str]:
    """What in a module is unsafe with files of others, or unstable in Drake."""
    tree = ast.parse(source)
    imports = [
        f"{module}:{line} imports {bad}"
        for line, name in imported_modules(tree, tuple(module.split(".")[:-1]))
        for bad in FORBIDDEN_MODULES
        if name == bad or name.startswith(bad + ".")
    ]
    calls = [
        f"{module}:{node.lineno} calls {ast.unparse(node.func)}"
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and is_forbidden_call(ast.unparse(node.func))
    ]
    return imports + calls


def is_forbidden_call(called: str) -> bool:
    """Whether a called name, as written, is among the forbidden ones."""
    return called in FORBIDDEN_BUILTINS or any(
        called == bad or called.endswith(f".{bad}") for bad in FORBIDDEN_CALLS
    )


def sources() -> list[tuple[str, Path]]:
    """Module names and files of the package, `systems/` under its importable name."""
    package = ROOT / "vh_drake"
    files = {
        *(p for p in package.rglob("*.py") if not p.is_relative_to(package / "systems")),
        *(package / "systems").glob("*.py"),
    }
    return [
        (".".join(file.relative_to(ROOT).with_suffix("").parts), file) for file in sorted(files)
    ]


def test_every_module_lies_in_a_layer():
    unknown = {name.split(".")[1] for name, _ in sources()} - set(RANK) - set(OUTSIDE)
    assert not unknown, f"add {sorted(unknown)} to LAYERS"


def test_systems_are_among_the_sources():
    assert "vh_drake.systems.__init__" in {name for name, _ in sources()}


def test_imports_run_one_way():
    faults = [
        fault
        for name, file in sources()
        if name.split(".")[1] in RANK
        for fault in layer_faults(file.read_text(), name)
    ]
    assert not faults, "\n".join(faults)


def test_nothing_unsafe_or_unstable_is_used():
    faults = [
        fault for name, file in sources() for fault in forbidden_faults(file.read_text(), name)
    ]
    assert not faults, "\n".join(faults)


@pytest.mark.parametrize(
    ("source", "module"),
    [
        ("from vh_drake.systems.camera import Camera", "vh_drake.gpis.kernels"),
        ("import vh_drake.cli", "vh_drake.scenes.station"),
        ("from vh_drake import exploration", "vh_drake.geometry.meshes"),
        ("def f():\n    from vh_drake.grasping import planner", "vh_drake.exploration.igef"),
        ("from ..scenes import station", "vh_drake.systems.camera"),
        ("from vh_drake.geometry import meshes", "vh_drake.types"),
    ],
)
def test_the_checker_finds_an_import_against_the_direction(source, module):
    assert len(layer_faults(source, module)) >= 1


@pytest.mark.parametrize(
    ("source", "module"),
    [
        ("from vh_drake.gpis.kernels import cubic", "vh_drake.systems.estimator"),
        ("from vh_drake.types import Cloud", "vh_drake.geometry.meshes"),
        ("from vh_drake.errors import BadInput", "vh_drake.yaml_files"),
        ("from . import kernels\nfrom .kernels import cubic", "vh_drake.gpis.posterior"),
        ("import numpy as np\nimport pydrake.math", "vh_drake.gpis.posterior"),
    ],
)
def test_the_checker_allows_imports_along_the_direction(source, module):
    assert layer_faults(source, module) == []


@pytest.mark.parametrize(
    "source",
    [
        "from pydrake.all import RigidTransform",
        "from pydrake import all",
        "import systems.camera",
        "from systems import camera",
        "import pickle",
        "data = yaml.load(text)",
        "net = torch.load(path)",
        "meshcat = StartMeshcat()",
        "meshcat = geometry.StartMeshcat()",
        "value = eval(text)",
    ],
)
def test_the_checker_finds_what_is_forbidden(source):
    assert forbidden_faults(source, "vh_drake.scenes.station")


@pytest.mark.parametrize(
    "source",
    [
        "from vh_drake.systems import camera",
        "from pydrake.systems.framework import LeafSystem",
        "data = yaml.safe_load(text)",
        "network.eval()",
        "port.Eval(context)",
    ],
)
def test_the_checker_allows_what_resembles_the_forbidden(source):
    assert forbidden_faults(source, "vh_drake.scenes.station") == []
