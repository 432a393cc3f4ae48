"""The hands that come with the package, by name."""

from pathlib import Path

import yaml

from vh_drake.errors import UnknownName
from vh_drake.geometry.model_files import models_folder

DEFAULT_HAND = "armar6_right"


def shipped_hands() -> dict[str, Path]:
    """Descriptions by the name that stands in them."""
    files = sorted(models_folder().glob("*_hand/*.yaml"))
    return {yaml.safe_load(file.read_text())["name"]: file for file in files}


def hand_file(spec: str | Path = "") -> Path:
    """The description of a hand.

    Args:
        spec: the name of a shipped hand or the path of a description; empty is the right hand of
            ARMAR-6.

    Raises:
        UnknownName: neither a shipped hand nor the path of a YAML file.
    """
    hands = shipped_hands()
    name = str(spec) or DEFAULT_HAND
    if name in hands:
        return hands[name]
    path = Path(spec)
    if path.suffix.lower() in (".yaml", ".yml") or path.is_file():
        return path
    raise UnknownName("hand", name, list(hands))
