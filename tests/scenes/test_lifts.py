import dataclasses as dc

import numpy as np
import pytest
from learning_scenes import FAST, can_scene

from vh_drake.errors import BadInput
from vh_drake.learning.dataset import DatasetSpec, generate
from vh_drake.learning.lift_records import GRASPS, read_lifts
from vh_drake.learning.training_objects import object_mesh
from vh_drake.scenes.lifts import (
    drawn_grasps,
    drawn_mass,
    lift_facts,
    lift_grasps,
    lift_scene,
)


def test_masses_are_those_of_household_things():
    rng = np.random.default_rng(0)
    masses = np.array([drawn_mass(2e-4, rng) for _ in range(500)])  # of a soap's size
    assert masses.min() == pytest.approx(0.016, rel=0.1)
    assert masses.max() == pytest.approx(1.0, rel=0.1)
    assert drawn_mass(1e-7, rng) == 0.01
    assert drawn_mass(1.0, rng) == 1.2


def test_grasps_that_close_on_the_estimate_come_more_often():
    scene, rng = can_scene(), np.random.default_rng(0)
    half = np.arange(len(scene.candidates)) % 2
    scene = dc.replace(scene, estimate_rate=half.astype(float))
    drawn = [drawn_grasps(scene, 6, rng) for _ in range(200)]
    assert all(len(set(own)) == 6 and (np.diff(own) > 0).all() for own in drawn)
    assert 0.65 < np.mean([half[own].mean() for own in drawn]) < 0.85
    assert len(drawn_grasps(scene, 1000, rng)) == len(scene.candidates)


def test_grasps_of_a_scene_lift_its_object_or_do_not_always_alike():
    scene, mesh = can_scene(), object_mesh("can", None)
    first, again = (lift_scene(scene, mesh, 4) for _ in range(2))
    assert first == again
    assert first.scene == scene.scene
    assert len(first.grasps) == len(first.lifted) == 4
    assert any(first.lifted)


def test_another_mesh_than_the_scene_shows_is_refused():
    with pytest.raises(BadInput, match="shows another object"):
        lift_scene(can_scene(), object_mesh("mug", None), 1)


@pytest.mark.slow
def test_lifts_of_a_data_set_are_kept_beside_it_and_not_done_twice(tmp_path):
    spec = DatasetSpec(2, ("can",), scenes_per_shard=2, settings=dc.replace(FAST, candidates=2))
    generate(tmp_path, spec, workers=1)
    one = lift_grasps(tmp_path, None, 1, workers=1)
    both = lift_grasps(tmp_path, None, 2, workers=1)
    assert both[:1] == one
    assert read_lifts(tmp_path) == {row.scene: row for row in both}
    facts = lift_facts(both)
    assert facts["scenes"] == 2
    assert facts["lifts"] == sum(len(row.grasps) for row in both) <= 2 * GRASPS
    assert lift_facts([])["lifted_share"] is None


def test_a_data_set_without_lifts_has_none(tmp_path):
    assert read_lifts(tmp_path) == {}
    with pytest.raises(BadInput, match="no data set"):
        lift_grasps(tmp_path, None, 1, workers=1)
