"""What a command that measures hands out: one object for people, files and programs."""

import csv
import dataclasses as dc
import io
import platform
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from vh_drake.result_files import write_json, write_text

Row = dict[str, Any]  # What JSON can hold

_PACKAGES = ("vh_drake", "drake", "numpy", "scipy", "numba", "torch")


@dc.dataclass(frozen=True)
class Report:
    """The result of a benchmark or of a reproduced table or figure.

    Attributes:
        name: of the command, such as "table-3.5".
        settings: all that the result depends on.
        summary: metrics, their names with units.
        thesis: the same metrics where the dissertation gives them.
        rows: what the summary was made of.
    """

    name: str
    settings: Mapping[str, Any]
    summary: Mapping[str, Any]
    thesis: Mapping[str, Any] = dc.field(default_factory=dict)
    rows: Sequence[Row] = ()

    def content(self) -> Row:
        """The report as JSON holds it; the versions of what computed it are added."""
        return {
            "name": self.name,
            "settings": {**self.settings, "versions": versions()},
            "summary": dict(self.summary),
            "thesis": dict(self.thesis),
            "rows": list(self.rows),
        }

    def save(self, out: Path) -> None:
        """Write <name>.json and, where there are rows, <name>.csv into a folder.

        Raises:
            VhDrakeError: the folder can't be written; old files stay.
        """
        write_json(out / f"{self.name}.json", self.content())
        if self.rows:
            write_text(out / f"{self.name}.csv", csv_text(self.rows))


def versions() -> dict[str, str]:
    """Of Python and the packages that decide about numbers."""
    return {"python": platform.python_version(), **{name: version(name) for name in _PACKAGES}}


def csv_text(rows: Sequence[Mapping[str, Any]]) -> str:
    """Rows as CSV; the columns are all keys in the order in which they come up."""
    columns = list(dict.fromkeys(key for row in rows for key in row))
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()
