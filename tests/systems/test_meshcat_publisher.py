import dataclasses as dc

import numpy as np
import pytest
import trimesh
from pydrake.common.value import AbstractValue
from pydrake.geometry import Meshcat, MeshcatParams
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator

from vh_drake.grasping.story import GraspRecord, Story
from vh_drake.hand.description import load_hand
from vh_drake.hand.model import read_hand_model
from vh_drake.scenes.plant import default_hand
from vh_drake.systems.candidates_publisher import CandidatesPublisher
from vh_drake.systems.cloud_publisher import CloudPublisher
from vh_drake.systems.contacts_publisher import ContactsPublisher
from vh_drake.systems.grasp_contacts_publisher import GraspContactsPublisher
from vh_drake.systems.phase_publisher import PhasePublisher
from vh_drake.systems.surface_publisher import SurfacePublisher
from vh_drake.systems.touch_publisher import TouchPublisher
from vh_drake.types import (
    Candidates,
    ContactSet,
    GraspScores,
    ObjectView,
    Plane,
    Surface,
    TouchPlan,
)

UP = np.array([[0.0, 0.0, 1.0]])
BALL, BALL_M = np.array([-0.045, -0.005, 0.03]), 0.035  # lies where the fingers meet, in H


def tetrahedron():
    p = np.array([[0.0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    return Surface(p, faces, np.tile(UP, (4, 1)), np.array([0.0, 1e-6, 1e-5, 1e-4]))


def grasps(n):
    return {
        "candidates": Candidates(np.tile(np.eye(4), (n, 1, 1)), ("side",) * n, ("surface",) * n),
        "scores": GraspScores(np.linspace(0, 1, n), np.zeros(n)),
        "story": Story(),
    }


def touch():
    return TouchPlan(control_points=np.outer(np.arange(4.0), UP[0]))


def ball_in_the_hand():
    ball = trimesh.creation.icosphere(subdivisions=4, radius=BALL_M)
    p = np.array(ball.vertices) + BALL
    return Surface(p, np.array(ball.faces, np.int64), np.array(ball.vertex_normals), p[:, 0] * 0)


FULL = {
    "surface": {"surface": tetrahedron(), "phase": "estimate"},
    "cloud": {"view": ObjectView(UP, UP), "phase": "look"},
    "contacts": {"contacts": ContactSet(UP, UP), "phase": "retreat"},
    "touch": {"touch_plan": touch(), "phase": "touch: feel"},
    "candidates": {**grasps(100), "phase": "plan grasps"},
    "phase": {"phase": "look"},
    "grasp_contacts": {
        "surface": ball_in_the_hand(),
        "view": ObjectView(table=Plane(UP[0], -1.0)),
        "story": Story(grasps=(GraspRecord(np.eye(4), "side", "surface", 1.0, 0, {}),)),
        "phase": "grasp: approach",
    },
}
EMPTY = {
    "surface": {"surface": Surface(), "phase": ""},
    "cloud": {"view": ObjectView(), "phase": ""},
    "contacts": {"contacts": ContactSet(), "phase": ""},
    "touch": {"touch_plan": TouchPlan(), "phase": "touch"},
    "candidates": {**grasps(0), "phase": ""},
    "phase": {"phase": ""},
    "grasp_contacts": {
        "surface": Surface(),
        "view": ObjectView(),
        "story": Story(),
        "phase": "",
    },
}
NAMES = sorted(FULL)


@pytest.fixture(scope="module")
def hand():
    return read_hand_model(load_hand(default_hand()))


@pytest.fixture
def meshcat():
    return Meshcat(MeshcatParams(host="localhost"))


@pytest.fixture
def make(meshcat, hand):
    def publisher(name):
        return {
            "surface": lambda: SurfacePublisher(meshcat, "/pictures"),
            "cloud": lambda: CloudPublisher(meshcat, "/pictures"),
            "contacts": lambda: ContactsPublisher(meshcat, "/pictures"),
            "touch": lambda: TouchPublisher(meshcat, "/pictures"),
            "candidates": lambda: CandidatesPublisher(hand, meshcat, "/pictures"),
            "grasp_contacts": lambda: GraspContactsPublisher(hand, meshcat, "/pictures"),
            "phase": lambda: PhasePublisher(meshcat, RigidTransform(), path="/pictures"),
        }[name]()

    return publisher


def fix(system, context, values):
    for name, value in values.items():
        system.GetInputPort(name).FixValue(context, AbstractValue.Make(value))


@pytest.mark.parametrize("caching", [True, False])
@pytest.mark.parametrize("name", NAMES)
def test_picture_appears_when_there_is_something_to_see(make, meshcat, name, caching):
    system = make(name)
    simulator = Simulator(system)
    context = simulator.get_mutable_context()
    if not caching:
        context.DisableCaching()
    fix(system, context, EMPTY[name])
    simulator.AdvanceTo(0.1)
    assert not meshcat.HasPath("/pictures/0")
    fix(system, context, FULL[name])
    simulator.AdvanceTo(0.2)
    assert meshcat.HasPath("/pictures/0")
    assert not meshcat.HasPath("/pictures/1")


@pytest.mark.parametrize("name", NAMES)
def test_unchanged_input_is_drawn_once(make, meshcat, name, monkeypatch):
    system = make(name)
    drawn = []
    monkeypatch.setattr(system, "draw", lambda path, *picture: drawn.append(path))
    simulator = Simulator(system)
    fix(system, simulator.get_mutable_context(), FULL[name])
    simulator.AdvanceTo(1.0)
    assert drawn == ["/pictures/0"]


def test_the_same_value_computed_anew_is_not_drawn_again(make, monkeypatch):
    system = make("candidates")
    drawn = []
    monkeypatch.setattr(system, "draw", lambda path, *picture: drawn.append(path))
    simulator = Simulator(system)
    for i in range(3):
        values = grasps(7) | {"phase": "plan grasps"}
        fix(system, simulator.get_mutable_context(), values)
        simulator.AdvanceTo(0.1 * (i + 1))
    assert drawn == ["/pictures/0"]


def test_two_contexts_count_their_own_pictures(make, meshcat, monkeypatch):
    system = make("phase")
    drawn = []
    monkeypatch.setattr(system, "draw", lambda path, text: drawn.append((path, text)))
    for words in (("look", "touch"), ("estimate",)):
        simulator = Simulator(system, system.CreateDefaultContext())
        for i, word in enumerate(words):
            fix(system, simulator.get_mutable_context(), {"phase": word})
            simulator.AdvanceTo(0.1 * (i + 1))
    assert drawn == [("/pictures/0", "look"), ("/pictures/1", "touch"), ("/pictures/0", "estimate")]


def test_each_estimate_has_a_path_of_its_own(make, meshcat):
    system = make("surface")
    simulator = Simulator(system)
    for i in range(3):
        values = {"surface": dc.replace(tetrahedron(), variance=np.full(4, i)), "phase": "look"}
        fix(system, simulator.get_mutable_context(), values)
        simulator.AdvanceTo(0.1 * (i + 1))
    assert [meshcat.HasPath(f"/pictures/{i}") for i in range(4)] == [True, True, True, False]


def test_forced_publish_draws_without_a_simulation(make, meshcat):
    system = make("contacts")
    context = system.CreateDefaultContext()
    fix(system, context, FULL["contacts"])
    system.ForcedPublish(context)
    assert meshcat.HasPath("/pictures/0")


class Log:
    """Stands in for a Meshcat and writes down when what was visible."""

    def __init__(self):
        self.visible = []

    def SetProperty(self, path, name, value, time_in_recording):
        self.visible.append((path, value, round(time_in_recording, 3)))


@pytest.mark.parametrize("name", ["surface", "cloud", "contacts", "candidates", "grasp_contacts"])
def test_beliefs_are_hidden_when_the_hand_closes(make, name, monkeypatch):
    system, log = make(name), Log()
    monkeypatch.setattr(system, "_meshcat", log)
    monkeypatch.setattr(system, "draw", lambda path, *picture: None)
    simulator = Simulator(system)
    for phase, until in (("grasp: approach", 0.1), ("grasp: close", 0.2)):
        fix(system, simulator.get_mutable_context(), FULL[name] | {"phase": phase})
        simulator.AdvanceTo(until)
    path = "/pictures/0"
    assert log.visible == [(path, False, 0.0), (path, True, 0.0), (path, False, 0.12)]


def test_touch_is_hidden_once_it_is_over(make, monkeypatch):
    system, log = make("touch"), Log()
    monkeypatch.setattr(system, "_meshcat", log)
    monkeypatch.setattr(system, "draw", lambda path, *picture: None)
    simulator = Simulator(system)
    for phase, until in (("look", 0.1), ("touch: feel", 0.2), ("retreat: up", 0.3)):
        fix(system, simulator.get_mutable_context(), {"touch_plan": touch(), "phase": phase})
        simulator.AdvanceTo(until)
    path = "/pictures/0"
    assert log.visible == [(path, False, 0.0), (path, True, 0.12), (path, False, 0.24)]


def test_picture_of_candidates_bears_few_arrows_and_the_chosen_hand(make, monkeypatch):
    system = make("candidates")
    meshes = []
    monkeypatch.setattr(system, "draw_mesh", lambda path, mesh: meshes.append(mesh))
    chosen = GraspRecord(np.eye(4), "side", "surface", 1.0, 0, {})
    values = grasps(500)
    system.draw("/x", values["candidates"], values["scores"], None)
    system.draw("/x", values["candidates"], values["scores"], chosen)
    few, again, hand = meshes
    assert len(few.vertices) == len(again.vertices) == 60 * 50
    assert len(hand.colors)
    assert (hand.colors == np.array([0.1, 0.3, 1.0])).all()


def test_each_planner_has_a_path_and_arrows_of_its_own(make, monkeypatch):
    system, meshes = make("candidates"), {}
    monkeypatch.setattr(system, "draw_mesh", lambda path, mesh: meshes.update({path: mesh}))
    planners = ("surface",) * 10 + ("skeleton",) * 10
    both = dc.replace(grasps(20)["candidates"], planner=planners)
    system.draw("/x", both, grasps(20)["scores"], None)
    assert sorted(meshes) == ["/x/skeleton", "/x/surface"]
    assert len(meshes["/x/skeleton"].vertices) > len(meshes["/x/surface"].vertices)
    worst = meshes["/x/surface"].colors[-1]
    assert (worst == [0.8, 0.0, 0.05]).all()


def test_arrow_of_a_candidate_ends_in_the_power_tcp(make, monkeypatch, hand):
    system = make("candidates")
    meshes = []
    monkeypatch.setattr(system, "draw_mesh", lambda path, mesh: meshes.append(mesh))
    values = grasps(1)
    system.draw("/x", values["candidates"], values["scores"], None)
    tcp = np.asarray(hand.description.tcps["power"])
    approach = np.asarray(hand.description.approach) / np.linalg.norm(hand.description.approach)
    along = (meshes[0].vertices - tcp) @ approach
    assert along.max() == pytest.approx(0.0, abs=1e-9)


def test_contacts_of_the_chosen_grasp_lie_on_the_estimate_and_bear_friction_cones(
    make, monkeypatch
):
    system, meshes = make("grasp_contacts"), []
    monkeypatch.setattr(system, "draw_mesh", lambda path, mesh: meshes.append(mesh))
    full = FULL["grasp_contacts"]
    system.draw("/x", full["surface"], full["view"], full["story"].grasps[0])
    away = np.linalg.norm(meshes[0].vertices - BALL, axis=1)
    cone, ball = 30, 70  # vertices of each
    count = len(away) // (cone + ball)
    assert count >= 4
    assert len(away) == count * (cone + ball)
    apexes = away[count * ball :].reshape(count, cone)[:, :10]
    np.testing.assert_allclose(apexes, BALL_M, atol=0.001)
    rims = away[count * ball :].reshape(count, cone)[:, 10:20]
    expected = np.hypot(BALL_M + 0.015, 0.8 * 0.015)
    np.testing.assert_allclose(rims, expected, atol=0.002)


def test_no_contacts_are_predicted_before_a_grasp_is_chosen(make, meshcat):
    system = make("grasp_contacts")
    simulator = Simulator(system)
    values = FULL["grasp_contacts"] | {"story": Story(), "phase": "plan grasps"}
    fix(system, simulator.get_mutable_context(), values)
    simulator.AdvanceTo(0.1)
    assert not meshcat.HasPath("/pictures/0")


def test_scores_that_do_not_fit_the_candidates_wait(make, meshcat):
    system = make("candidates")
    simulator = Simulator(system)
    values = grasps(5) | {"candidates": grasps(6)["candidates"], "phase": "plan grasps"}
    fix(system, simulator.get_mutable_context(), values)
    simulator.AdvanceTo(0.1)
    assert not meshcat.HasPath("/pictures/0")
