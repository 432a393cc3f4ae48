"""Looks at what a grasp needs of this machine, and names the remedy of each failure."""

import importlib
import importlib.util
import socket
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from vh_drake.geometry.model_files import models_folder

OLDEST_PYTHON = (3, 11)
OLDEST_DRAKE = (1, 51)
LEAST_MEMORY_GB = 4.0
MESHCAT_PORTS = range(7000, 7100)  # Those that Drake's Meshcat tries in turn.
PROBE_SECONDS = 60.0


@dataclass(frozen=True)
class Check:
    """The outcome of one look at the machine."""

    name: str
    ok: bool
    found: str
    remedy: str = ""  # What mends a failure, or betters what is merely good enough.


def examine() -> list[Check]:
    """Runs every check; a check that breaks in an unforeseen way counts as failed."""
    return [_guarded(check) for check in CHECKS]


def check_python() -> Check:
    """Whether Python is new enough."""
    found = ".".join(str(part) for part in sys.version_info[:3])
    wanted = ".".join(map(str, OLDEST_PYTHON))
    ok = tuple(sys.version_info[:2]) >= OLDEST_PYTHON
    return Check("Python", ok, found, "" if ok else f"install Python {wanted} or newer")


def check_drake() -> Check:
    """Whether Drake is there, recent, and loads."""
    remedy = f"python -m pip install 'drake>={'.'.join(map(str, OLDEST_DRAKE))}'"
    try:
        found = version("drake")
        importlib.import_module("pydrake.multibody.plant")
    except (PackageNotFoundError, ImportError) as error:
        return Check("Drake", False, f"does not load: {error}", remedy)
    ok = tuple(int(part) for part in found.split(".")[:2]) >= OLDEST_DRAKE
    return Check("Drake", ok, found, "" if ok else remedy)


def check_rendering() -> Check:
    """Whether depth images come from EGL; ray casting on the CPU stands in where not."""
    fault = _rendering_fault()
    if not fault:
        return Check("Depth rendering", True, "EGL")
    remedy = "apt-get install libegl1 libgl1-mesa-dri"
    if importlib.util.find_spec("vh_drake.sensing.ray_caster") is None:
        return Check("Depth rendering", False, f"no EGL ({fault})", remedy)
    return Check("Depth rendering", True, f"ray casting on the CPU, as EGL fails: {fault}", remedy)


def _rendering_fault() -> str:
    """Empty where a process of its own renders a box at the right depth."""
    from vh_drake.scenes.render_probe import BOX_DEPTH_M

    command = [sys.executable, "-m", "vh_drake.scenes.render_probe"]
    try:
        probe = subprocess.run(command, capture_output=True, text=True, timeout=PROBE_SECONDS)
    except subprocess.TimeoutExpired:
        return f"no image within {PROBE_SECONDS:g} s"
    if probe.returncode != 0:
        lines = probe.stderr.strip().splitlines() or [f"exit status {probe.returncode}"]
        return lines[-1][:120]
    depth_m = float(probe.stdout.split()[-1])
    return "" if abs(depth_m - BOX_DEPTH_M) < 1e-3 else f"depth {depth_m:g} m, not {BOX_DEPTH_M:g}"


def check_models() -> Check:
    """Whether the robot, its hand and the hand's description load."""
    remedy = "install vh_drake again: python -m pip install --force-reinstall --no-deps vh_drake"
    try:
        found = _load_models(models_folder())
    except Exception as error:  # Whatever the parsers raise, the models are unusable.
        return Check("Models", False, str(error)[:200], remedy)
    return Check("Models", True, found)


def _load_models(folder: Path) -> str:
    """Parses every robot and hand; says what was parsed."""
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant

    from vh_drake.geometry.model_files import add_models
    from vh_drake.hand.description import load_hand

    hands = [load_hand(file) for file in sorted(folder.glob("*_hand/*.yaml"))]
    robots = sorted(folder.glob("*/*.urdf"))
    if not hands or not robots:
        raise FileNotFoundError(f"{len(hands)} hands and {len(robots)} robots in {folder}")
    for file in [*robots, *(Path(hand.model) for hand in hands)]:
        plant = MultibodyPlant(time_step=0.002)
        parser = Parser(plant)
        add_models(parser)
        parser.AddModels(file)
    return ", ".join([*(file.stem for file in robots), *(hand.name for hand in hands)])


def check_weights() -> Check:
    """Whether shipped weights of the learned metric can be read; none are needed."""
    files = sorted(models_folder().glob("weights/*.safetensors"))
    if not files:
        found = "no learned metric is shipped; grasps are rated by the force-closure rate"
        return Check("Weights", True, found)
    from safetensors import SafetensorError, safe_open

    for file in files:
        try:
            with safe_open(file, framework="numpy") as weights:
                weights.keys()
        except (SafetensorError, OSError) as error:
            return Check("Weights", False, f"{file.name}: {error}", "install vh_drake again")
    return Check("Weights", True, ", ".join(file.stem for file in files))


def check_memory() -> Check:
    """Whether enough memory is free."""
    free_gb = free_memory_gb()
    if free_gb is None:
        return Check("Free memory", True, "not known on this system")
    remedy = f"free memory: at least {LEAST_MEMORY_GB:g} GB are needed"
    ok = free_gb >= LEAST_MEMORY_GB
    return Check("Free memory", ok, f"{free_gb:.1f} GB", "" if ok else remedy)


def free_memory_gb() -> float | None:
    """Memory that programs can still take [GB]; None where the system does not tell."""
    meminfo = Path("/proc/meminfo")
    if not meminfo.is_file():
        return None
    lines = dict(line.split(":", 1) for line in meminfo.read_text().splitlines())
    return float(lines["MemAvailable"].split()[0]) * 1024 / 1e9


def check_meshcat_port() -> Check:
    """Whether Meshcat finds a free port on this machine's own address."""
    port = next((port for port in MESHCAT_PORTS if _is_free(port)), None)
    if port is not None:
        return Check("Meshcat port", True, f"localhost:{port}")
    found = f"all of {MESHCAT_PORTS.start} to {MESHCAT_PORTS.stop - 1} are taken"
    return Check("Meshcat port", False, found, "end other Meshcat servers, or use --no-meshcat")


def _is_free(port: int) -> bool:
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(("127.0.0.1", port))
        except OSError:
            return False
    return True


def check_visuals() -> Check:
    """Whether the real robot's meshes are installed; primitive shapes stand in where not."""
    try:
        return Check("Robot meshes", True, f"armar {version('armar')}")
    except PackageNotFoundError:
        remedy = "python -m pip install 'vh_drake[visuals]'  (CC BY-NC 4.0)"
        return Check("Robot meshes", True, "primitive shapes", remedy)


CHECKS: tuple[Callable[[], Check], ...] = (
    check_python,
    check_drake,
    check_rendering,
    check_models,
    check_weights,
    check_memory,
    check_meshcat_port,
    check_visuals,
)


def _guarded(check: Callable[[], Check]) -> Check:
    try:
        return check()
    except Exception as error:  # The doctor itself must always finish.
        name = check.__name__.removeprefix("check_")
        return Check(name, False, f"{type(error).__name__}: {error}", "report this message")
