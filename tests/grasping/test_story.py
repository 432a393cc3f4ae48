import copy

import numpy as np

from vh_drake.grasping.story import GraspRecord, Story, TouchRecord
from vh_drake.types import TouchPlan


def test_a_touch_that_found_nothing_has_no_place():
    record = TouchRecord(TouchPlan(), False, 1.0)
    assert np.isnan(record.p_WC).all()
    assert np.isnan(record.n_WC).all()


def test_copies_of_a_story_cost_nothing():
    grasp = GraspRecord(np.eye(4), "side", "surface", 0.5, 0, {"surface": 3})
    story = Story(touches=(TouchRecord(TouchPlan(), False, 1.0),), grasps=(grasp,))
    assert copy.deepcopy(story) is story
