"""Damaged mesh files: each is refused with one clear error or loaded, soon and in little memory."""

import numpy as np
import pytest
import trimesh
from fuzzing import FILES, limits

from vh_drake.errors import BadInput
from vh_drake.objects.loading import load_object

FORMATS = ("obj", "ply", "ply_ascii", "stl", "stl_ascii", "glb")
FILES_PER_FORMAT = FILES["mesh"] // len(FORMATS)
TOKENS = (b"nan", b"inf", b"-1", b"1e300", b"999999999", b"4294967295", b"x", b"", b"0")


def sound_bytes(kind):
    mesh = trimesh.creation.icosphere(1, 0.04)
    if kind == "ply_ascii":
        return mesh.export(file_type="ply", encoding="ascii")
    data = mesh.export(file_type=kind)
    return data.encode() if isinstance(data, str) else data


def truncated(data, rng):
    return data[: rng.integers(0, len(data))]


def flipped(data, rng):
    damaged = np.frombuffer(data, np.uint8).copy()
    where = rng.integers(0, len(damaged), rng.integers(1, 12))
    damaged[where] ^= (1 << rng.integers(0, 8, len(where))).astype(np.uint8)
    return damaged.tobytes()


def head_flipped(data, rng):
    return flipped(data[:120], rng) + data[120:]


def overwritten(data, rng):
    start = rng.integers(0, len(data))
    return data[:start] + rng.bytes(rng.integers(1, 64)) + data[start + 40 :]


def numbers_replaced(data, rng):
    words = data.split(b" ")
    for _ in range(rng.integers(1, 5)):
        words[rng.integers(len(words))] = TOKENS[rng.integers(len(TOKENS))]
    return b" ".join(words)


def doubled(data, rng):
    cut = rng.integers(0, len(data))
    return data[:cut] + data


def noise(data, rng):
    return rng.bytes(rng.integers(1, 3000))


DAMAGES = (truncated, flipped, head_flipped, overwritten, numbers_replaced, doubled, noise)


@pytest.mark.parametrize("kind", FORMATS)
def test_damaged_files_are_refused_or_loaded(tmp_path, kind, capfd):
    rng = np.random.default_rng(FORMATS.index(kind))
    sound, path = sound_bytes(kind), tmp_path / f"damaged.{kind.split('_')[0]}"
    load_object(_written(path, sound))
    outcomes = {"loaded": 0, "refused": 0}
    for i in range(FILES_PER_FORMAT):
        _written(path, DAMAGES[i % len(DAMAGES)](sound, rng))
        with limits(seconds=20.0, megabytes=1500):
            outcomes[_outcome(path)] += 1
    assert outcomes["refused"] > FILES_PER_FORMAT / 4
    assert capfd.readouterr().err == ""


def _written(path, data):
    path.write_bytes(data)
    return path


def _outcome(path):
    try:
        model = load_object(path)
    except BadInput as error:
        return "refused" if path.name in str(error) else f"refused without a name: {error}"
    assert model.mesh.is_watertight
    return "loaded"
