"""Machine code that numba keeps is forgotten once a source that it was made from has changed.

numba keeps the machine code of a function beside its module, and asks only whether that module is
still the same. What the function calls, or reads as a constant, in other modules is compiled in: a
changed kernel would go on as it was in all that call it.
"""

import functools
import hashlib
import json
import re
from collections.abc import Callable, Mapping
from pathlib import Path

from vh_drake.atomic_files import write_bytes
from vh_drake.errors import VhDrakeError

_IMPORT = re.compile(r"^ *from (vh_drake[\w.]*) import (\([^)]*\)|.*)", re.MULTILINE)
_STAMP = "__pycache__/machine_code.json"


def forget_stale(package: Path) -> None:
    """Remove the kept machine code of modules that changed, or import what did.

    Nothing happens where the package's folder can't be written: numba then keeps nothing in it.

    Args:
        package: folder of `vh_drake`.
    """
    stamp = package / _STAMP
    digests = _digests(package)
    if digests == (known := _known(stamp)):
        return
    try:
        for module, digest in digests.items():
            if known.get(module) != digest:
                path = package / module
                for kept in path.parent.glob(f"__pycache__/{path.stem}.*.nbi"):
                    kept.unlink(missing_ok=True)
        write_bytes(stamp, json.dumps(digests).encode())
    except (OSError, VhDrakeError):
        return


def _known(stamp: Path) -> Mapping[str, str]:
    try:
        known = json.loads(stamp.read_text())
    except (OSError, ValueError):
        return {}
    return known if isinstance(known, dict) else {}


def _digests(package: Path) -> dict[str, str]:
    """A digest of each module that is compiled, and of all of the package that it imports."""
    texts = {
        str(path.relative_to(package)): path.read_text(encoding="utf-8")
        for folder in [package, *sorted(p for p in package.iterdir() if p.is_dir())]
        for path in sorted(folder.glob("*.py"))
    }
    imports = functools.cache(lambda name: _imports(texts[name], texts))
    digests = {}
    for name in (name for name, text in texts.items() if "njit" in text):
        whole = "".join(texts[part] for part in sorted(_closure(name, imports)))
        digests[name] = hashlib.sha256(whole.encode()).hexdigest()
    return digests


def _imports(text: str, texts: Mapping[str, str]) -> set[str]:
    """The modules of the package that a text imports."""
    found = set()
    for module, names in _IMPORT.findall(text):
        path = "/".join(module.split(".")[1:])
        tails = re.findall(r"\w+", names)
        found |= {f"{path}.py", *(f"{path}/{tail}.py".lstrip("/") for tail in tails)} & texts.keys()
    return found


def _closure(name: str, imports: Callable[[str], set[str]]) -> set[str]:
    """A module and all that it imports, at first or second hand and so on."""
    seen, waiting = {name}, [name]
    while waiting:
        new = imports(waiting.pop()) - seen
        seen |= new
        waiting += new
    return seen
