import io
import struct
import time

import numpy as np
import pytest
import trimesh
from fuzzing import FILES, limits

from vh_drake.errors import BadInput
from vh_drake.sensing.clouds import load_cloud

POINTS = np.random.default_rng(0).uniform(-1.0, 1.0, (50, 3)).astype(np.float32).astype(float)


def ply(points=POINTS, form="binary_little_endian", count=None, faces=0):
    header = f"ply\nformat {form} 1.0\ncomment made here\nelement vertex {count or len(points)}\n"
    header += "property uchar red\nproperty float x\nproperty float y\nproperty float z\n"
    header += f"element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    if form == "ascii":
        body = "".join(f"7 {x!r} {y!r} {z!r}\n" for x, y, z in points.tolist()).encode()
        body += b"3 0 1 2\n" * faces
    else:
        order = "<" if "little" in form else ">"
        body = b"".join(struct.pack(order + "Bfff", 7, *p) for p in points)
        body += struct.pack(order + "Biii", 3, 0, 1, 2) * faces
    return header.encode() + body


def pcd(points=POINTS, data="binary", count=None):
    number = count or len(points)
    header = "# .PCD v0.7\nVERSION 0.7\nFIELDS _ x y z\nSIZE 1 4 4 4\nTYPE U F F F\nCOUNT 4 1 1 1\n"
    header += (
        f"WIDTH {number}\nHEIGHT 1\nVIEWPOINT 0.5 0 1.5 1 0 0 0\nPOINTS {number}\nDATA {data}\n"
    )
    if data == "ascii":
        body = "".join(f"0 0 0 0 {x!r} {y!r} {z!r}\n" for x, y, z in points.tolist()).encode()
    else:
        body = b"".join(struct.pack("<4Bfff", 0, 0, 0, 0, *p) for p in points)
    return header.encode() + body


def npz(**arrays):
    stream = io.BytesIO()
    np.savez_compressed(stream, **arrays)
    return stream.getvalue()


WHOLE = {
    "little.ply": ply(),
    "big.ply": ply(form="binary_big_endian"),
    "text.ply": ply(form="ascii", faces=2),
    "mesh.ply": ply(faces=3),
    "binary.pcd": pcd(),
    "text.pcd": pcd(data="ascii"),
    "points.npz": npz(points=POINTS, camera=np.array([0.5, 0.0, 1.5])),
    "image.npz": npz(xyz=POINTS.reshape(5, 10, 3)),
    "mesh.obj": "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in POINTS.tolist()).encode()
    + b"f 1 2 3\n",
}


def load(folder, name, data, **options):
    path = folder / name
    path.write_bytes(data)
    return load_cloud(path, **options)


@pytest.mark.parametrize("name", WHOLE)
def test_every_format_gives_its_points(name, tmp_path):
    loaded = load(tmp_path, name, WHOLE[name])
    np.testing.assert_array_equal(loaded.cloud.p_WC, POINTS)
    assert loaded.dropped == 0
    camera = [0.5, 0.0, 1.5] if name in ("binary.pcd", "text.pcd", "points.npz") else [0, 0, 0]
    np.testing.assert_array_equal(loaded.cloud.p_WCamera, camera)


@pytest.mark.parametrize("encoding", ["ascii", "binary_little_endian"])
def test_what_trimesh_writes_is_read(encoding, tmp_path):
    ball = trimesh.creation.icosphere(1, 0.1)
    data = trimesh.exchange.ply.export_ply(ball, encoding=encoding.split("_")[0])
    points = load(tmp_path, "ball.ply", data).cloud.p_WC
    np.testing.assert_allclose(points, ball.vertices, atol=1e-7)


def test_the_caller_s_optical_centre_comes_first(tmp_path):
    loaded = load(tmp_path, "a.pcd", pcd(), p_WCamera=np.array([1.0, 2.0, 3.0]))
    np.testing.assert_array_equal(loaded.cloud.p_WCamera, [1.0, 2.0, 3.0])


def test_nan_points_are_dropped_and_counted(tmp_path):
    points = POINTS.copy()
    points[::5, 1] = np.nan
    loaded = load(tmp_path, "a.ply", ply(points))
    assert loaded.dropped == 10
    assert len(loaded.cloud.p_WC) == 40


