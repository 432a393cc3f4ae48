import dataclasses as dc

import numpy as np
import pytest
from learning_scenes import can_scene

from vh_drake.errors import BadInput
from vh_drake.learning.dataset import faults
from vh_drake.learning.shards import LabelledScene, read_shard, shard_bytes
from vh_drake.types import Candidates, ContactSet, ObjectView


def empty_scene():
    none, counts = np.zeros(0), np.zeros(0, np.int64)
    return LabelledScene(
        scene=1,
        object="fork",
        seed=0,
        view=ObjectView(),
        contacts=ContactSet(),
        candidates=Candidates(),
        label_rate=none,
        label_error=none,
        label_samples=counts,
        estimate_rate=none,
        estimate_samples=counts,
        nominal=np.zeros(0, bool),
    )


def test_a_round_trip_gives_the_same_scene_and_the_same_bytes(tmp_path):
    data = shard_bytes([can_scene(), empty_scene()])
    path = tmp_path / "scenes-00000.parquet"
    path.write_bytes(data)
    scene, empty = read_shard(path)
    before = can_scene()
    np.testing.assert_array_equal(scene.view.p_WO, before.view.p_WO)
    np.testing.assert_array_equal(scene.view.n_WO, before.view.n_WO)
    np.testing.assert_array_equal(scene.view.table.normal, before.view.table.normal)
    np.testing.assert_array_equal(scene.contacts.p_WC, before.contacts.p_WC)
    np.testing.assert_array_equal(scene.candidates.X_WH, before.candidates.X_WH)
    np.testing.assert_array_equal(scene.nominal, before.nominal)
    np.testing.assert_allclose(scene.label_rate, before.label_rate, atol=1e-7)
    assert scene.candidates.motion == before.candidates.motion
    assert scene.candidates.planner == before.candidates.planner
    assert len(empty.candidates) == 0
    assert shard_bytes([scene, empty]) == data


def test_a_scene_has_nothing_impossible_in_it():
    assert faults(can_scene()) == []


def test_impossible_values_are_named():
    scene = can_scene()
    rate = scene.label_rate.copy()
    rate[0] = 1.5
    assert "rate" in faults(dc.replace(scene, label_rate=rate))[0]
    X_WH = scene.candidates.X_WH.copy()
    X_WH[0, 0, 0] += 0.1
    candidates = dc.replace(scene.candidates, X_WH=X_WH)
    assert "rotation" in faults(dc.replace(scene, candidates=candidates))[0]
    assert "unlike length" in faults(dc.replace(scene, label_rate=rate[1:]))[0]


def test_a_truncated_or_foreign_file_is_refused_with_the_remedy(tmp_path):
    path = tmp_path / "scenes-00000.parquet"
    data = shard_bytes([can_scene()])
    path.write_bytes(data[: len(data) // 2])
    with pytest.raises(BadInput, match="dataset generate"):
        read_shard(path)
    path.write_bytes(b"PAR1" + bytes(50) + b"PAR1")
    with pytest.raises(BadInput):
        read_shard(path)
    with pytest.raises(BadInput):
        read_shard(tmp_path / "none.parquet")


def test_a_candidate_takes_less_than_six_hundred_bytes(tmp_path):
    scenes = [can_scene()] * 8
    assert len(shard_bytes(scenes[:1])) / len(can_scene().candidates) < 5_000  # points, once
    more = len(shard_bytes(scenes)) - len(shard_bytes(scenes[:4]))
    assert more >= 0
