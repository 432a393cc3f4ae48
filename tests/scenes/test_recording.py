import base64
import re

import numpy as np
import pytest
from browser import screenshot, share_of_hue
from pydrake.common.value import Value
from pydrake.geometry import Box, Rgba
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator

from vh_drake.errors import VhDrakeError
from vh_drake.scenes import recording
from vh_drake.scenes.recording import start_recording, write_recording
from vh_drake.scenes.showing import TARGET_W, make_meshcat
from vh_drake.systems.contacts_publisher import ContactsPublisher
from vh_drake.types import ContactSet

GREEN, RED = (0.41, 0.83, 0.26), (0.84, 0.22, 0.33)  # as lit


@pytest.fixture
def meshcat():
    server = make_meshcat()
    server.SetObject("box", Box(0.2, 0.2, 0.2), Rgba(0.0, 0.8, 0.1))
    server.SetTransform("box", RigidTransform(TARGET_W))
    return server


def test_the_recording_shows_the_scene_without_a_server(meshcat, tmp_path):
    start_recording(meshcat)
    page = write_recording(meshcat, tmp_path / "new" / "recording.html")
    assert share_of_hue(screenshot(page, tmp_path / "page.png"), GREEN) > 0.005


def recorded(meshcat, folder, *, closing):
    """A recording of touched places, hidden at its end or not."""
    publisher = ContactsPublisher(meshcat)
    simulator = Simulator(publisher)
    context = simulator.get_mutable_context()
    wall = np.array(TARGET_W) + np.random.default_rng(0).uniform(-0.2, 0.2, (300, 3))
    touched = ContactSet(wall, np.tile([0.0, 0.0, 1.0], (300, 1)))
    publisher.GetInputPort("contacts").FixValue(context, Value[object](touched))
    start_recording(meshcat)
    for phase, until in (("touch", 0.1), ("grasp: close" if closing else "touch", 0.2)):
        publisher.GetInputPort("phase").FixValue(context, Value[str](phase))
        simulator.AdvanceTo(until)
    return write_recording(meshcat, folder / "recording.html")


def test_what_was_shown_in_the_run_is_shown_when_it_is_replayed(meshcat, tmp_path):
    meshcat.Delete("box")
    page = recorded(meshcat, tmp_path, closing=False)
    picture = screenshot(page, tmp_path / "page.png", budget_s=1.5)
    assert share_of_hue(picture, RED) > 0.003


def hidings(page):
    """How many of the recorded key frames have the value false, as MessagePack writes it."""
    chunks = re.findall(r"base64,([A-Za-z0-9+/=]{40,})", page.read_text())
    return sum(base64.b64decode(chunk).count(b"value\xc2") for chunk in chunks)


def test_what_was_hidden_in_the_run_is_hidden_in_the_recording(meshcat, tmp_path):
    shown = recorded(meshcat, tmp_path / "shown", closing=False)
    meshcat.Delete("contacts")
    hidden = recorded(meshcat, tmp_path / "hidden", closing=True)
    assert hidings(hidden) > hidings(shown)


def test_a_recording_too_large_for_mail_is_refused(meshcat, tmp_path, monkeypatch):
    monkeypatch.setattr(recording, "MOST_BYTES", 1000)
    start_recording(meshcat)
    with pytest.raises(VhDrakeError, match="fewer frames"):
        write_recording(meshcat, tmp_path / "recording.html")
    assert not list(tmp_path.iterdir())


def test_a_failed_write_keeps_the_file_that_was_there(meshcat, tmp_path, monkeypatch):
    page = tmp_path / "recording.html"
    page.write_text("earlier")

    def full(*_):
        raise OSError("no space left on device")

    monkeypatch.setattr(recording.os, "replace", full)
    start_recording(meshcat)
    with pytest.raises(OSError, match="no space"):
        write_recording(meshcat, page)
    assert page.read_text() == "earlier"
    assert list(tmp_path.iterdir()) == [page]


def test_the_page_loads_nothing_from_elsewhere(meshcat, tmp_path):
    start_recording(meshcat)
    text = write_recording(meshcat, tmp_path / "recording.html").read_text()
    assert not re.findall(r"<(?:script|link|img)[^>]+(?:src|href)=[\"']?https?://", text)
