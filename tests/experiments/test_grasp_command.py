import pytest

from vh_drake.errors import BadInput, TooLarge, UnknownName
from vh_drake.experiments import grasp_command, grasp_trial
from vh_drake.experiments.grasp_command import grasp_and_report
from vh_drake.experiments.grasp_trial import TrialResult, load_trial_object
from vh_drake.scenes.scenario import Scenario

STAGE = {"simulated_s": 1.0, "wall_s": 2.0}


def done(*, lifted: bool, warnings: tuple[str, ...] = ()) -> TrialResult:
    result: dict[str, object] = {
        "object": "can",
        "seed": 0,
        "touches": [],
        "surface_error_mm": None,
        "attempts": [{}],
        "lifted": lifted,
        "height_m": 0.15,
        "hold_s": 3.0,
        "slip_mm": 0.1,
        "slip_deg": 0.2,
        "failure": "",
        "grasp": {},
    }
    return TrialResult(result, {"stages": {"look": STAGE}, **STAGE}, warnings)


@pytest.mark.parametrize(
    "scenario", [Scenario(object="mugg"), Scenario(hand="armar7"), Scenario(hand="nowhere.yaml")]
)
def test_bad_input_shows_before_a_page_is_served_or_a_folder_made(scenario, tmp_path, monkeypatch):
    served = []
    monkeypatch.setattr(grasp_command, "make_meshcat", served.append)
    with pytest.raises(BadInput):
        grasp_and_report(scenario, tmp_path / "out", host="localhost", record=True, as_json=False)
    assert not served
    assert not list(tmp_path.iterdir())


def test_the_object_is_loaded_once(monkeypatch, tmp_path):
    loaded, given = [], []

    def load(scenario):
        loaded.append(scenario.object)
        return load_trial_object(scenario)

    def run(_, model, **__):
        given.append(model.name)
        return done(lifted=True)

    monkeypatch.setattr(grasp_command, "load_trial_object", load)
    monkeypatch.setattr(grasp_command, "run_trial", run)
    assert grasp_and_report(
        Scenario(object="can"), tmp_path, host=None, record=False, as_json=False
    )
    assert loaded == given == ["can"]


@pytest.mark.parametrize("lifted", [True, False])
def test_a_warning_leaves_the_outcome_of_the_trial(lifted, monkeypatch, tmp_path, capsys):
    outcome = done(lifted=lifted, warnings=("the recording has 31 MB",))
    monkeypatch.setattr(grasp_command, "run_trial", lambda *_, **__: outcome)
    report = grasp_and_report(
        Scenario(object="can"), tmp_path, host=None, record=False, as_json=False
    )
    assert report == lifted
    assert "vh-drake: warning: the recording has 31 MB\n" in capsys.readouterr().err


def test_a_recording_that_is_too_large_becomes_a_warning(monkeypatch, tmp_path):
    def refuse(*_):
        raise TooLarge("too large by far")

    monkeypatch.setattr(grasp_trial, "write_recording", refuse)
    warnings = grasp_trial._write_recording(object(), tmp_path / "recording.html")
    assert warnings == ("too large by far",)
    assert grasp_trial._write_recording(None, tmp_path / "recording.html") == ()


def test_an_unknown_hand_is_named_with_the_choices():
    with pytest.raises(UnknownName, match="armar6_right"):
        load_trial_object(Scenario(hand="armar7"))
