import numpy as np
import pytest
from scipy.spatial import ConvexHull, Delaunay

from vh_drake.geometry import decomposition
from vh_drake.geometry.decomposition import cache_folder, convex_pieces
from vh_drake.geometry.meshes import TriMesh
from vh_drake.geometry.sampling import sample_surface
from vh_drake.objects.distance_fields import mesh_field, rounded_box, union
from vh_drake.objects.library import library_object


@pytest.fixture(scope="module")
def bracket() -> TriMesh:
    """An L of 6 by 6 cm, 3 cm thick."""
    lying = rounded_box((0, 0, 0), (0.06, 0.03, 0.02), 0.002)
    standing = rounded_box((-0.02, 0, 0.02), (0.02, 0.03, 0.06), 0.002)
    return mesh_field(union(lying, standing), (-0.04, -0.03, -0.02), (0.04, 0.03, 0.06))


def covered(pieces, points):
    return np.any([Delaunay(piece).find_simplex(points) >= 0 for piece in pieces], axis=0)


def test_a_convex_mesh_is_one_piece(tmp_path):
    pieces = convex_pieces(library_object("can").mesh, cache=tmp_path)
    assert len(pieces) == 1
    assert not list(tmp_path.iterdir())


def test_pieces_cover_the_shape_and_leave_its_notch_free(bracket, tmp_path):
    pieces = convex_pieces(bracket, cache=tmp_path)
    points, normals = sample_surface(bracket, 500, seed=0)
    assert covered(pieces, points - 0.003 * normals).mean() > 0.97
    assert not covered(pieces, np.array([[0.015, 0.0, 0.04]])).any()
    assert sum(ConvexHull(piece).volume for piece in pieces) == pytest.approx(
        bracket.volume, rel=0.1
    )


def test_the_opening_of_a_mug_stays_open(tmp_path):
    pieces = convex_pieces(library_object("mug").mesh, cache=tmp_path)
    assert 1 < len(pieces) <= 16
    axis = np.column_stack([np.zeros((8, 2)), np.linspace(0.02, 0.09, 8)])
    assert not covered(pieces, axis).any()
    angles = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    ring = 0.026 * np.column_stack([np.cos(angles), np.sin(angles), np.full(24, 0.05 / 0.026)])
    assert not covered(pieces, ring).any()


def test_the_second_call_reads_the_cache(bracket, tmp_path, monkeypatch):
    first = convex_pieces(bracket, cache=tmp_path)
    monkeypatch.setattr(decomposition, "_decompose", lambda *_: pytest.fail("not cached"))
    second = convex_pieces(bracket, cache=tmp_path)
    assert len(first) == len(second)
    for a, b in zip(first, second, strict=True):
        np.testing.assert_array_equal(a, b)


def test_a_damaged_cache_is_computed_anew(bracket, tmp_path):
    first = convex_pieces(bracket, cache=tmp_path)
    (path,) = tmp_path.iterdir()
    path.write_bytes(path.read_bytes()[:100])
    assert len(convex_pieces(bracket, cache=tmp_path)) == len(first)


def test_a_cache_that_can_not_be_written_is_no_error(bracket, tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("in the way")
    assert convex_pieces(bracket, cache=blocked / "cache")


def test_the_cache_folder_follows_the_environment(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache_folder() == tmp_path / "vh_drake"


def test_where_cutting_ends_its_process_repair_is_tried_and_then_the_hull(bracket, monkeypatch):
    asked = []
    cut = decomposition._in_a_process

    def fails(mesh, options):
        asked.append(options["preprocess_mode"])
        return cut(mesh, options) if options["preprocess_mode"] == mended else ()

    monkeypatch.setattr(decomposition, "_in_a_process", fails)
    mended = "on"
    assert 1 < len(decomposition._decompose(bracket, 0)) <= 16
    assert asked == ["auto", "on"]
    mended = None
    with pytest.warns(UserWarning, match="hull is taken"):
        pieces = decomposition._decompose(bracket, 0)
    assert len(pieces) == 1
    assert ConvexHull(pieces[0]).volume == pytest.approx(bracket.convex_hull.volume, rel=0.05)


def test_a_process_that_ends_badly_gives_no_pieces(bracket):
    assert decomposition._in_a_process(bracket, {"no_such_option": 1}) == ()
