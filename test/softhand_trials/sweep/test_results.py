import hashlib
import json
import shutil
from dataclasses import asdict, replace
from pathlib import Path

import pytest

from softhand_trials.sweep import (
    SweepPlan,
    load_plan,
    read_results,
    run_sweep,
    run_tasks,
    trial_task,
)
from softhand_trials.sweep import pool as pool_of_sweep
from softhand_trials.sweep.plan import SweptObject
from softhand_trials.sweep.results import Results
from softhand_trials.trials import TrialSettings

STORED = Path(__file__).parents[1] / "data"


@pytest.fixture
def plan():
    cells = tuple((0.01 * k, 0.0) for k in range(4))
    return SweepPlan("map", TrialSettings(), (SweptObject("marker"),), cells)


@pytest.fixture
def ran(monkeypatch):
    """Keys of the trials that were run, by a stand-in that takes no time."""
    keys = []

    def run(line):
        keys.append(line.key)
        return line.describe() | {"outcome": "gripped"}

    monkeypatch.setattr(pool_of_sweep, "run_task", run)
    return keys


def test_a_finished_sweep_runs_nothing_again(plan, ran, tmp_path):
    first = run_sweep(plan, tmp_path, jobs=0)
    assert ran == [line.key for line in plan.tasks()] == [record["key"] for record in first]
    assert run_sweep(plan, tmp_path, jobs=0) == first
    assert len(ran) == 4


def test_a_torn_last_line_is_dropped_and_its_trial_done_again(plan, ran, tmp_path):
    run_sweep(plan, tmp_path, jobs=0)
    path = tmp_path / "results.jsonl"
    whole = path.read_bytes()
    path.write_bytes(whole[:-7])
    run_sweep(plan, tmp_path, jobs=0)
    assert path.read_bytes() == whole
    assert ran[4:] == ["map/marker/30,0/1"]


def test_more_cells_are_added_to_the_results_there_are(plan, ran, tmp_path):
    run_sweep(replace(plan, cells=plan.cells[:2]), tmp_path, jobs=0)
    run_sweep(plan, tmp_path, jobs=0)
    assert sorted(ran) == sorted(record["key"] for record in read_results(tmp_path))
    assert len(ran) == 4


@pytest.mark.parametrize(
    "changed",
    [
        {"settings": TrialSettings(step=0.005)},
        {"seed": 1},
        {"cells": ((0.0, 0.0),)},
        {"name": "other"},
    ],
)
def test_results_of_a_plan_that_has_changed_are_refused(plan, ran, tmp_path, changed):
    run_sweep(plan, tmp_path, jobs=0)
    before = (tmp_path / "results.jsonl").read_bytes()
    with pytest.raises(ValueError, match=r"results\.jsonl: expected results of this plan, got one"):
        run_sweep(replace(plan, **changed), tmp_path, jobs=0)
    assert (tmp_path / "results.jsonl").read_bytes() == before


def test_a_strategy_whose_file_has_changed_is_another_plan(plan, ran, tmp_path, write_strategy):
    path = write_strategy()
    plan = replace(plan, settings=TrialSettings(strategy=str(path)))
    first = plan.tasks()[0].digest
    path = write_strategy(("speed: 0.2", "speed: 0.3"))
    from softhand_trials.sweep import trial_task

    trial_task._files.cache_clear()
    assert plan.tasks()[0].digest != first


def test_a_strategy_of_the_same_text_in_another_folder_is_the_same_plan(
    plan, tmp_path, write_strategy
):
    path = write_strategy()
    other = tmp_path / "elsewhere" / path.name
    other.parent.mkdir()
    other.write_bytes(path.read_bytes())
    plans = [replace(plan, settings=TrialSettings(strategy=str(place))) for place in (path, other)]
    first, second = (plan.tasks()[0].digest for plan in plans)
    assert first == second


def test_two_sweeps_do_not_write_to_the_same_results(plan, tmp_path):
    with (
        Results(tmp_path, plan.tasks()),
        pytest.raises(ValueError, match="wait until that run ends"),
    ):
        Results(tmp_path, plan.tasks())


def test_a_damaged_line_within_is_refused_with_its_number(plan, ran, tmp_path):
    run_sweep(plan, tmp_path, jobs=0)
    path = tmp_path / "results.jsonl"
    lines = path.read_text().splitlines()
    path.write_text("\n".join([lines[0], lines[1][:-5], *lines[2:]]) + "\n")
    with pytest.raises(ValueError, match=r"results\.jsonl:2: expected JSON, got"):
        run_sweep(plan, tmp_path, jobs=0)


def test_a_line_tells_settings_placement_and_digest(plan, ran, tmp_path):
    record = json.loads(json.dumps(run_sweep(plan, tmp_path, jobs=0)[1]))
    line = plan.tasks()[1]
    again = TrialSettings(**record["settings"])
    assert again == line.settings
    assert record["digest"] == line.digest and record["cell"] == [0.01, 0.0]
    assert tuple(record["placement"]["offset"]) == line.placement.offset


def test_a_setting_that_came_later_leaves_digests_of_before_as_they_were(plan):
    line = plan.tasks()[0]
    later = ("finger_contact", "rubber_friction_scale", "engine")
    settings = {k: v for k, v in asdict(line.settings).items() if k not in later}
    plain = {"settings": settings, "placement": asdict(line.placement)}
    text = json.dumps(plain, sort_keys=True) + trial_task._files(line.settings)
    assert line.digest == hashlib.sha256(text.encode()).hexdigest()[:16]
    touching = replace(line, settings=replace(line.settings, finger_contact=True))
    assert touching.digest != line.digest


def test_results_that_an_earlier_version_wrote_are_those_of_the_same_plan(ran, tmp_path):
    """Written when the settings of a trial were one flat list of names."""
    tasks = load_plan(STORED / "sweep.yaml").tasks()
    shutil.copy(STORED / "results.jsonl", tmp_path)
    with Results(tmp_path, tasks) as results:
        assert [results.records[task.key]["digest"] for task in tasks] == [t.digest for t in tasks]
        assert results.left(tasks) == []
    run_tasks(tasks, tmp_path, jobs=0)
    assert ran == []


def test_trials_that_an_earlier_version_wrote_are_read_with_their_settings_and_places():
    tasks = {task.key: task for task in load_plan(STORED / "sweep.yaml").tasks()}
    for record in read_results(STORED):
        settings, placement = trial_task.trial_of(record)
        task = tasks[record["key"]]
        files = {name: Path(getattr(task.settings, name)).name for name in ("strategy", "friction")}
        assert settings == replace(task.settings, **files)
        assert placement == task.placement
