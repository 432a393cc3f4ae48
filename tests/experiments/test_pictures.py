import numpy as np
import pytest
from matplotlib.image import imread
from pydrake.geometry import Box, Rgba
from pydrake.math import RigidTransform

from vh_drake.errors import VhDrakeError
from vh_drake.experiments import browser as browsing
from vh_drake.experiments.browser import find_browser
from vh_drake.experiments.pictures import MOST_BYTES, SHOTS, SIZE, Shot, _page, _picture
from vh_drake.scenes.showing import make_meshcat

P_WO = np.array([0.7, -0.3, 0.9])


def test_page_of_a_shot_looks_at_the_object_and_hides_what_is_in_the_way(tmp_path):
    meshcat = make_meshcat()
    meshcat.SetObject("/thing", Box(0.1, 0.1, 0.1), Rgba(0.0, 0.0, 1.0))
    meshcat.SetObject("/wall", Box(0.5, 0.01, 0.5), Rgba(1.0, 0.0, 0.0))
    meshcat.SetTransform("/thing", RigidTransform(P_WO))
    meshcat.SetTransform("/wall", RigidTransform(P_WO + np.array([0.0, 0.2, 0.0])))
    shot = Shot("s", "look", 0.0, (0.0, 0.5, 0.1), (0.0, 0.0, 0.0), ("/wall",))
    path = _picture(_page(meshcat, shot, P_WO, tmp_path), tmp_path / "s.jpg")
    image = imread(path) / 255.0
    assert image.shape[:2] == SIZE[::-1]
    assert path.stat().st_size < MOST_BYTES
    middle = image[SIZE[1] // 2, SIZE[0] // 2]
    assert middle[2] > 1.5 * middle[0]
    assert not (image[..., 0] > 1.5 * image[..., 2]).any()


def test_shots_have_names_of_their_own():
    assert len({shot.name for shot in SHOTS}) == len(SHOTS)


def test_without_a_browser_the_error_names_the_remedy(monkeypatch):
    monkeypatch.setattr(browsing.shutil, "which", lambda name: None)
    with pytest.raises(VhDrakeError, match="install chromium"):
        find_browser()
