import socket

import pytest
from browser import screenshot, share_of_hue
from pydrake.geometry import Box, Meshcat, MeshcatParams, Rgba

ORANGE = (1.0, 0.35, 0.0)
GREEN = (0.1, 0.8, 0.1)


@pytest.fixture
def meshcat():
    """A server that listens on this machine alone and shows one orange box."""
    server = Meshcat(MeshcatParams(host="localhost"))
    server.SetObject("box", Box(1.0, 1.0, 1.0), Rgba(*ORANGE, 1.0))
    server.SetCameraPose([3.0, 3.0, 2.0], [0.0, 0.0, 0.0])
    return server


def test_the_live_page_shows_a_box_in_its_colour(meshcat, tmp_path):
    picture = screenshot(meshcat.web_url(), tmp_path / "live.png")
    assert 0.01 < share_of_hue(picture, ORANGE) < 0.2
    assert share_of_hue(picture, GREEN) < 0.001


def test_the_recording_shows_the_same_without_a_server(meshcat, tmp_path):
    page = tmp_path / "recording.html"
    page.write_text(meshcat.StaticHtml())
    picture = screenshot(page, tmp_path / "recording.png")
    assert 0.01 < share_of_hue(picture, ORANGE) < 0.2


def test_an_invisible_box_leaves_no_pixel_of_its_colour(meshcat, tmp_path):
    meshcat.SetProperty("box", "visible", False)
    page = tmp_path / "empty.html"
    page.write_text(meshcat.StaticHtml())
    assert share_of_hue(screenshot(page, tmp_path / "empty.png"), ORANGE) < 0.001


def test_the_server_answers_at_its_own_address_alone(meshcat):
    with socket.create_connection(("localhost", meshcat.port()), timeout=5.0):
        pass
    # A server that is bound to all addresses would answer here too.
    with pytest.raises(OSError, match="refused"):
        socket.create_connection(("127.0.0.2", meshcat.port()), timeout=5.0)
