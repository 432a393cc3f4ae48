"""Grasps of a data set that were carried out, as they are kept beside its shards."""

import dataclasses as dc
from pathlib import Path

from vh_drake.journal import Journal

GRASPS = 16  # of each scene that are carried out
LIFTS_FILE = "lifts.jsonl"
LIFTS_SETTINGS = {"grasps": GRASPS}


@dc.dataclass(frozen=True)
class Lifted:
    """Grasps of one scene that were carried out."""

    scene: int
    grasps: list[int]  # indices of candidates
    lifted: list[bool]


def read_lifts(folder: Path) -> dict[int, Lifted]:
    """What `dataset lift` kept, by scene; empty without any.

    Raises:
        BadInput: the file is damaged.
    """
    path = folder / LIFTS_FILE
    if not path.is_file():
        return {}
    rows = (Lifted(**row) for row in Journal(path, LIFTS_SETTINGS).results.values())
    return {row.scene: row for row in rows}
