"""Pictures of web pages, taken by a headless Chromium without a GPU."""

import shutil
import subprocess
import tempfile
from pathlib import Path

from vh_drake.errors import VhDrakeError

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
LIMIT_S = 45.0
ATTEMPTS = 3

FLAGS = (
    "--headless",
    "--no-sandbox",  # Chromium refuses its sandbox to root, which CI often is.
    "--disable-gpu",
    "--enable-unsafe-swiftshader",  # WebGL in software.
    "--disable-dev-shm-usage",  # Containers have little shared memory.
    "--disable-quic",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-extensions",
    "--disable-sync",
    "--hide-scrollbars",
    "--mute-audio",
    "--no-first-run",
)


def find_browser() -> str:
    """Path of the browser.

    Raises:
        VhDrakeError: there is none.
    """
    found = next(filter(None, map(shutil.which, BROWSERS)), None)
    if found is None:
        raise VhDrakeError("no Chromium on the PATH; apt-get install chromium")
    return found


def screenshot(
    page: str | Path, picture: Path, *, budget_s: float = 5.0, size: tuple[int, int] = (640, 480)
) -> Path:
    """Writes a PNG of a page, as it looks once its scripts had `budget_s` of virtual time.

    Args:
        page: A URL, or a file.
        picture: Where the PNG is written.
        budget_s: Virtual time of the page [s]; it stands still while a download is under way.
        size: Width and height of the window in pixels.

    Returns:
        The path of the picture.

    Raises:
        VhDrakeError: there is no browser, or it makes no picture.
    """
    url = page.resolve().as_uri() if isinstance(page, Path) else page
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        command = [
            find_browser(),
            *FLAGS,
            f"--user-data-dir={profile}",
            f"--window-size={size[0]},{size[1]}",
            f"--virtual-time-budget={round(budget_s * 1000)}",
            f"--screenshot={picture}",
            url,
        ]
        done = _run(command)
    if done is None:
        raise VhDrakeError(
            f"{url} gave no picture within {ATTEMPTS} times {LIMIT_S:g} s; "
            f"lower budget_s ({budget_s:g})"
        )
    if not picture.is_file():
        raise VhDrakeError(f"{url} gave no picture: {done.stderr[-2000:]}")
    return picture


def _run(command: list[str]) -> subprocess.CompletedProcess[str] | None:
    """Runs the browser, anew where it hangs, as its virtual time does now and then under load."""
    for _ in range(ATTEMPTS):
        try:
            return subprocess.run(command, capture_output=True, text=True, timeout=LIMIT_S)
        except subprocess.TimeoutExpired:
            continue
    return None
