"""What is said of made-up trials of a map in two engines and at a fine step."""

from dataclasses import replace

import numpy as np
import pytest
from made_up_sweep import lines_gripped

from softhand_trials.sweep.success_map import SuccessMap
from thesis.chapter_8 import map_evidence, object_map, push_map
from thesis.chapter_8.map_evidence import FINE, differing_cells, drawn, evidence_findings
from thesis.frame import Job, save_figure

GIVEN = push_map.Parameters(
    x=(0.0, 0.02),
    y=(0.0, 0.02),
    pitch=0.02,
    objects=("cylinder", "marker"),
    checks=("no_air",),
    fine=3,
    engines=("pybullet", "mujoco"),
)


@pytest.fixture
def made_up(monkeypatch):
    """Runs of a map whose trials all succeed, but for two of MuJoCo: the first is lost, the second
    refused; and at 1 ms PyBullet loses the first.
    """

    def ran(lines, folder, jobs, name):
        assert {line.settings.engine for line in lines} == {name.split(", ")[1]}
        records = lines_gripped(lines, folder, jobs)
        if not name.startswith("1 ms"):
            records[0] |= {"outcome": "none", "cause": "missed"}
            del records[1]["outcome"]
            records[1]["error"] = "soft"
            return records
        assert {line.settings.step for line in lines} == {FINE}
        if name.endswith("pybullet"):
            records[0] |= {"outcome": "none", "cause": "slipped in the lift"}
        return records

    monkeypatch.setattr(object_map, "run_tasks", lines_gripped)
    monkeypatch.setattr(map_evidence, "run_tasks", ran)


def rows(results):
    return {found.what: found for found in evidence_findings(results, GIVEN.step)}


def test_agreement_of_engines_and_steps_is_counted_by_trial_and_drawn(made_up, tmp_path):
    results = push_map.run(GIVEN, Job(tmp_path, lambda what, share: None))
    found = rows(results)
    cylinder = found["engines, push_map/cylinder"].ours
    assert cylinder.startswith("gripped pybullet 7, mujoco 6 of 7; same verdict 6 of 7; differ: ")
    assert cylinder.endswith("0,0/0 (pybullet); not compared: mujoco: soft")
    assert found["verdicts that two engines share"].ours.startswith("14 of 15, 93 % ")
    assert found["verdicts that two engines share"].met is True
    assert found["verdicts as at 1 ms, pybullet at 2 ms"].ours.startswith("5 of 6, 83 % ")
    assert found["verdicts as at 1 ms, pybullet at 2 ms"].met is False
    assert found["verdicts as at 1 ms, mujoco at 2 ms"].met in (True, False)
    assert differing_cells(results) == {"cylinder": [(0.0, 0.0)], "marker": []}
    # of an object that an engine refuses in a trial it has no map
    assert list(results["sweeps"]["main_mujoco"]) == ["marker"]
    report = push_map.report(results, GIVEN)
    save_figure(push_map, results, report, tmp_path / "map.png")
    assert (tmp_path / "map.png").stat().st_size > 5000


def test_a_sample_is_of_the_same_trials_in_both_engines_and_in_checks(made_up, tmp_path):
    given = replace(GIVEN, sample=3, fine=2, replicates=0)
    results = push_map.run(given, Job(tmp_path, lambda what, share: None))
    found = rows(results)
    assert found["verdicts that two engines share"].ours.startswith("4 of 5, 80 % ")
    # the first drawn trial of MuJoCo fails, the second has no verdict
    assert results["sweeps"]["main_mujoco"].keys() == {"marker"}
    cells = object_map.cells_of(results, "main_mujoco", "marker")[0]
    assert np.isnan(cells).sum() == 1 and np.nansum(cells) == 3
    assert not np.isnan(object_map.cells_of(results, object_map.MAIN, "marker")[0]).any()
    assert {row["engine"]: row["trials"] for row in results["steps"]}["pybullet"] == 4
    report = push_map.report(results, given)
    words = {row.what: row.ours for row in report.findings}
    assert words["negative control: 0 kPa"] == "6 successes of 6 (0)"
    assert words["cylinder"].startswith("4 of 4 cells, share 1.00 ")
    save_figure(push_map, results, report, tmp_path / "map.png")
    with pytest.raises(ValueError, match="expected no other_jitter without jittered trials"):
        replace(given, checks=("other_jitter",))


def test_random_trials_follow_the_seed_and_are_of_the_map():
    plan = object_map.map_plan("push_map", "rbo_hand_1_push", GIVEN)
    one = replace(plan, objects=plan.objects[1:])
    every = plan.tasks()
    lines = drawn(every, 5, seed=1)
    assert len(lines) == 10 and lines == drawn(every, 5, seed=1) != drawn(every, 5, seed=2)
    assert [line for line in lines if line.object == "marker"] == drawn(one.tasks(), 5, seed=1)
    assert {line.key for line in lines} <= {line.key for line in every}
    assert len(drawn(every, 10_000, seed=1)) == len(every)


def test_failures_are_told_with_the_cells_where_they_happen():
    records = [
        {"object": "tube", "cell": [x, 0.0], "replicate": 0, "outcome": held, "cause": cause}
        for x, held, cause in [
            (0.0, "gripped", ""),
            (0.02, "none", "missed"),
            (0.04, "none", "missed"),
        ]
    ]
    found = object_map.tally(records, "tube", ((0.06, 0.0), (0.0, 0.0), (0.02, 0.0), (0.04, 0.0)))
    assert found["failed"] == {"missed": [(0.02, 0.0), (0.04, 0.0)]}
    assert found["replicates"] == {"0": [1, 0, 0, None]}
    cells = np.ones((2, 1), bool)
    made = SuccessMap(np.array([0.0, 0.02]), np.array([0.0]), cells, cells[None])
    assert object_map.about("tube", made, found["failed"])[1].ours == (
        "missed 2 (x 25 to 35, y 0 to 0 mm)"
    )


def test_a_map_of_one_engine_has_no_row_of_agreement(made_up, tmp_path):
    alone = replace(GIVEN, engines=("pybullet",), fine=0)
    results = push_map.run(alone, Job(tmp_path, lambda what, share: None))
    assert not any("engines share" in what or "1 ms" in what for what in rows(results))
