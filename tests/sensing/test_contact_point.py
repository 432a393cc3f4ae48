import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from vh_drake.errors import BadInput
from vh_drake.sensing.contact_point import (
    Readings,
    Skin,
    capsule_skin,
    contact_normal,
    contact_point,
    expected_approach,
    pad_skin,
)

A, B, RADIUS = np.array([0.03, -0.01, 0.105]), np.array([0.03, -0.01, 0.134]), 0.0086
NOISE = {"force_std_n": 0.006, "torque_std_nm": 0.00015}


def wrench(p, force):
    return np.concatenate([np.cross(p, force), force])


@pytest.mark.parametrize("force_n", [0.15, 1.0])
def test_the_point_that_was_pushed_is_found_through_the_noise(force_n):
    skin = capsule_skin(A, B, RADIUS)
    rng = np.random.default_rng(0)
    errors = []
    for i in rng.choice(len(skin.p_H), 200):
        clean = wrench(skin.p_H[i], -force_n * skin.n_H[i])
        noise = rng.standard_normal(6) * ([NOISE["torque_std_nm"]] * 3 + [NOISE["force_std_n"]] * 3)
        found, _ = contact_point(skin, Readings.of(clean + noise), **NOISE)
        errors.append(np.linalg.norm(found - skin.p_H[i]))
    assert np.median(errors) < (0.008 if force_n < 0.5 else 0.004)
    assert np.max(errors) < 0.035


def test_the_moments_give_the_sum_of_squared_misfits():
    rng = np.random.default_rng(1)
    wrenches, points = rng.normal(size=(9, 6)), rng.normal(size=(20, 3))
    expected = [sum(((w[:3] - np.cross(p, w[3:])) ** 2).sum() for w in wrenches) for p in points]
    np.testing.assert_allclose(Readings.of(*wrenches).misfit(points), expected, rtol=1e-10)


def test_more_readings_place_a_contact_better():
    skin = capsule_skin(A, B, RADIUS)
    rng = np.random.default_rng(2)
    errors = {1: [], 25: []}
    for i in rng.choice(len(skin.p_H), 100):
        clean = wrench(skin.p_H[i], -0.3 * skin.n_H[i])
        noise = rng.standard_normal((25, 6)) * np.repeat([0.00015, 0.006], 3)
        for count, found in errors.items():
            p_H, _ = contact_point(skin, Readings.of(*(clean + noise[:count])), **NOISE)
            found.append(np.linalg.norm(p_H - skin.p_H[i]))
    assert np.mean(errors[25]) < 0.5 * np.mean(errors[1])


def test_a_peak_places_a_contact_although_it_is_long_over():
    skin = capsule_skin(A, B, RADIUS)
    clean = wrench(skin.p_H[30], -2.0 * skin.n_H[30])
    rng = np.random.default_rng(3)
    after = rng.standard_normal((60, 6)) * np.repeat([0.00015, 0.006], 3)
    p_H, _ = contact_point(skin, Readings.of(clean, *after), **NOISE)
    np.testing.assert_allclose(p_H, skin.p_H[30], atol=0.004)


def test_of_two_places_on_the_force_s_line_the_one_that_moves_ahead_touches():
    p = np.array([[0.02, 0.0, 0.12], [0.02, 0.0, 0.14]])
    skin = Skin(p, np.array([[-1.0, 0, 0], [-0.6, 0, 0.8]]), p[0])
    reading = Readings.of(wrench(p[0], np.array([1.0, 0.0, -1.0])))
    vague = {"force_std_n": 5.0, "torque_std_nm": 5.0}
    for approach, place in (([-1.0, 0, 0], p[0]), ([0.0, 0, 1], p[1])):
        found, _ = contact_point(skin, reading, approach_H=np.array(approach), **vague)
        np.testing.assert_array_equal(found, place)


def test_skin_and_motion_agree_on_what_is_expected():
    approach, n = np.array([0.0, 0.0, -2.0]), np.array([0.0, 0.6, -0.8])
    expected = expected_approach(approach, n)
    lean = np.arctan2(expected[1], -expected[2])
    assert 0.0 < lean < np.arctan2(0.6, 0.8) / 2
    np.testing.assert_allclose(expected_approach(approach, approach / 2)[:2], 0.0)
    np.testing.assert_array_equal(expected_approach(np.zeros(3), n), 0.0)


def test_a_force_that_pulls_the_skin_is_never_explained_by_it():
    skin = capsule_skin(A, B, RADIUS)
    force = np.array([-0.5, 0.0, 0.0])
    _, n_H = contact_point(skin, Readings.of(wrench(B, force)), **NOISE)
    assert n_H @ force < 0.0


def test_without_torque_information_the_expected_place_wins():
    skin = pad_skin(np.array([[0.02, 0.0, 0.12], [0.02, 0.03, 0.1]]), np.array([[-1.0, 0, 0]] * 2))
    reading = Readings.of(wrench(skin.p_H[-1], np.array([0.1, 0, 0])))
    found, _ = contact_point(skin, reading, force_std_n=0.01, torque_std_nm=10.0)
    np.testing.assert_allclose(found, [0.02, 0.0, 0.12], atol=0.005)


