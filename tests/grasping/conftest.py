import numpy as np
import pytest

from vh_drake.geometry.model_files import models_folder
from vh_drake.hand.description import load_hand
from vh_drake.hand.model import read_hand_model
from vh_drake.types import Plane, Surface


@pytest.fixture(scope="session")
def hand():
    return read_hand_model(load_hand(models_folder() / "armar6_hand" / "armar6_hand.yaml"))


@pytest.fixture(scope="session")
def table():
    return Plane(np.array([0.0, 0, 1]), 0.9)


@pytest.fixture(scope="session")
def standing():
    """Makes a surface of a mesh that is put onto the table at a place."""

    def place(mesh, x=0.7, y=-0.3):
        mesh.apply_translation([x, y, 0.9 - mesh.bounds[0, 2]])
        vertices = np.array(mesh.vertices)
        variance = np.linspace(0, 1, len(vertices))
        faces = np.array(mesh.faces, np.int64)
        return Surface(vertices, faces, np.array(mesh.vertex_normals), variance)

    return place
