"""The report of a sweep on results whose figures are known."""

import json

import pytest

from softhand_trials.sweep.command import main
from softhand_trials.sweep.report_files import write_report

PNG = b"\x89PNG"


def line(name, x, y, number, outcome="gripped", **more):
    key = f"{name}/{1e3 * x:g},{1e3 * y:g}/{number}"
    record = {"key": key, "cell": [x, y], "replicate": number, "outcome": outcome}
    return record | {"versions": {"code": "1"}, "cpu_time": 0.5} | more


@pytest.fixture
def results(tmp_path):
    """Four cells of a grid, of which two succeed, and one trial of another object."""
    missed = {"outcome": "none", "cause": "missed", "phase": "close"}
    records = [line("map/ball", 0.01 * x, 0.01 * y, 1) for x in (0, 1) for y in (0, 1)]
    records[2] = line("map/ball", 0.01, 0.0, 1, error="RuntimeError: no")
    records += [line("map/ball", 0.01, 0.0, 1, **missed), line("map/cup", 0, 0, 1, **missed)]
    records[3] |= missed
    (tmp_path / "results.jsonl").write_text("".join(json.dumps(r) + "\n" for r in records))
    return tmp_path


def test_a_report_has_shares_failures_and_maps_as_tables_pictures_and_json(results):
    files = write_report(results)
    assert [file.name for file in files] == ["report.md", "report.json", "shares.png", "maps.png"]
    assert all((results / name).read_bytes()[:4] == PNG for name in ("shares.png", "maps.png"))
    page = (results / "report.md").read_text()
    assert "| map/ball | 4 | 2 | 0.50 | 0.15 to 0.85 | missed in close 2 |" in page
    assert "| map/ball | 2.0 | 8 | 0, 5 | 1.00 | 0 | 0.00 | no |" in page
    assert "| map/cup | 1 | 0 | 0.00 |" in page
    document = json.loads((results / "report.json").read_text())
    ball, cup = document["groups"]
    assert document["format"] == "softhand-sweep-report/1"
    assert (document["trials"], document["errors"], document["cpu_time"]) == (5, 0, 2.5)
    assert ball["gripped"] == 2 and ball["failures"] == {"missed in close": 2}
    assert ball["map"]["share"] == [[1, 1], [0, 0]]
    assert ball["map"]["area"] == pytest.approx(2e-4)
    assert cup["map"] is None and cup["share"] == 0.0


def test_a_sweep_without_a_grid_has_a_report_without_maps(results, tmp_path):
    (tmp_path / "one").mkdir()
    (tmp_path / "one/results.jsonl").write_text(json.dumps(line("map/cup", 0, 0, 1)) + "\n")
    files = write_report(tmp_path / "one", tmp_path / "new")
    assert [file.name for file in files] == ["report.md", "report.json", "shares.png"]
    assert "## Maps" not in (tmp_path / "new/report.md").read_text()


def test_a_report_has_the_means_of_the_contacts_of_what_was_held(tmp_path):
    found = {"points": 12, "links": 6, "parts": 4, "area": 2e-4, "redundancy": 20, "margin": 0.1}
    loose = {"points": 8, "links": 4, "parts": 3, "area": 1e-4, "redundancy": 10, "margin": 0.0}
    records = [line("map/cup", 0, 0, k, contacts=c) for k, c in enumerate([found, loose, None])]
    (tmp_path / "results.jsonl").write_text("".join(json.dumps(r) + "\n" for r in records))
    write_report(tmp_path)
    page = (tmp_path / "report.md").read_text()
    assert "| map/cup | 10.0 | 5.0 | 3.5 | 1.5 | 15.0 | 0.50 | 0.050 |" in page
    (group,) = json.loads((tmp_path / "report.json").read_text())["groups"]
    assert group["contacts"]["links"] == 5.0 and group["contacts"]["force_closed"] == 0.5


def test_a_report_on_lost_objects_has_no_contacts(results):
    write_report(results)
    assert "Contacts" not in (results / "report.md").read_text()
    document = json.loads((results / "report.json").read_text())
    assert all(group["contacts"] is None for group in document["groups"])


def test_the_command_reports_a_folder_and_overwrites_only_when_asked(results, capsys):
    assert main(["report", str(results)]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == str(results / "maps.png")
    assert main(["report", str(results)]) == 2
    assert "expected a new file" in capsys.readouterr().err
    assert main(["report", str(results), "--force"]) == 0
    assert main(["report", str(results / "nowhere")]) == 2
    assert "expected results of a sweep" in capsys.readouterr().err


def test_a_report_on_two_engines_has_a_table_of_their_verdicts(tmp_path):
    other = {"settings": {"engine": "mujoco"}}
    records = [line("map/cup", 0.01 * x, 0, 1) for x in (0, 1)]
    records += [line("map/cup/engine=mujoco", 0, 0, 1, **other)]
    records += [line("map/cup/engine=mujoco", 0.01, 0, 1, "none", **other)]
    (tmp_path / "results.jsonl").write_text("".join(json.dumps(r) + "\n" for r in records))
    write_report(tmp_path)
    assert "| map/cup | 2 | 2 | 1 | 1 | 10,0/1: pybullet |" in (tmp_path / "report.md").read_text()
    (found,) = json.loads((tmp_path / "report.json").read_text())["engines"]
    assert found["same"] == 1 and found["differing"] == {"10,0/1": ["pybullet"]}
