import numpy as np
import pytest
from browser import screenshot, share_of_hue
from pydrake.common.value import AbstractValue
from pydrake.geometry import SceneGraph
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import ConstantValueSource

from vh_drake.grasping.story import Story
from vh_drake.hand.description import load_hand
from vh_drake.hand.model import read_hand_model
from vh_drake.scenes.decision import OUTPUTS
from vh_drake.scenes.plant import default_hand
from vh_drake.scenes.recording import start_recording, write_recording
from vh_drake.scenes.showing import (
    P_W_SIGN,
    TARGET_W,
    add_publishers,
    add_robot_visualizer,
    make_meshcat,
    sign_pose,
)
from vh_drake.types import Candidates, ContactSet, GraspScores, ObjectView, Surface, TouchPlan

MIDDLE = np.array(TARGET_W)
RED, VIOLET, YELLOW = (0.84, 0.22, 0.33), (0.25, 0.0, 0.3), (0.64, 0.62, 0.25)  # as lit


def half_certain_sheet():
    """A wide sheet that faces the camera, certain on one half and guessed on the other."""
    x, z = np.meshgrid([-0.3, 0.0, 1e-6, 0.3], [-0.2, 0.2], indexing="ij")
    p = MIDDLE + np.column_stack([-x.ravel(), -x.ravel(), z.ravel()]) - np.array([0.2, -0.2, 0.0])
    faces = [
        [2 * i + a, 2 * i + b, 2 * i + c] for i in range(3) for a, b, c in [(0, 2, 1), (1, 2, 3)]
    ]
    variance = np.where(x.ravel() < 1e-9, 0.0, 1.0)
    return Surface(p, np.array(faces), np.zeros((8, 3)), variance)


def values():
    p = MIDDLE + np.outer(np.linspace(-0.1, 0.1, 40), [1.0, 1.0, 0.0]) + np.array([0.1, -0.1, 0.0])
    return {
        "view": ObjectView(),
        "surface": half_certain_sheet(),
        "contacts": ContactSet(p, np.tile([0.0, 0.0, 1.0], (40, 1))),
        "touch_plan": TouchPlan(),
        "candidates": Candidates(),
        "scores": GraspScores(),
        "story": Story(),
        "phase": "touch: feel",
    }


def beliefs():
    """Stands in for a decision part: its outputs never change."""
    builder = DiagramBuilder()
    for name, value in values().items():
        source = builder.AddNamedSystem(name, ConstantValueSource(AbstractValue.Make(value)))
        builder.ExportOutput(source.get_output_port(), name)
    return builder.Build()


@pytest.fixture(scope="module")
def hand():
    return read_hand_model(load_hand(default_hand()))


def test_decision_has_every_port_that_the_publishers_want():
    assert set(values()) <= {port for _, port in OUTPUTS}


def test_page_and_recording_show_estimate_contact_and_phase(hand, tmp_path):
    meshcat = make_meshcat()
    builder = DiagramBuilder()
    decision: Diagram = builder.AddSystem(beliefs())
    add_publishers(builder, decision, meshcat, hand)
    simulator = Simulator(builder.Build())
    start_recording(meshcat)
    simulator.AdvanceTo(0.2)
    assert meshcat.HasPath("/phase/0")
    page = write_recording(meshcat, tmp_path / "recording.html")
    for place, name in ((meshcat.web_url(), "live"), (page, "recording")):
        picture = screenshot(place, tmp_path / f"{name}.png")
        assert share_of_hue(picture, VIOLET) > 0.01
        assert share_of_hue(picture, YELLOW) > 0.01
        assert share_of_hue(picture, RED) > 0.0002


def test_sign_stands_upright_and_faces_the_camera():
    X_WSign = sign_pose()
    reads_from = -X_WSign.rotation().matrix()[:, 1]
    view = MIDDLE - np.array([1.4, -0.9, 1.45])
    assert reads_from @ view < 0
    assert X_WSign.rotation().matrix()[2, 2] > 0.9
    np.testing.assert_array_equal(X_WSign.translation(), P_W_SIGN)


def test_robot_is_drawn_in_its_illustration_role():
    meshcat = make_meshcat()
    builder = DiagramBuilder()
    scene_graph = builder.AddSystem(SceneGraph())
    add_robot_visualizer(builder, scene_graph.get_query_output_port(), meshcat)
    Simulator(builder.Build()).Initialize()
    assert meshcat.HasPath("/drake/scene")
