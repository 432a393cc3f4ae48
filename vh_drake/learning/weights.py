"""Weights of a network on disk: safetensors, and beside it a card that vouches for them.

Nothing in either file can run: the weights are raw numbers behind a JSON header, the card is
JSON. Sizes are held against limits and against the card before anything is parsed.
"""

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError
from safetensors.numpy import load, save

from vh_drake.atomic_files import write_bytes
from vh_drake.errors import BadInput

SUFFIX = ".safetensors"
FORMAT = "vh_drake weights 1"
MAX_BYTES = 256 * 2**20
MAX_HEADER_BYTES = 2**20
MAX_CARD_BYTES = 2**20
_KINDS = "fiub"  # of NumPy data types: floats, integers, booleans
_REMEDY = "fetch both files again, or train anew"

Weights = Mapping[str, NDArray[Any]]


def save_weights(path: str | Path, arrays: Weights, card: Mapping[str, Any]) -> None:
    """Writes weights and their card, each atomically.

    Args:
        path: ends in .safetensors; the card has the same name and ends in .json.
        arrays: numbers by name, in any shape.
        card: what people should know of them; plain JSON values.

    Raises:
        BadInput: a wrong suffix, no arrays, values that are not finite numbers, too many
            bytes, or a card that is no JSON.
        VhDrakeError: the files can't be written.
    """
    path = _checked_path(path)
    arrays = {name: np.ascontiguousarray(array) for name, array in arrays.items()}
    _check_numbers(arrays, str(path))
    data = save(arrays)
    if len(data) > MAX_BYTES:
        raise BadInput(f"{path}: the weights have {len(data)} bytes; {MAX_BYTES} are allowed")
    text = _card_text(arrays, data, card)
    write_bytes(path, data)  # A kill before the card leaves a pair that loading refuses.
    write_bytes(card_path(path), text.encode())


def load_weights(path: str | Path) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
    """Reads weights that match their card.

    Returns:
        The arrays by name, and the card that was given to `save_weights`.

    Raises:
        BadInput: a file is missing, too large, truncated, tampered with or malformed, or the
            shapes are not those of the card; the message names the remedy.
    """
    path = _checked_path(path)
    card = _read_card(card_path(path))
    data = _read(path, MAX_BYTES)
    try:
        _check_bytes(data, card)
        arrays = _parse(data)
        _check_shapes(arrays, card)
        _check_numbers(arrays, "the file")
    except BadInput as error:
        raise BadInput(f"{path}: {error}; {_REMEDY}") from error
    return arrays, card["metadata"]


def card_path(path: str | Path) -> Path:
    """Where the card of a weights file lies."""
    return Path(path).with_suffix(".json")


def _checked_path(path: str | Path) -> Path:
    path = Path(path)
    if path.suffix != SUFFIX:
        raise BadInput(f"{path}: weights are kept in {SUFFIX} files alone, which can't run code")
    return path


def _card_text(arrays: Weights, data: bytes, card: Mapping[str, Any]) -> str:
    content = {
        "format": FORMAT,
        "sha256": hashlib.sha256(data).hexdigest(),
        "bytes": len(data),
        "shapes": {name: list(array.shape) for name, array in sorted(arrays.items())},
        "metadata": dict(card),
    }
    try:
        return json.dumps(content, indent=2, allow_nan=False) + "\n"
    except (TypeError, ValueError, RecursionError) as error:
        raise BadInput(f"the card holds something that is no JSON: {error}") from error


def _read(path: Path, max_bytes: int) -> bytes:
    try:
        if not path.is_file():
            raise BadInput(f"no file at {path}; weights and card belong together, {_REMEDY}")
        with path.open("rb") as file:
            data = file.read(max_bytes + 1)
    except (OSError, ValueError) as error:  # ValueError: a null byte in the name.
        raise BadInput(f"{path} cannot be read: {error}") from error
    if len(data) > max_bytes:
        raise BadInput(f"{path} has more than the {max_bytes} bytes allowed; {_REMEDY}")
    return data


def _read_card(path: Path) -> dict[str, Any]:
    """The card, its fields of the right types."""
    try:
        card = json.loads(_read(path, MAX_CARD_BYTES))
    except (ValueError, RecursionError) as error:
        raise BadInput(f"{path} is no JSON: {error}; {_REMEDY}") from error
    kinds = {"format": str, "sha256": str, "bytes": int, "shapes": dict, "metadata": dict}
    for name, kind in kinds.items():
        if not isinstance(card, dict) or not isinstance(card.get(name), kind):
            raise BadInput(f"{path}: the card has no valid {name!r}; {_REMEDY}")
    if card["format"] != FORMAT:
        raise BadInput(f"{path}: format {card['format'][:40]!r} is not {FORMAT!r}; {_REMEDY}")
    return card


def _check_bytes(data: bytes, card: Mapping[str, Any]) -> None:
    """Size, hash and the header's announced length."""
    if len(data) != card["bytes"]:
        raise BadInput(f"it has {len(data)} bytes, its card says {card['bytes']}")
    if hashlib.sha256(data).hexdigest() != card["sha256"]:
        raise BadInput("its SHA-256 is not that of its card; it was damaged or replaced")
    header = int.from_bytes(data[:8], "little")
    if len(data) < 8 or header > min(MAX_HEADER_BYTES, len(data) - 8):
        raise BadInput(
            f"its header of {header} bytes is longer than the file or than {MAX_HEADER_BYTES}"
        )


def _parse(data: bytes) -> dict[str, NDArray[Any]]:
    try:
        return dict(load(data))
    except (SafetensorError, ValueError, TypeError, KeyError, OverflowError) as error:
        raise BadInput(f"it is no safetensors file: {error}") from error


def _check_shapes(arrays: Weights, card: Mapping[str, Any]) -> None:
    shapes = {name: list(array.shape) for name, array in arrays.items()}
    for name in sorted({*shapes, *card["shapes"]}):
        if shapes.get(name) != card["shapes"].get(name):
            raise BadInput(
                f"{name[:80]!r} has the shape {shapes.get(name)}, "
                f"its card says {card['shapes'].get(name)}"
            )


def _check_numbers(arrays: Weights, name: str) -> None:
    if not arrays:
        raise BadInput(f"{name} holds no weights")
    for key, array in arrays.items():
        if array.dtype.kind not in _KINDS or not np.isfinite(array).all():
            raise BadInput(f"{name}: {key[:80]!r} holds NaN, infinite values or no numbers")
