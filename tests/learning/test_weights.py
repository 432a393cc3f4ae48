import hashlib
import json

import numpy as np
import pytest
from fuzzing import FILES, damaged, limits

from vh_drake.errors import BadInput
from vh_drake.learning import weights
from vh_drake.learning.weights import card_path, load_weights, save_weights

CARD = {"task": "rate grasps", "epochs": 3, "loss": [0.5, 0.25]}
SNIPPETS = (
    b"[" * 3000,
    b"{",
    b'"',
    b"999999999999",
    b"-1",
    b"null",
    b"NaN",
    b"1e999",
    b"F32",
    b"\0",
)


def arrays(seed=0):
    rng = np.random.default_rng(seed)
    return {
        "layer.weight": rng.standard_normal((8, 3)).astype(np.float32),
        "layer.bias": rng.standard_normal(8),
        "steps": np.array(7),
    }


@pytest.fixture
def saved(tmp_path):
    path = tmp_path / "net.safetensors"
    save_weights(path, arrays(), CARD)
    return path


def vouch(path, **changes):
    """Make the card vouch for whatever the file holds now."""
    data = path.read_bytes()
    card = json.loads(card_path(path).read_text())
    card |= {"sha256": hashlib.sha256(data).hexdigest(), "bytes": len(data)} | changes
    card_path(path).write_text(json.dumps(card))


def refusal(path):
    with pytest.raises(BadInput) as error:
        load_weights(path)
    return str(error.value)


def test_what_was_saved_is_loaded_bit_by_bit(saved):
    loaded, card = load_weights(saved)
    assert card == CARD
    assert loaded.keys() == arrays().keys()
    for name, array in arrays().items():
        assert loaded[name].dtype == array.dtype
        np.testing.assert_array_equal(loaded[name], array)


def test_arrays_that_are_views_are_saved_in_their_order(tmp_path):
    turned = np.arange(12.0).reshape(3, 4).T
    save_weights(tmp_path / "a.safetensors", {"w": turned}, {})
    np.testing.assert_array_equal(load_weights(tmp_path / "a.safetensors")[0]["w"], turned)


def test_the_same_weights_give_the_same_bytes(saved, tmp_path):
    again = tmp_path / "again.safetensors"
    save_weights(again, dict(reversed(arrays().items())), CARD)
    assert again.read_bytes() == saved.read_bytes()
    assert card_path(again).read_bytes() == card_path(saved).read_bytes()


def test_a_missing_file_or_card_names_the_remedy(saved):
    card_path(saved).rename(saved.with_name("other.json"))
    assert "fetch both files again" in refusal(saved)
    saved.with_name("other.json").rename(card_path(saved))
    saved.unlink()
    assert "no file at" in refusal(saved)


def test_truncated_weights_are_refused(saved):
    saved.write_bytes(saved.read_bytes()[:-1])
    assert "bytes, its card says" in refusal(saved)


def test_a_changed_bit_is_found_by_the_hash(saved):
    data = bytearray(saved.read_bytes())
    data[-3] ^= 1
    saved.write_bytes(data)
    assert "SHA-256" in refusal(saved)


def test_shapes_other_than_the_cards_are_refused(saved):
    vouch(saved, shapes={"layer.weight": [3, 8], "layer.bias": [8], "steps": []})
    assert "'layer.weight' has the shape [8, 3], its card says [3, 8]" in refusal(saved)


@pytest.mark.parametrize("length", [2**20 + 1, 2**40, 2**64 - 1])
def test_a_header_that_announces_too_much_is_refused(saved, length):
    saved.write_bytes(length.to_bytes(8, "little") + saved.read_bytes()[8:])
    vouch(saved)
    assert "header" in refusal(saved)


def test_files_over_the_limit_are_refused_before_they_are_parsed(saved, monkeypatch):
    monkeypatch.setattr(weights, "MAX_BYTES", 100)
    monkeypatch.setattr(weights, "load", None)
    assert "more than the 100 bytes" in refusal(saved)
    with pytest.raises(BadInput, match="100 are allowed"):
        save_weights(saved, arrays(), CARD)


@pytest.mark.parametrize(
    "content",
    ["", "[]", "{}", "[" * 100_000, '{"format": 1}', '{"bytes": 1e999}', "\ufeff{}"],
)
def test_a_malformed_card_is_refused(saved, content):
    card_path(saved).write_text(content)
    assert str(card_path(saved)) in refusal(saved)


def test_another_format_is_refused(saved):
    vouch(saved, format="vh_drake weights 99")
    assert "99' is not" in refusal(saved)


def test_weights_that_are_not_finite_are_refused(tmp_path):
    with pytest.raises(BadInput, match="NaN"):
        save_weights(tmp_path / "a.safetensors", {"w": np.array([np.nan])}, {})
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["net.pt", "net.pkl", "net"])
def test_formats_that_can_run_code_are_neither_written_nor_read(tmp_path, name):
    with pytest.raises(BadInput, match="safetensors"):
        save_weights(tmp_path / name, arrays(), CARD)
    with pytest.raises(BadInput, match="safetensors"):
        load_weights(tmp_path / name)


@pytest.mark.parametrize("card", [{"a": {1, 2}}, {"a": float("nan")}])
def test_a_card_that_is_no_json_is_refused_and_nothing_is_written(tmp_path, card):
    with pytest.raises(BadInput, match="no JSON"):
        save_weights(tmp_path / "a.safetensors", arrays(), card)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("target", ["weights", "weights with a card that vouches", "card"])
def test_damaged_weights_load_or_are_refused_soon_and_in_little_memory(saved, target):
    rng = np.random.default_rng(len(target))
    file = card_path(saved) if target == "card" else saved
    sound, refused = file.read_bytes(), 0
    for _ in range(FILES["weights"] // 3):
        file.write_bytes(damaged(sound, rng, SNIPPETS))
        if target.endswith("vouches"):
            vouch(saved)
        with limits(seconds=2.0, megabytes=500):
            refused += was_refused(saved)
    assert refused > FILES["weights"] // 6


def was_refused(path):
    message = None
    try:
        loaded, _ = load_weights(path)
    except BadInput as error:
        message = str(error)
    if message is None:
        assert all(np.isfinite(array).all() for array in loaded.values())
        return False
    assert path.stem in message
    assert len(message) < 2000
    return True
