"""Builds the API pages with pdoc; a warning fails the build.

Usage: python tools/build_docs.py FOLDER
"""

import sys
import warnings
from pathlib import Path

import pdoc


def main(folder: Path) -> int:
    """Writes the pages of every module of vh_drake; status 1 where pdoc warned."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        pdoc.render.configure(docformat="google", math=True)
        pdoc.pdoc("vh_drake", output_directory=folder)
    for warning in caught:
        print(f"{warning.filename}:{warning.lineno}: {warning.message}", file=sys.stderr)
    print(f"{len(list(folder.rglob('*.html')))} pages in {folder}, {len(caught)} warnings")
    return 1 if caught else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
