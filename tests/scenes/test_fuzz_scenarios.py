import math
from pathlib import Path

import numpy as np
from fuzzing import FILES, damaged, limits

from vh_drake.errors import BadInput
from vh_drake.scenes.scenario import RANGES, check_scenario, load_scenario

SHIPPED = Path(__file__).parents[2] / "models" / "scenarios" / "default.yaml"
SNIPPETS = (
    *(b"[", b"{", b": ", b"- ", b"*a", b"&a ", b"!!python/object:os.system ", b"? ", b"\t", b"\0"),
    *(b".nan", b"-.inf", b"1e999", b"null", b"9" * 5000, b"-1", b"true", b"<<: ", b"2026-01-01"),
)


def test_damaged_scenarios_load_within_their_ranges_or_are_refused_by_name(tmp_path):
    rng = np.random.default_rng(0)
    sound, path = SHIPPED.read_bytes(), tmp_path / "damaged.yaml"
    messages = []
    for _ in range(FILES["scenario"]):
        path.write_bytes(damaged(sound, rng, SNIPPETS))
        with limits(seconds=5.0, megabytes=500):
            messages += refusal(path)
    assert FILES["scenario"] / 3 < len(messages) < FILES["scenario"]
    assert all(str(path) in message and len(message) < 2000 for message in messages)


def refusal(path):
    try:
        scenario = load_scenario(path)
    except BadInput as error:
        return [str(error)]
    check_scenario(scenario)
    assert math.isfinite(scenario.time_step_s)
    return []


def test_every_number_set_to_nan_or_infinity_is_refused(tmp_path):
    path = tmp_path / "damaged.yaml"
    for name in RANGES:
        *outer, last = name.split(".")
        for value in (".nan", ".inf", "-.inf", "1e999", "[]", "{}", "seven"):
            lines = [f"{'  ' * i}{key}:\n" for i, key in enumerate(outer)]
            path.write_text("".join(lines) + f"{'  ' * len(outer)}{last}: {value}\n")
            assert refusal(path), (name, value)
