"""Drawings of diagrams."""

import shutil
import subprocess
from pathlib import Path

from pydrake.systems.framework import Diagram

from vh_drake.errors import BadInput, VhDrakeError

FORMATS = ("svg", "png", "pdf")  # that Graphviz makes, beside its own source, "dot"
DEPTH = 2  # station and decision with their systems, but not the inside of a camera
LIMIT_S = 60.0


def draw_diagram(diagram: Diagram, path: str | Path, *, depth: int = DEPTH) -> Path:
    """Draws systems, ports and connections of a diagram.

    Args:
        diagram: what is drawn.
        path: of the picture; its ending names the format: svg, png, pdf or dot.
        depth: of nested diagrams that are opened.

    Returns:
        The path.

    Raises:
        BadInput: the ending is none of those.
        VhDrakeError: Graphviz is missing or fails; "dot" needs none.
    """
    path = Path(path)
    kind = path.suffix.lower().removeprefix(".")
    if kind not in (*FORMATS, "dot"):
        choices = ", ".join(f".{name}" for name in (*FORMATS, "dot"))
        raise BadInput(f"can't draw into {path.name!r}; let its name end in one of {choices}")
    source: str = diagram.GetGraphvizString(max_depth=depth)
    picture = source.encode() if kind == "dot" else _rendered(source, kind)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(picture)
    return path


def _rendered(source: str, kind: str) -> bytes:
    program = shutil.which("dot")
    if program is None:
        raise VhDrakeError(
            "Graphviz is missing; apt-get install graphviz, or let the name of the file end "
            "in .dot to get the source alone"
        )
    done = subprocess.run(
        [program, f"-T{kind}"], input=source.encode(), capture_output=True, timeout=LIMIT_S
    )
    if done.returncode:
        raise VhDrakeError(f"Graphviz failed: {done.stderr.decode(errors='replace')[-500:]}")
    return done.stdout
