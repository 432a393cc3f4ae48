import base64
import io
import json

import numpy as np
import pytest
from matplotlib.image import imread

from vh_drake.geometry.billboard import text_billboard


def picture(text):
    uri = json.loads(text_billboard(text, height_m=0.1))["images"][0]["uri"]
    return imread(io.BytesIO(base64.b64decode(uri.partition(",")[2])))


def corners(text, height_m):
    document = json.loads(text_billboard(text, height_m=height_m))
    data = base64.b64decode(document["buffers"][0]["uri"].partition(",")[2])
    return np.frombuffer(data, "<f4", count=24).reshape(8, 3)


def test_sign_has_the_wanted_height_and_the_shape_of_its_picture():
    size = np.ptp(corners("look", 0.2), axis=0)
    height, width = picture("look").shape[:2]
    assert size[1] == pytest.approx(0.2)
    assert size[0] / size[1] == pytest.approx(width / height, rel=0.02)


def test_longer_text_makes_a_wider_sign():
    assert np.ptp(corners("plan grasps", 0.1)[:, 0]) > np.ptp(corners("look", 0.1)[:, 0])


def test_text_leaves_ink_inside_a_clean_margin():
    ink = picture("touch: feel")[..., :3].min(axis=-1) < 0.5
    assert 0.02 < ink.mean() < 0.5
    assert not ink[:, :10].any()
    assert not ink[:, -10:].any()


def test_all_that_the_file_needs_is_in_it():
    document = json.loads(text_billboard("look", height_m=0.1))
    uris = [entry["uri"] for entry in document["images"] + document["buffers"]]
    assert all(uri.startswith("data:") for uri in uris)
