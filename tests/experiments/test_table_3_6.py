import dataclasses as dc

import numpy as np
import pytest
from scipy.spatial.distance import cdist

from vh_drake.experiments import table_3_6
from vh_drake.experiments.reconstruction import compare, with_normals
from vh_drake.geometry.sampling import sample_surface


def test_sensed_normals_err_by_the_mean_angle_of_the_sensor():
    n = np.tile([0.0, 0.6, 0.8], (20_000, 1))
    p, turned = table_3_6.sensed(np.zeros_like(n), n, seed=0)
    angle = np.degrees(np.arccos(np.clip(np.einsum("ij,ij->i", n, turned), -1.0, 1.0)))
    assert angle.mean() == pytest.approx(table_3_6.NORMAL_ERROR_DEG, rel=0.03)
    np.testing.assert_allclose(p.std(axis=0), table_3_6.PLACE_STD_M, rtol=0.03)


def test_shapes_have_the_stated_sizes():
    np.testing.assert_allclose(table_3_6.shape("box").extents, [0.10, 0.07, 0.05])
    np.testing.assert_allclose(table_3_6.shape("sphere").extents, 0.10, rtol=0.01)
    np.testing.assert_allclose(table_3_6.shape("cylinder").extents, [0.07, 0.07, 0.10], rtol=0.01)


def test_facets_of_the_sphere_turn_its_normals_by_less_than_half_a_degree():
    sphere = table_3_6.shape("sphere")
    outward = sphere.vertices - [0.0, 0.0, 0.05]
    corner = outward[sphere.faces[:, 0]] / 0.05
    cosine = np.einsum("ij,ij->i", corner, sphere.face_normals)
    assert np.degrees(np.arccos(cosine)).max() < 0.8


def test_a_human_guides_the_hand_all_over_the_object():
    truth = table_3_6.shape("cheez_it")
    p, n = table_3_6.gather("cheez_it", truth, 0)
    assert len(p) == 50
    places = sample_surface(truth, 2000, seed=1)[0]
    assert cdist(places, p).min(axis=1).max() < 0.045
    assert set(np.argmax(abs(n), axis=1)) == {0, 1, 2}


def test_what_a_human_touched_is_estimated_better_than_by_the_kernel_for_dense_contacts():
    truth = table_3_6.shape("cheez_it")
    p, n = table_3_6.sensed(*table_3_6.gather("cheez_it", truth, 1), 1)
    stiff, soft = (
        compare(with_normals(p, n, dc.replace(settings, spacing_m=0.005)), truth)
        for settings in (table_3_6.GUIDED, table_3_6.NOISY)
    )
    assert stiff.angle_rad < soft.angle_rad
    assert stiff.distance_m < soft.distance_m


def test_a_trial_takes_at_most_fifty_contacts_and_is_the_same_again():
    row = table_3_6.trial(("cylinder", 1))
    assert row["contacts"] <= 50
    assert row == table_3_6.trial(("cylinder", 1))
    assert row["mm"] < row["mm_without_normals"]


def test_summary_is_the_mean_of_the_runs():
    columns = ("mm", "deg", "mm_without_normals", "deg_without_normals")
    rows = [
        {"object": name, **dict.fromkeys(columns, value)}
        for name in (*table_3_6.SIMULATED, *table_3_6.ROBOT)
        for value in (1.0, 3.0)
    ]
    figures = table_3_6.summary(rows)
    assert figures["box_mm"] == 2.0
    assert figures["mean_error_ratio"] == 1.0
    assert set(table_3_6.thesis()) <= set(figures)
