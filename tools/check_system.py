"""Names the system packages that are missing, before anything is installed.

Runs on a bare Python, from `make venv`: it imports the standard library alone. With
`--tests` it asks for the programs that the tests start as well.
"""

import ctypes
import importlib.util
import shutil
import sys

# Library -> the Debian package that holds it. Drake, Open3D and torch load these.
LIBRARIES = {
    "libEGL.so.1": "libegl1",
    "libGL.so.1": "libgl1",
    "libGLX.so.0": "libglx0",
    "libX11.so.6": "libx11-6",
    "libgomp.so.1": "libgomp1",
    "libglib-2.0.so.0": "libglib2.0-0",
    "libudev.so.1": "libudev1",
    "libidn2.so.0": "libidn2-0",
}

# Debian package -> the programs of which one is enough.
TEST_PROGRAMS = {
    "chromium": ("chromium", "chromium-browser", "google-chrome"),  # Looks at Meshcat's pages.
    "graphviz": ("dot",),  # Draws diagrams.
}


def missing_packages(*, with_tests: bool) -> list[str]:
    """Debian names of the packages that are missing."""
    missing = [package for library, package in LIBRARIES.items() if not _loads(library)]
    if importlib.util.find_spec("ensurepip") is None:
        missing.append("python3-venv")
    if with_tests:
        missing += [
            package
            for package, programs in TEST_PROGRAMS.items()
            if not any(map(shutil.which, programs))
        ]
    return missing


def _loads(library: str) -> bool:
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


def main() -> int:
    """Prints the command that installs what is missing; status 1 where something is."""
    if not sys.platform.startswith("linux"):
        return 0  # The wheels of other platforms bring their libraries.
    missing = missing_packages(with_tests="--tests" in sys.argv)
    if missing:
        print(
            "system packages are missing; on Debian or Ubuntu install them with\n"
            f"  sudo apt-get install -y {' '.join(missing)}",
            file=sys.stderr,
        )
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main())
