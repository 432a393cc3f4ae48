import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree
from views import P_CAMERA, TABLE, ball, box, view_of

from vh_drake.errors import BadInput
from vh_drake.gpis.kernels import ThinPlate
from vh_drake.gpis.surface import SurfaceSettings, estimate_surface
from vh_drake.types import ContactSet, ObjectView

COARSE = SurfaceSettings(least_spacing_m=0.005)


def hidden_contacts(shape, count):
    """True touches of the side that the camera does not see, well over the table."""
    p, n = shape
    away = np.einsum("ij,ij->i", n, P_CAMERA - p) / np.linalg.norm(P_CAMERA - p, axis=1) < -0.25
    rows = np.flatnonzero(away & (p[:, 2] > 0.915))
    rows = rows[np.linspace(0, len(rows) - 1, count).astype(int)]
    return ContactSet(p[rows], n[rows])


def mean_error(surface, shape):
    mesh = trimesh.Trimesh(surface.vertices, surface.faces, process=False)
    sampled = trimesh.sample.sample_surface(mesh, 4000, seed=0)[0]
    sampled = sampled[sampled[:, 2] > 0.903]
    forth = cKDTree(shape[0]).query(sampled)[0].mean()
    back = cKDTree(sampled).query(shape[0])[0].mean()
    return 0.5 * (forth + back)


@pytest.mark.parametrize("shape", [ball(), box(), box((0.03, 0.2, 0.03))])
@pytest.mark.parametrize("touches", [0, 1, 5])
def test_one_sided_view_gives_a_closed_surface_near_the_truth(shape, touches):
    contacts = hidden_contacts(shape, touches) if touches else ContactSet()
    surface = estimate_surface(view_of(shape), contacts, COARSE)
    mesh = trimesh.Trimesh(surface.vertices, surface.faces, process=False)
    assert mesh.is_watertight
    assert mesh.volume > 0
    assert surface.vertices[:, 2].min() > 0.9 - 1e-3
    assert mean_error(surface, shape) < 0.005


def test_a_touch_brings_the_surface_to_the_contact():
    shape = ball()
    for touches in (1, 3):
        contacts = hidden_contacts(shape, touches)
        surface = estimate_surface(view_of(shape), contacts, COARSE)
        distance, nearest = cKDTree(surface.vertices).query(contacts.p_WC)
        assert distance.max() < 0.005
        assert np.einsum("ij,ij->i", surface.normals[nearest], contacts.n_WC).min() > 0.85


def test_touches_lower_error_and_variance_at_the_back():
    shape = ball()
    contacts = hidden_contacts(shape, 4)
    before = estimate_surface(view_of(shape), ContactSet(), COARSE)
    after = estimate_surface(view_of(shape), contacts, COARSE)
    assert mean_error(after, shape) < mean_error(before, shape)
    near = cKDTree(before.vertices).query(contacts.p_WC)[1]
    near_after = cKDTree(after.vertices).query(contacts.p_WC)[1]
    assert np.all(after.variance[near_after] < before.variance[near])


def test_hidden_side_is_less_certain_than_the_seen_one():
    shape = box()
    surface = estimate_surface(view_of(shape), ContactSet(), COARSE)
    facing = np.einsum("ij,ij->i", surface.normals, P_CAMERA - surface.vertices)
    high = surface.vertices[:, 2] > 0.905
    assert surface.variance[high & (facing < 0)].mean() > 2 * surface.variance[facing > 0].mean()


def test_thin_plate_kernel_closes_too():
    settings = SurfaceSettings(kernel=ThinPlate(signal_std_m=0.1), least_spacing_m=0.005)
    surface = estimate_surface(view_of(ball()), hidden_contacts(ball(), 2), settings)
    assert trimesh.Trimesh(surface.vertices, surface.faces, process=False).is_watertight
    assert mean_error(surface, ball()) < 0.006


def test_a_translation_of_everything_moves_the_surface():
    view, shift = view_of(box()), np.array([0.2, 0.1, 0.05])
    table = type(TABLE)(TABLE.normal, TABLE.offset + shift[2])
    moved = ObjectView(view.p_WO + shift, view.n_WO, table, view.p_WCamera + shift)
    still = estimate_surface(view, ContactSet(), COARSE)
    other = estimate_surface(moved, ContactSet(), COARSE)
    distance, _ = cKDTree(still.vertices + shift).query(other.vertices)
    assert np.median(distance) < 1e-3


def contact_set(points, normals):
    return ContactSet(np.array(points, float), np.array(normals, float))


@pytest.mark.parametrize(
    "contacts",
    [
        contact_set([[0.7, -0.3, 1.0]], [[0, 0, 1]]),
        contact_set([[0.7 + x, -0.3, 1.0] for x in (0, 0.02, 0.04)], [[0, 0, 1]] * 3),
        contact_set([[0.7, -0.3, 1.0]] * 3, [[0, 0, 1]] * 3),
        contact_set([[0.7, -0.3, 1.0]] * 2, [[0, 0, 1], [0, 0, -1]]),
    ],
    ids=["single", "collinear", "duplicate", "contradictory"],
)
@pytest.mark.parametrize("seen", [True, False])
def test_degenerate_contacts_give_a_closed_surface(contacts, seen):
    view = view_of(box()) if seen else ObjectView(table=TABLE, p_WCamera=P_CAMERA)
    surface = estimate_surface(view, contacts, COARSE)
    assert len(surface.faces) > 0
    assert trimesh.Trimesh(surface.vertices, surface.faces, process=False).is_watertight


def test_nothing_seen_and_nothing_touched_is_refused():
    with pytest.raises(BadInput, match="neither"):
        estimate_surface(ObjectView(table=TABLE), ContactSet())


def test_a_scene_of_several_metres_is_refused():
    far = contact_set([[0.7, -0.3, 1.0], [9.0, 0, 1.0]], [[0, 0, 1]] * 2)
    with pytest.raises(BadInput, match="spread over"):
        estimate_surface(view_of(box()), far)
