"""Reads YAML of a user into dataclasses, within limits of size and time."""

from pathlib import Path
from typing import TypeVar

import yaml
from pydrake.common.yaml import yaml_load_typed

from vh_drake.errors import BadInput

LARGEST_BYTES = 1_000_000
LARGEST_TOKENS = 20_000  # The ARMAR-6 hand has 460; the parser is pure Python.
LARGEST_DEPTH = 32  # The parser's time grows with the square of the depth.

_OPENING = (
    yaml.BlockMappingStartToken,
    yaml.BlockSequenceStartToken,
    yaml.FlowMappingStartToken,
    yaml.FlowSequenceStartToken,
)
_CLOSING = (yaml.BlockEndToken, yaml.FlowMappingEndToken, yaml.FlowSequenceEndToken)

T = TypeVar("T")


def load_typed(schema: type[T], path: str | Path) -> T:
    """Reads a YAML file into a dataclass.

    Anchors and aliases are refused: a few lines of them can expand without bound.

    Args:
        schema: A dataclass; unknown keys raise.
        path: The file.

    Returns:
        The dataclass; its values have the declared types and are otherwise unchecked.

    Raises:
        BadInput: the file is missing, too large or malformed.
    """
    path = Path(path)
    text = _read(path, schema)
    try:
        _check_tokens(text, path)
        return _parse(schema, text)
    except BadInput:
        raise
    except Exception as error:  # The parser raises many types; all mean a malformed file.
        raise BadInput(f"{path} is not a valid {schema.__name__} file: {_short(error)}") from error


def _read(path: Path, schema: type) -> str:
    if not path.is_file():
        raise BadInput(f"no {schema.__name__} file at {path}")
    try:
        with path.open("rb") as file:
            data = file.read(LARGEST_BYTES + 1)
        if len(data) > LARGEST_BYTES:
            raise BadInput(f"{path} is larger than {LARGEST_BYTES} bytes; YAML here is short")
        return data.decode("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise BadInput(f"cannot read {path} as UTF-8 text: {error}") from error


def _check_tokens(text: str, path: Path) -> None:
    depth = 0
    for count, token in enumerate(yaml.scan(text, Loader=yaml.SafeLoader)):
        depth += isinstance(token, _OPENING) - isinstance(token, _CLOSING)
        if isinstance(token, yaml.AnchorToken | yaml.AliasToken):
            raise BadInput(f"{path}: anchors and aliases are not allowed; write the values out")
        if count >= LARGEST_TOKENS or depth > LARGEST_DEPTH:
            raise BadInput(
                f"{path} has more than {LARGEST_TOKENS} YAML tokens or {LARGEST_DEPTH} levels"
            )


def _parse(schema: type[T], text: str) -> T:
    loaded: T = yaml_load_typed(schema=schema, data=text)
    return loaded


def _short(error: Exception, limit: int = 300) -> str:
    text = " ".join(str(error).split()) or type(error).__name__
    return text if len(text) <= limit else text[:limit] + " ..."
