import dataclasses as dc

import numpy as np
import pytest
from learning_scenes import FAST, can_scene
from scenery import right_hand

from vh_drake.errors import BadInput
from vh_drake.learning.generating import seen_scene, true_object
from vh_drake.learning.labels import LabelSettings
from vh_drake.learning.scene import TrueObject
from vh_drake.learning.searching import UNLIMITED, best_grasp
from vh_drake.learning.training_objects import object_mesh
from vh_drake.objects.lathe import box, cylinder
from vh_drake.types import Plane

TABLE = Plane(np.array([0.0, 0.0, 1.0]), 0.0)
FEW = dc.replace(UNLIMITED, candidates=150, rounds=6, draws=200)
LABEL = LabelSettings(min_samples=100, max_samples=100)


def best(mesh):
    return best_grasp(TrueObject(mesh, TABLE, np.eye(4)), right_hand(), LABEL, settings=FEW)


def test_a_can_is_found_graspable():
    rate, tried = best(cylinder(0.03, 0.12))
    assert rate > 0.9
    assert tried > 200


def test_a_flat_box_wider_than_the_hand_is_not():
    rate, tried = best(box((0.2, 0.25, 0.06)))
    assert tried > 100
    assert rate < 0.8


def test_the_object_of_a_scene_is_found_again():
    mesh, scene = object_mesh("can", None), can_scene()
    truth = true_object(mesh, scene, FAST)
    rng = np.random.default_rng([scene.seed, scene.scene, 0])
    drawn = seen_scene(mesh, FAST, rng, touches=None)
    np.testing.assert_array_equal(truth.mesh.vertices, drawn.truth.mesh.vertices)


def test_another_mesh_is_not_the_object_of_a_scene():
    with pytest.raises(BadInput, match="another object"):
        true_object(object_mesh("shampoo", None), can_scene(), FAST)