NAN = np.full_like(POINTS, np.nan)
BROKEN = {
    "nan.ply": (ply(NAN), "50 of 50 points are NaN"),
    "mm.ply": (ply(POINTS * 2000.0), "millimetres"),
    "empty.ply": (b"", "is empty"),
    "none.ply": (ply(count="0"), "0 points"),
    "short.ply": (ply()[:-5], "truncated"),
    "greedy.ply": (ply(count=3_000_000), "holds 650 of 39000000 bytes"),
    "huge.ply": (ply(count=10**11), "can be read"),
    "stl.ply": (b"solid x", "no PLY file"),
    "headless.ply": (ply()[:80], "no end"),
    "lines.ply": (ply(form="ascii", count=90), "truncated"),
    "word.ply": (ply(form="ascii").replace(b"7 0.", b"7 a."), "no number"),
    "short.pcd": (pcd()[:-1], "truncated"),
    "packed.pcd": (pcd(data="binary_compressed"), "ascii or binary"),
    "nothing.pcd": (b"\x00" * 100, "no DATA line"),
    "nothing.npz": (b"\x00" * 100, "damaged NPZ"),
    "other.npz": (npz(depth=POINTS), "no array named"),
    "flat.npz": (npz(points=POINTS[:, 0]), "shape"),
    "text.npz": (npz(points=np.array(["a"])), "announces"),
    "few.obj": (b"f 1 2 3\n", "0 vertices"),
    "cloud.stl": (b"solid", "a cloud is one of"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_unusable_files_are_refused_by_name_and_reason(name, tmp_path):
    data, message = BROKEN[name]
    with pytest.raises(BadInput, match=message) as error:
        load(tmp_path, name, data)
    assert name in str(error.value)


def test_missing_files_folders_and_large_files_are_refused(tmp_path):
    with pytest.raises(BadInput, match="no file at"):
        load_cloud(tmp_path / "missing.ply")
    (tmp_path / "folder.ply").mkdir()
    with pytest.raises(BadInput, match="no file at"):
        load_cloud(tmp_path / "folder.ply")
    with pytest.raises(BadInput, match="more than the 100 allowed"):
        load(tmp_path, "a.ply", ply(), max_bytes=100)
    with pytest.raises(BadInput, match="1 to 10 can be read"):
        load(tmp_path, "a.ply", ply(), max_points=10)


def test_pickled_arrays_are_never_opened(tmp_path):
    stream = io.BytesIO()
    np.savez(stream, points=np.array([{"a": 1}], dtype=object))
    with pytest.raises(BadInput, match="announces"):
        load(tmp_path, "evil.npz", stream.getvalue())


def test_an_archive_that_unpacks_without_bound_is_refused(tmp_path):
    with pytest.raises(BadInput, match="too large"):
        load(tmp_path, "bomb.npz", npz(points=np.zeros((200_000, 3))), max_points=1000)


def damaged(data: bytes, rng: np.random.Generator) -> bytes:
    """Flips, cuts, repeats or inserts bytes, mostly in the header."""
    raw = bytearray(data)
    for _ in range(int(rng.integers(1, 6))):
        at = int(rng.integers(0, len(raw) if rng.random() < 0.3 else min(len(raw), 400)))
        match int(rng.integers(4)):
            case 0:
                raw[at] = int(rng.integers(256))
            case 1:
                raw = raw[: max(1, at)] if rng.random() < 0.5 else raw[:at] + raw[at + 7 :]
            case 2:
                raw[at:at] = raw[at : at + int(rng.integers(1, 50))]
            case 3:
                raw[at:at] = bytes(rng.choice(list(b"0123456789-. \nxyz"), 6).astype(np.uint8))
        raw = raw or bytearray(b" ")
    return bytes(raw)


def outcome(folder, name, data):
    """None where the file was read, else the message."""
    try:
        cloud = load(folder, name, data).cloud
    except BadInput as error:
        return str(error)
    assert np.isfinite(cloud.p_WC).all()
    assert cloud.p_WC.shape[1] == 3
    return None


def test_damaged_files_give_finite_points_or_a_clear_error(tmp_path):
    rng = np.random.default_rng(1)
    refused, slowest = 0, 0.0
    for i in range(FILES["cloud"]):
        name = list(WHOLE)[i % len(WHOLE)]
        data = damaged(WHOLE[name], rng)
        start = time.perf_counter()
        with limits(seconds=5.0, megabytes=1000):
            message = outcome(tmp_path, name, data)
        slowest = max(slowest, time.perf_counter() - start)
        assert message is None or name in message
        refused += message is not None
    assert refused > 100
    assert slowest < 1.0
