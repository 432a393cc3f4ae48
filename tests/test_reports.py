import csv
import json

from vh_drake.reports import Report, csv_text


def test_a_report_is_saved_as_json_and_csv(tmp_path):
    report = Report("table-0", {"seed": 1}, {"x_mm": 2.5}, {"x_mm": 3.0}, [{"object": "a, b"}])
    report.save(tmp_path)
    content = json.loads((tmp_path / "table-0.json").read_text())
    assert content["name"] == "table-0"
    assert content["settings"]["seed"] == 1
    assert "drake" in content["settings"]["versions"]
    assert content["summary"] == {"x_mm": 2.5}
    assert content["thesis"] == {"x_mm": 3.0}
    with (tmp_path / "table-0.csv").open(newline="") as file:
        assert list(csv.DictReader(file)) == [{"object": "a, b"}]


def test_columns_are_the_keys_of_all_rows():
    assert csv_text([{"a": 1}, {"a": 2, "b": 3}]) == "a,b\n1,\n2,3\n"


def test_a_report_without_rows_has_no_csv(tmp_path):
    Report("table-0", {}, {"x": 1}).save(tmp_path)
    assert not (tmp_path / "table-0.csv").exists()
