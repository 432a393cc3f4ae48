"""Figures as files: without a window, the same bytes for the same figure."""

import io
from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from vh_drake.atomic_files import write_bytes


def save_figure(path: Path, figure: Figure) -> None:
    """Write a figure as PNG.

    Raises:
        VhDrakeError: the folder can't be written.
    """
    FigureCanvasAgg(figure)
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=110, metadata={"Software": None})
    write_bytes(path, stream.getvalue())
