from vh_drake.benches import pipeline
from vh_drake.benches.pipeline import CONTACTS, OBJECTS, summarized
from vh_drake.catalog import Options
from vh_drake.experiments.grasp_trial import TrialResult


def row(kind, contact, wall_s, factor):
    return {
        "kind": kind,
        "contact": contact,
        "wall_s": wall_s,
        "real_time_factor": factor,
        "real_time_factor_processor": 1.1 * factor,
    }


def test_the_slower_kind_counts_by_its_best_run():
    rows = [row(k, c, 50.0, 1.0) for k in OBJECTS for c in CONTACTS]
    rows += [row("primitive", "point", 20.0, 4.0), row("mesh", "point", 30.0, 3.0)]
    rows += [row("mesh", "hydroelastic", 70.0, 0.4)]
    summary = summarized(rows)
    assert summary["wall_s"] == 50.0
    assert summary["real_time_factor"] == 1.0
    assert summary["point_wall_s"] == 30.0
    assert summary["point_real_time_factor"] == 3.0
    assert summary["point_real_time_factor_primitive"] == 4.0


def test_every_object_meets_every_contact_model(monkeypatch, tmp_path):
    seen = []

    def trial(kind, contact, seed):
        seen.append((kind, contact, seed))
        return row(kind, contact, 10.0, 2.0)

    monkeypatch.setattr(pipeline, "trial_row", trial)
    monkeypatch.setattr(pipeline, "rating_time", lambda seed: {"rate_800_s": 1.0})
    summary = pipeline.run(Options(runs=2, seed=4, out=tmp_path)).summary
    assert set(seen) == {(k, c, s) for k in OBJECTS for c in CONTACTS for s in (4, 5)}
    assert summary["rate_800_s"] == 1.0


def test_a_row_tells_a_trial_s_times_by_stage(monkeypatch):
    seen = []

    def trial(scenario):
        seen.append(scenario)
        stages = {"look": {"wall_s": 1.0, "processor_s": 0.5, "simulated_s": 0.1}}
        timing = {"wall_s": 2.0, "real_time_factor": 3.0, "stages": stages}
        return TrialResult({"lifted": True}, timing)

    monkeypatch.setattr(pipeline, "run_trial", trial)
    told = pipeline.trial_row("mesh", "point", 7)
    assert (seen[0].object, seen[0].contact, seen[0].seed) == (OBJECTS["mesh"], "point", 7)
    assert (told["lifted"], told["wall_s"], told["look_processor_s"]) == (True, 2.0, 0.5)
