import numpy as np
import pytest

from vh_drake.benches import gpis
from vh_drake.benches.timing import best_ms


def test_potential_equals_that_of_the_peers():
    pytest.importorskip("gpytorch")
    pytest.importorskip("sklearn")
    assert gpis.difference_from_gpytorch(seed=0) < 1e-8
    assert gpis.difference_from_scikit_learn(seed=0) < 1e-8


def test_gpytorch_predicts_what_its_kernel_and_cached_weights_give():
    pytest.importorskip("gpytorch")
    seen = gpis.with_normals(10, seed=0)
    peer = gpis.GPyTorchSurface(gpis.EXPONENTIAL, seen)
    x = gpis.nodes()[:150]
    np.testing.assert_allclose(peer.predicted_mean(x), peer.mean(x), atol=1e-12)
    ours = gpis.fit(gpis.EXPONENTIAL, seen).variance(x)
    np.testing.assert_allclose(peer.variance(x), ours, atol=1e-8 * gpis.EXPONENTIAL.signal_std_m**2)


def test_every_part_of_ours_is_measured():
    times = gpis.times_of_ours(gpis.PLATE, gpis.with_normals(20, seed=0))
    assert set(times) == {"fit_ms", "append_ms", "grid_ms", "mesh_ms", "variance_ms"}
    assert all(0.0 < value < 1e4 for value in times.values())


def test_a_touch_step_ends_with_a_curve_to_a_place_on_the_ball():
    plan = gpis.touch_step(gpis.surface_before_touch(seed=0), *gpis.last_touch(seed=0))
    assert np.linalg.norm(plan.p_WT) == pytest.approx(gpis.RADIUS_M, abs=0.002)
    np.testing.assert_allclose(plan.control_points[3], plan.p_WT)
    assert plan.rating > 0.0


def test_growth_is_the_slope_between_logarithms():
    rows = [
        {"library": gpis.PLATE_NAME, "contacts": count, "append_ms": 1e-6 * count**1.5}
        for count in gpis.CONTACTS
    ]
    assert gpis.append_growth(rows) == pytest.approx(1.5)


def test_best_time_is_that_of_the_fastest_call():
    calls = []

    def work():
        calls.append(sum(range(1000 if len(calls) > 3 else 200_000)))

    assert best_ms(work, repeats=8) < 1.0
    assert len(calls) == 9


def test_long_work_is_called_once():
    calls = []
    best_ms(lambda: calls.append(sum(range(2_000_000))), repeats=8, budget_s=0.01)
    assert len(calls) == 1