def test_capsule_points_lie_on_the_capsule_and_normals_point_out():
    skin = capsule_skin(A, B, RADIUS)
    s = np.clip((skin.p_H - A) @ (B - A) / ((B - A) @ (B - A)), 0.0, 1.0)
    offset = skin.p_H - (A + s[:, None] * (B - A))
    np.testing.assert_allclose(np.linalg.norm(offset, axis=1), RADIUS)
    np.testing.assert_allclose(offset / RADIUS, skin.n_H, atol=1e-9)


def test_pad_points_lie_in_the_pad_s_plane_within_its_radius():
    p, n = np.array([0.02, 0.0, 0.12]), np.array([-3.0, 0.0, 1.0])
    skin = pad_skin(p, n, radius_m=0.006)
    assert np.abs((skin.p_H - p) @ n).max() < 1e-12
    assert np.linalg.norm(skin.p_H - p, axis=1).max() <= 0.006 + 1e-9
    np.testing.assert_allclose(np.linalg.norm(skin.n_H, axis=1), 1.0)


def test_a_pad_s_normals_lean_outwards_from_its_middle_to_its_rim():
    p, n = np.array([0.02, 0.0, 0.12]), np.array([-3.0, 0.0, 1.0]) / np.sqrt(10.0)
    skin = pad_skin(p, n, radius_m=0.006, spacing_m=0.002, rim_lean_rad=0.5)
    across = skin.p_H - p
    distance = np.linalg.norm(across, axis=1)
    np.testing.assert_allclose(skin.n_H[distance.argmin()], n, atol=1e-12)
    lean = np.arccos(np.clip(skin.n_H @ n, -1.0, 1.0))
    np.testing.assert_allclose(np.tan(lean), np.tan(0.5) * distance / 0.006, atol=1e-6)
    assert ((skin.n_H * across).sum(axis=1) >= -1e-12).all()


def test_the_side_of_the_pad_that_presses_tells_where_the_object_leans():
    p, n = np.array([0.0, 0.0, 0.12]), np.array([0.0, 0.0, 1.0])
    skin = pad_skin(p, n)
    vague = {"force_std_n": 1e-3, "torque_std_nm": 1e-4}
    for side in (-1.0, 1.0):
        place = p + np.array([0.0, 0.004 * side, 0.0])
        reading = Readings.of(wrench(place, np.array([0.0, 0.0, -1.0])))
        _, n_H = contact_point(skin, reading, approach_H=n, **vague)
        normal = contact_normal(reading.force, expected_approach(n, n_H), 0.8)
        assert normal[1] * side < -0.15  # The object comes forward on that side, so it faces away.


def test_a_force_within_the_friction_cone_leaves_the_expected_normal():
    lean = np.deg2rad(30.0)
    force = 3.0 * np.array([np.cos(lean), np.sin(lean), 0.0])
    found = contact_normal(force, np.array([-2.0, 0.0, 0.0]), 0.8)
    np.testing.assert_allclose(found, [1, 0, 0])


def test_a_force_beyond_the_cone_turns_the_normal_just_into_it():
    lean = np.deg2rad(70.0)
    force = 3.0 * np.array([np.cos(lean), np.sin(lean), 0.0])
    found = contact_normal(force, np.array([-2.0, 0.0, 0.0]), 0.8)
    assert np.linalg.norm(found) == pytest.approx(1.0)
    assert np.arccos(found @ force / 3.0) == pytest.approx(np.arctan(0.8))
    turned = lean - np.arctan(0.8)
    np.testing.assert_allclose(found, [np.cos(turned), np.sin(turned), 0], atol=1e-12)


def test_without_friction_the_force_is_the_normal():
    force = np.array([0.3, -0.4, 0.0])
    found = contact_normal(force, np.array([-1.0, 0.0, 0.0]), 0.0)
    np.testing.assert_allclose(found, [0.6, -0.8, 0.0], atol=1e-12)


def test_the_normal_turns_with_everything():
    R = Rotation.from_rotvec([0.4, -0.2, 0.9]).as_matrix()
    force, approach = np.array([0.2, 0.5, -0.1]), np.array([-0.3, 0.1, 0.2])
    np.testing.assert_allclose(
        contact_normal(R @ force, R @ approach, 0.5), R @ contact_normal(force, approach, 0.5)
    )


@pytest.mark.parametrize(
    ("force", "approach", "normal"),
    [
        ((0, 0, 0), (0, 2, 0), (0, -1, 0)),
        ((0, 3, 0), (0, 0, 0), (0, 1, 0)),
        ((0,) * 3, (0,) * 3, (0, 0, 1)),
    ],
)
def test_missing_force_or_approach_still_gives_a_unit_normal(force, approach, normal):
    found = contact_normal(np.array(force, float), np.array(approach, float), 0.8)
    np.testing.assert_allclose(found, normal)


def test_a_hand_without_skin_is_refused():
    with pytest.raises(BadInput, match="skin"):
        Skin(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(3))
