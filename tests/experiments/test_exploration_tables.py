import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from vh_drake.catalog import Options
from vh_drake.errors import BadInput, UnknownName
from vh_drake.experiments import appendix_a, table_3_5
from vh_drake.experiments.contenders import CONTENDERS, DEFAULT, KNOWING, chosen_contenders
from vh_drake.experiments.exploration_statistics import compared, interval, object_means
from vh_drake.experiments.exploration_trials import explored_objects
from vh_drake.experiments.figure_3_37 import regression
from vh_drake.objects import lathe

THREE = "igef,gp_variance,random,gp_variance_equal_radius"


def made_row(name, contender, distance, end="goal"):
    return {
        "object": name,
        "split": "test",
        "contender": contender,
        "seed": 0,
        "area_cm2": 100.0,
        "end": end,
        "distance_cm": distance,
        "rotation_deg": 1.0,
        "rmse_mm": 2.0,
        "prediction_error_mm": 3.0,
        "contacts": 4,
    }


def test_ratios_are_those_of_the_means_of_each_object_averaged_over_objects():
    rows = [
        made_row("a", "igef", 10.0),
        made_row("a", "igef", 30.0),
        made_row("a", "gp_variance", 40.0),
        made_row("b", "igef", 30.0),
        made_row("b", "gp_variance", 30.0),
        made_row("a", "random", 25.0),
        made_row("b", "random", 40.0, end="stuck"),
    ]
    summary = compared(object_means(rows))
    assert summary["igef_over_gp_variance_mean_ratio"] == 0.75  # of 20 / 40 and 30 / 30
    assert summary["igef_shortest_share"] == 0.5
    assert summary["reached_coverage_share"] == 0.5
    assert "igef_shortest_share_equal_radius" not in summary


@pytest.mark.parametrize("name", KNOWING)
def test_who_knows_the_object_is_set_beside_what_strategies_need(name):
    rows = [
        made_row("a", name, 10.0),
        made_row("b", name, 30.0),
        made_row("a", "gp_variance", 40.0),
        made_row("b", "gp_variance", 40.0),
    ]
    assert compared(object_means(rows))[f"{name}_over_gp_variance_mean_ratio"] == 0.5
    rows += [made_row("a", "igef", 20.0), made_row("b", "igef", 30.0)]
    assert compared(object_means(rows))[f"igef_over_{name}_mean_ratio"] == 1.5


def test_the_interval_of_a_mean_covers_it_and_narrows_with_more_values():
    rng = np.random.default_rng(0)
    few, many = rng.normal(size=20), rng.normal(size=2000)
    for values in (few, many):
        low, high = interval(values)
        assert low < values.mean() < high
        # 1.96 standard errors on either side, by the central limit theorem
        assert high - low == pytest.approx(3.92 * values.std() / len(values) ** 0.5, rel=0.1)


def test_a_regression_recovers_a_line():
    area = np.array([100.0, 200.0, 400.0])
    assert regression(0.5 * area + 3.0, area) == pytest.approx((0.5, 3.0, 1.0))


