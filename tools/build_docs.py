"""Builds the API pages with pdoc; a warning fails the build.

Usage: python tools/build_docs.py FOLDER
"""

import html
import re
import sys
import warnings
from pathlib import Path
from textwrap import dedent

import pdoc

# A directive, its argument, and the deeper indented lines below it.
DIRECTIVE = re.compile(
    r"^(?P<indent>[ ]*)\.\. (?P<kind>math|pydrake_system)::(?P<argument>.*)\n?"
    r"(?P<body>(?:[ ]*\n|(?P=indent)[ ]+\S.*(?:\n|$))*)",
    re.MULTILINE,
)


def directives_to_markdown(docstring: str) -> str:
    """Turns the directives that pdoc does not know into what it shows well."""
    return DIRECTIVE.sub(_directive_to_markdown, docstring)


def _directive_to_markdown(match: re.Match[str]) -> str:
    text = "\n".join([match["argument"].strip(), dedent(match["body"])]).strip()
    if match["kind"] == "math":
        block = f"<div>$${html.escape(' '.join(text.split()), quote=False)}$$</div>"
    else:
        block = f"```yaml\n{text}\n```"
    lines = ["", *block.splitlines(), "", ""]
    return "\n".join(match["indent"] + line if line else "" for line in lines)


def main(folder: Path) -> int:
    """Writes the pages of every module of vh_drake; status 1 where pdoc warned."""
    convert = pdoc.docstrings.convert
    pdoc.docstrings.convert = lambda text, *rest: convert(directives_to_markdown(text), *rest)
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
