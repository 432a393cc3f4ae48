import numpy as np
import pytest
import trimesh

from vh_drake.exploration.loop import make_body
from vh_drake.exploration.shortest_way import make_sites
from vh_drake.geometry.meshes import from_trimesh


@pytest.fixture
def apart():
    """A body of two boxes that no way of the fingertip joins, and its sites."""
    box = trimesh.creation.box((0.04, 0.04, 0.04))
    mesh = from_trimesh(trimesh.util.concatenate([box, box.copy().apply_translation((0.5, 0, 0))]))
    body = make_body(mesh, np.zeros(3))
    return body, make_sites(body, mesh, count=200)
