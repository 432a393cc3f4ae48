import numpy as np
import pytest
from pydrake.geometry import Meshcat, MeshcatParams

from vh_drake.exploration.explorer import ExplorerSettings
from vh_drake.exploration.loop import EndSettings, explore, make_body
from vh_drake.objects import lathe
from vh_drake.scenes.exploration_recording import (
    record_exploration,
    show_object,
    show_step,
    step_meshes,
)

SETTINGS = ExplorerSettings()
RADIUS_M = 0.03


@pytest.fixture(scope="module")
def exploration():
    mesh = lathe.sphere(RADIUS_M)
    body = make_body(mesh, mesh.bounds.mean(axis=0))
    return explore(body, SETTINGS, EndSettings(most_touches=3), seed=0)


class Log:
    """Stands in for a Meshcat and writes down what is drawn and hidden."""

    def __init__(self):
        self.drawn, self.visible = [], {}

    def SetTriangleColorMesh(self, path, vertices, faces, colors):
        self.drawn.append(path)

    def SetProperty(self, path, name, value):
        self.visible[path] = value


def test_a_live_page_shows_the_last_step_alone(exploration):
    log = Log()
    show_step(log, 0, exploration.start, None, SETTINGS)
    for number, step in enumerate(exploration.steps, 1):
        show_step(log, number, step.known, step.touch, SETTINGS)
    last = len(exploration.steps)
    assert f"step/{last}/estimate" in log.drawn
    assert log.visible == {f"step/{i}": False for i in range(last)}


def test_a_step_draws_every_contact_and_the_way_that_ends_a_tip_radius_off_the_last(exploration):
    step = exploration.steps[-1]
    meshes = step_meshes(step.known, step.touch, SETTINGS)
    p, n = step.known.contacts.p_WC, step.known.contacts.n_WC
    for place in p:
        assert np.linalg.norm(meshes["contacts"].vertices - place, axis=1).min() < 0.002
    end = p[-1] + SETTINGS.tip_radius_m * n[-1]
    assert np.linalg.norm(meshes["way"].vertices - end, axis=1).min() < 0.002
    assert "way" not in step_meshes(exploration.start, None, SETTINGS)


def test_object_and_steps_appear_in_a_real_meshcat(exploration):
    meshcat = Meshcat(MeshcatParams(host="localhost"))
    show_object(meshcat, lathe.sphere(RADIUS_M))
    show_step(meshcat, 0, exploration.start, None, SETTINGS)
    assert meshcat.HasPath("object")
    assert meshcat.HasPath("step/0/contacts")


def test_a_recording_is_a_page_with_every_step(exploration, tmp_path):
    path = record_exploration(
        exploration, lathe.sphere(RADIUS_M), SETTINGS, tmp_path / "recording.html"
    )
    assert path.read_text().lower().startswith("<!doctype html>")
