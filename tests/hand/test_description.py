import random
import time
from pathlib import Path

import pytest
import yaml
from fuzzing import FILES, limits

from vh_drake.errors import BadInput
from vh_drake.hand.description import load_hand

SHIPPED = Path(__file__).parents[2] / "models" / "armar6_hand" / "armar6_hand.yaml"
LARGEST_SECONDS = 5.0


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "armar6_hand.sdf").write_text("<sdf version='1.9'/>")
    return tmp_path


def write(folder: Path, **changes: object) -> Path:
    """A copy of the shipped description with some of its values changed."""
    content = yaml.safe_load(SHIPPED.read_text()) | changes
    path = folder / "hand.yaml"
    path.write_text(yaml.safe_dump(content))
    return path


def damaged(text: bytes, random_: random.Random) -> bytes:
    """The text with one to five random cuts, copies, or changed, added or swapped bytes."""
    data = bytearray(text)
    for _ in range(random_.randint(1, 5)):
        start = random_.randrange(len(data) or 1)
        end = min(len(data), start + random_.choice([1, 2, 10, 200]))
        piece = data[start:end]
        kind = random_.randrange(6)
        if kind == 0:
            del data[start:end]
        elif kind == 1:
            data[start:start] = piece * random_.choice([1, 3, 50])
        elif kind == 2:
            data[start:end] = random_.randbytes(len(piece))
        elif kind == 3:
            data[start:start] = random_.choice([b"[", b"{", b": ", b"- ", b"*a", b"&a ", b"!!x "])
        elif kind == 4:
            data[start:end] = random_.choice([b".nan", b"1e999", b"null", b"-.inf", b"9" * 5000])
        else:
            del data[start:]
    return bytes(data)


def refusal(path: Path) -> list[str]:
    """The message with which a file is refused, if it is; any other error passes through."""
    try:
        load_hand(path)
    except BadInput as error:
        return [str(error)]
    return []


def test_the_shipped_hand_loads_with_an_absolute_model():
    hand = load_hand(SHIPPED)
    assert [finger.name for finger in hand.fingers] == [
        "index",
        "middle",
        "ring",
        "little",
        "thumb",
    ]
    assert Path(hand.model) == SHIPPED.with_name("armar6_hand.sdf").resolve()


@pytest.mark.parametrize("block", range(5))
def test_a_damaged_file_loads_or_raises_bad_input_in_bounded_time(folder, block):
    random_ = random.Random(block)
    original = SHIPPED.read_bytes()
    path = folder / "hand.yaml"
    messages = []
    for _ in range(FILES["hand"] // 5):
        path.write_bytes(damaged(original, random_))
        with limits(LARGEST_SECONDS, megabytes=500):
            messages += refusal(path)
    assert len(messages) > 10
    assert all(str(path) in message and len(message) < 2000 for message in messages)


@pytest.mark.parametrize(
    "model",
    [
        "../../etc/passwd",
        "../hand.sdf",
        "/etc/passwd",
        "a/../../../etc/passwd",
        "\0",
        "x" * 5000,
        "\ud800",
    ],
)
def test_a_model_outside_the_folder_is_refused(folder, model):
    with pytest.raises(BadInput):
        load_hand(write(folder, model=model))


def test_a_link_out_of_the_folder_is_refused(folder):
    (folder / "link.sdf").symlink_to("/etc/passwd")
    with pytest.raises(BadInput, match="outside"):
        load_hand(write(folder, model="link.sdf"))


@pytest.mark.parametrize(
    "text",
    [
        "",
        "null",
        "[]",
        "just words",
        "name: [a, b]",
        "fingers: 3",
        "unknown_key: 1",
        "!!python/object/apply:os.system ['true']",
        "[" * 5000,
        "a: " * 3000,
        "{a: &a [1], b: *a}",
        "\x00\x01\x02",
    ],
)
def test_malformed_text_is_refused(folder, text):
    path = folder / "hand.yaml"
    path.write_text(text)
    with pytest.raises(BadInput):
        load_hand(path)


def test_a_bomb_of_aliases_is_refused_at_once(folder):
    lines = ["a0: &a0 [x, x]"] + [
        f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]" for i in range(1, 30)
    ]
    path = folder / "hand.yaml"
    path.write_text("\n".join(lines))
    start_s = time.perf_counter()
    with pytest.raises(BadInput, match="aliases"):
        load_hand(path)
    assert time.perf_counter() - start_s < LARGEST_SECONDS


@pytest.mark.parametrize(
    ("size", "text"),
    [(2_000_000, b"a"), (900_000, b"- [1, 2]\n"), (900_000, b"[{"), (900_000, b"a: 'x' # y\n")],
)
def test_a_huge_file_is_refused_in_bounded_time(folder, size, text):
    path = folder / "hand.yaml"
    path.write_bytes(text * (size // len(text)))
    start_s = time.perf_counter()
    with pytest.raises(BadInput):
        load_hand(path)
    assert time.perf_counter() - start_s < LARGEST_SECONDS


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"fingers": []}, "no fingers"),
        ({"motors": []}, "not among the motors"),
        ({"tcps": {}}, "tcps.power"),
        ({"tcps": {"power": [0.0, float("nan"), 0.0]}}, "tcps.power"),
        ({"approach": [0.0, 1.0]}, "approach"),
        ({"closing": [0.0, 0.0, 0.0]}, "no length"),
        ({"palm": [float("inf"), 0.0, 0.0]}, "palm"),
        ({"model": "missing.sdf"}, "no model file"),
        ({"pressing": {"gathered": [0.4], "pressed": [0.4, 0.5]}}, "pressing.gathered"),
        ({"pressing": {"gathered": [0.4, 0.3], "pressed": [0.4, 1.5]}}, "pressing.pressed"),
    ],
)
def test_an_incomplete_hand_is_refused_by_name(folder, changes, message):
    with pytest.raises(BadInput, match=message):
        load_hand(write(folder, **changes))


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [("force_n", -1.0, "force_n is -1"), ("empty", 1.5, "empty is 1.5"), ("empty", -0.1, "empty")],
)
def test_a_motor_with_a_value_out_of_range_is_refused(folder, name, value, message):
    motors = yaml.safe_load(SHIPPED.read_text())["motors"]
    motors[0][name] = value
    with pytest.raises(BadInput, match=message):
        load_hand(write(folder, motors=motors))


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(BadInput, match=r"nowhere\.yaml"):
        load_hand(tmp_path / "nowhere.yaml")
