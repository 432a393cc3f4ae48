"""How large the recording of a trial gets, by its parts: what stands there, and each second."""

import pytest
from pydrake.systems.analysis import Simulator

from vh_drake.experiments.grasp_trial import longest_s, make_trial
from vh_drake.scenes.recording import start_recording
from vh_drake.scenes.scenario import Scenario
from vh_drake.scenes.showing import make_meshcat


@pytest.fixture(scope="module")
def sizes():
    """Bytes of the page when the first touch is planned, and a second later."""
    meshcat = make_meshcat()
    trial = make_trial(Scenario(contact="point"), meshcat=meshcat)
    simulator = Simulator(trial.diagram, trial.context)
    start_recording(meshcat)
    sizes = []
    for time_s in (0.25, 1.25):
        simulator.AdvanceTo(time_s)
        meshcat.PublishRecording()
        sizes.append(len(meshcat.StaticHtml()))
    paths = ("estimate", "cloud", "contacts", "candidates")
    drawn = {path: sum(meshcat.HasPath(f"/{path}/{i}") for i in range(50)) for path in paths}
    return *sizes, drawn


def test_scene_and_first_pictures_leave_room_for_a_trial(sizes):
    assert sizes[0] < 9e6


def test_each_picture_is_drawn_once(sizes):
    assert sizes[2] == {"estimate": 1, "cloud": 1, "contacts": 0, "candidates": 0}


def test_the_longest_trial_stays_below_25_mb(sizes):
    start, later, _ = sizes
    per_second = later - start
    assert start + longest_s(Scenario()) * per_second < 25e6
