import dataclasses as dc
import math
from operator import attrgetter
from pathlib import Path

import pytest
import yaml

from vh_drake.errors import BadInput, UnknownName
from vh_drake.scenes.scenario import (
    PAIR_RANGES,
    RANGES,
    Scenario,
    check_scenario,
    load_scenario,
)

SHIPPED = Path(__file__).parents[2] / "models" / "scenarios"


def numbers(value, prefix=""):
    """Dotted names of all numbers within a dataclass."""
    names = []
    for field in dc.fields(value):
        inner = getattr(value, field.name)
        if dc.is_dataclass(inner):
            names += numbers(inner, f"{prefix}{field.name}.")
        elif inner is None or type(inner) in (int, float):
            names.append(prefix + field.name)
    return names


def changed(name, value):
    """The default scenario with one value set."""
    scenario = Scenario()
    *path, last = name.split(".")
    setattr(attrgetter(".".join(path))(scenario) if path else scenario, last, value)
    return scenario


def written(tmp_path, content):
    path = tmp_path / "scenario.yaml"
    path.write_text(content if isinstance(content, str) else yaml.safe_dump(content))
    return path


def test_the_shipped_scenarios_load():
    scenarios = {path.stem: load_scenario(path) for path in SHIPPED.glob("*.yaml")}
    assert scenarios["default"] == Scenario()


def test_every_number_has_a_range_that_holds_its_default():
    assert set(RANGES) == set(numbers(Scenario()))
    check_scenario(Scenario())


@pytest.mark.parametrize("name", RANGES)
def test_numbers_beside_their_range_are_refused_by_name(name):
    low, high = RANGES[name]
    for value in (low, high):
        if name not in ("camera.min_depth_m", "camera.max_depth_m"):
            check_scenario(changed(name, value))
    for value in (math.nextafter(low, -math.inf), math.nextafter(high, math.inf), math.nan):
        with pytest.raises(BadInput, match=f"{name} is"):
            check_scenario(changed(name, value))


@pytest.mark.parametrize("name", PAIR_RANGES)
@pytest.mark.parametrize("value", [[], [0.5], [0.5] * 3, [0.5, math.nan], [math.inf, 0.5]])
def test_pairs_need_two_finite_values(name, value):
    with pytest.raises(BadInput, match=name):
        check_scenario(changed(name, value))


@pytest.mark.parametrize(
    ("name", "value"),
    [("object", ""), ("object", "a\0b"), ("hand", "x" * 5000), ("objects", "line\nline")],
)
def test_texts_that_cannot_be_paths_are_refused(name, value):
    with pytest.raises(BadInput, match=name):
        check_scenario(changed(name, value))


def test_unknown_choices_list_the_known_ones():
    with pytest.raises(UnknownName, match="hydroelastic, point"):
        check_scenario(Scenario(contact="magnetic"))
    with pytest.raises(UnknownName, match="conventional"):
        check_scenario(Scenario(scorer="dice"))


def test_a_camera_that_sees_no_depth_is_refused():
    with pytest.raises(BadInput, match=r"camera\.min_depth_m is 3;"):
        check_scenario(changed("camera.min_depth_m", 3.0))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ({"mass_kg": -0.2}, "mass_kg is -0.2; choose a value from 0.001 to 100"),
        ({"sede": 1}, "sede"),
        ({"seed": "many"}, "not a valid Scenario file"),
        ({"camera": {"noise": {"axial_m": float("nan")}}}, r"camera\.noise\.axial_m is nan"),
        ("seed: [1", "not a valid Scenario file"),
        ("a: &a [1]\nb: *a", "anchors"),
        ("[" * 100, "levels"),
    ],
)
def test_a_broken_file_is_refused_by_its_path_and_reason(tmp_path, content, message):
    path = written(tmp_path, content)
    with pytest.raises(BadInput, match=message) as error:
        load_scenario(path)
    assert str(path) in str(error.value)


def test_a_missing_file_is_refused(tmp_path):
    with pytest.raises(BadInput, match="no Scenario file"):
        load_scenario(tmp_path / "nowhere.yaml")
