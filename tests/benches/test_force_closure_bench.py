import numpy as np

from vh_drake.benches.force_closure import _decide_all, random_wrenches, run, slack
from vh_drake.catalog import Options
from vh_drake.grasping.wrench_space import is_force_closure


def test_the_bench_agrees_with_the_program_and_is_faster(tmp_path):
    summary = run(Options(out=tmp_path, runs=30)).summary
    assert summary["agreement"] == 1.0
    assert 0.2 < summary["closed_share"] < 0.95
    assert summary["speedup_over_lp"] > 20
    assert summary["epsilon_max_difference"] < 1e-12
    assert summary["epsilon_speedup_over_hull"] > 2
    assert {"tests_per_s", "speedup_over_lp", "agreement"} <= set(summary)


def test_the_timed_loop_decides_as_single_tests_do():
    rng = np.random.default_rng(1)
    grasps = [random_wrenches(rng) for _ in range(20)]
    rows = np.stack([np.pad(W.T, ((0, 64 - W.shape[1]), (0, 0))) for W in grasps])
    counts = np.array([W.shape[1] for W in grasps])
    assert _decide_all(rows, counts) == sum(map(is_force_closure, grasps))


def test_a_cross_of_wrenches_has_the_slack_of_equal_weights():
    assert np.isclose(slack(np.hstack([np.eye(6), -np.eye(6)])), 1.0)