def test_contenders_are_chosen_by_name_and_a_wrong_one_lists_them():
    assert chosen_contenders(None) == DEFAULT
    assert chosen_contenders("random, igef") == ("random", "igef")
    assert chosen_contenders("all") == tuple(CONTENDERS)
    assert {"igef", "gp_variance", "random", "uncertainty_cost", "potential_field"} <= set(
        CONTENDERS
    )
    with pytest.raises(UnknownName, match="potential_field"):
        chosen_contenders("greedy")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A ball, a box, a long one of the train split, and a ball that is too small."""
    path = tmp_path_factory.mktemp("objects")
    for name, mesh in (
        ("ball", lathe.sphere(0.03)),
        ("box", lathe.box((0.06, 0.04, 0.03))),
        ("long", lathe.box((0.09, 0.03, 0.03))),
        ("pea", lathe.sphere(0.01)),
    ):
        mesh.to_trimesh().export(path / f"{name}.ply")
    (path / "objects.csv").write_text("name,split\nball,test\nbox,test\nlong,train\npea,test\n")
    return path


def test_small_objects_are_left_out_and_rows_keep_their_split(folder, tmp_path):
    options = Options(objects=folder, out=tmp_path)
    assert explored_objects(options) == {"ball": "test", "box": "test", "long": "train"}
    one = Options(objects=folder, split="train", out=tmp_path)
    assert explored_objects(one) == {"long": "train"}
    with pytest.raises(BadInput, match="5 cm"):
        explored_objects(Options(objects=folder, split="validation", out=tmp_path))


def written(report_module, folder, out, workers):
    options = Options(objects=folder, runs=1, strategies=THREE, workers=workers, out=out)
    report = report_module.run(options)
    report.save(out)
    return report, (out / f"{report.name}.json").read_bytes()


def test_one_and_two_workers_write_the_same_bytes_and_the_appendix_reads_the_same_runs(
    folder, tmp_path
):
    report, alone = written(table_3_5, folder, tmp_path / "one", 1)
    assert written(table_3_5, folder, tmp_path / "two", 2)[1] == alone
    assert (tmp_path / "one" / "table-3.5.png").stat().st_size > 10_000
    assert report.settings["split"] == "test"
    assert report.summary["objects"] == 2
    assert report.summary["train_objects"] == 1
    assert {row["split"] for row in report.rows} == {"test", "train"}
    before = (tmp_path / "one" / "explorations.jsonl").read_bytes()
    appendix, _ = written(appendix_a, folder, tmp_path / "one", 1)
    assert (tmp_path / "one" / "explorations.jsonl").read_bytes() == before
    by_name = {row["object"]: row for row in appendix.rows}
    runs = {(r["object"], r["contender"]): r["distance_cm"] for r in report.rows}
    assert by_name["box"]["igef_distance_cm"] == pytest.approx(runs["box", "igef"])


def test_thesis_figures_are_those_of_the_errata():
    thesis = table_3_5.thesis()
    assert thesis["igef_over_gp_variance_mean_ratio"] == pytest.approx(0.452, abs=5e-4)
    assert thesis["igef_over_random_mean_ratio"] == pytest.approx(0.480, abs=5e-4)
    assert thesis["igef_shortest_share"] == 1.0
    assert thesis["igef_prediction_error_mm"] == 3.5


@pytest.mark.slow
def test_a_table_killed_at_random_moments_ends_with_the_same_bytes(folder, tmp_path):
    code = (
        "import sys\nfrom pathlib import Path\nfrom vh_drake.catalog import Options\n"
        "from vh_drake.experiments import table_3_5\n"
        "table_3_5.run(Options(objects=Path(sys.argv[1]), runs=3, workers=1,"
        " strategies=sys.argv[3], out=Path(sys.argv[2]))).save(Path(sys.argv[2]))\n"
    )
    out = tmp_path / "killed"
    command = [sys.executable, "-c", code, str(folder), str(out), THREE]
    journal, rng = out / "explorations.jsonl", np.random.default_rng(0)
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    for _ in range(3):
        done = journal.stat().st_size if journal.exists() else 0
        process = subprocess.Popen(command, env=environment)
        deadline = time.monotonic() + 120.0
        while process.poll() is None and time.monotonic() < deadline:
            if journal.exists() and journal.stat().st_size > done:
                break
            time.sleep(0.02)
        time.sleep(float(rng.uniform(0.0, 0.3)))
        process.send_signal(signal.SIGKILL)
        process.wait()
    subprocess.run(command, check=True, env=environment)
    whole = tmp_path / "whole"
    options = Options(objects=folder, runs=3, workers=1, strategies=THREE, out=whole)
    table_3_5.run(options).save(whole)
    for name in ("table-3.5.json", "table-3.5.csv", "table-3.5.png", "explorations.jsonl"):
        assert (out / name).read_bytes() == (whole / name).read_bytes()
    assert json.loads((whole / "table-3.5.json").read_text())["settings"]["runs"] == 3
