"""A run as one HTML file that opens without a server."""

import os
import tempfile
from pathlib import Path

from pydrake.geometry import Meshcat

from vh_drake.errors import TooLarge

FRAMES_PER_S = 20.0
MOST_BYTES = 25_000_000


def start_recording(meshcat: Meshcat, *, frames_per_s: float = FRAMES_PER_S) -> None:
    """From now on motions and visibilities are kept, by simulated time.

    Visualizer and publishers must not publish much more often than `frames_per_s`.
    """
    meshcat.StartRecording(frames_per_second=frames_per_s, set_visualizations_while_recording=True)


def write_recording(meshcat: Meshcat, path: str | Path) -> Path:
    """Ends the recording and writes it, whole or not at all.

    Args:
        meshcat: that records.
        path: of the HTML file; missing folders are made.

    Returns:
        The path.

    Raises:
        TooLarge: the recording is larger than `MOST_BYTES`.
        OSError: the file can't be written.
    """
    meshcat.StopRecording()
    meshcat.PublishRecording()
    page = meshcat.StaticHtml().encode()
    if len(page) > MOST_BYTES:
        raise TooLarge(
            f"the recording has {len(page) / 1e6:.0f} MB, more than {MOST_BYTES / 1e6:.0f}; "
            "record a shorter time or fewer frames per second"
        )
    return _write_whole(Path(path), page)


def _write_whole(path: Path, data: bytes) -> Path:
    """Write beside the file, then move it there: a killed run leaves no half of it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=path.name, suffix=".part")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
        os.chmod(name, 0o644)
        os.replace(name, path)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise
    return path
