"""A killed worker, and a killed sweep, lose no finished line and do none twice."""

import multiprocessing
import os

import pytest
from killed_sweep import killed_and_run_again

from softhand_trials.sweep import SweepPlan, TrialTask, load_plan, run_tasks
from softhand_trials.sweep.plan import SweptObject
from softhand_trials.sweep.pool import ATTEMPTS, Processes
from softhand_trials.trials import TrialSettings

WAIT = """
format: softhand-strategy/1
name: wait
description: the hand goes up and waits
hand: single_finger
phases:
  - name: approach
    wrist: {frame: object, position: [0, 0, 0.3]}
    duration: 0.5
  - name: hold
    duration: 2.0
"""
PLAN = """
format: softhand-sweep/1
name: kill
strategy: test_grasp.yaml
objects: [cylinder]
step: 0.005
segments: 3
grid: {{x: [0, 0.{last:02d}, 0.01], y: [0, 0, 0.01]}}
"""


@pytest.fixture
def plan_file(write_strategy, tmp_path):
    write_strategy(text=WAIT)

    def write(last):
        path = tmp_path / "plan.yaml"
        path.write_text(PLAN.format(last=last))
        return path

    return write


def test_killed_workers_and_a_killed_sweep_lose_no_line_and_do_none_twice(plan_file, tmp_path):
    path, folder = plan_file(40), tmp_path / "out"
    words = [path, "--out", folder, "--jobs", "2"]
    _, records = killed_and_run_again(["-m", "softhand_trials.sweep.command", *words], folder, 12)
    assert {record["key"] for record in records} == {line.key for line in load_plan(path).tasks()}
    assert not any("error" in record for record in records)


class Deadly(TrialTask):
    """A trial that ends the process that runs it."""

    def describe(self):
        if os.getpid() != self.home:
            os._exit(9)
        return super().describe()

    @property
    def home(self):
        return int(os.environ["SWEEP_HOME"])


def test_a_worker_that_was_lost_between_two_lists_is_replaced():
    plan = SweepPlan("bad", TrialSettings(step=7.0), (SweptObject("marker"),), ((0, 0), (1, 0)))
    with Processes(1) as workers:
        first = list(workers.run(plan.tasks()))
        (worker,) = multiprocessing.active_children()
        worker.kill()
        worker.join()
        second = list(workers.run(plan.tasks()))
    assert [r["error"] for r in second] == [r["error"] for r in first] != []


def test_a_trial_that_kills_every_worker_is_a_line_with_that_error(tmp_path, monkeypatch):
    monkeypatch.setenv("SWEEP_HOME", str(os.getpid()))
    plan = SweepPlan("bad", TrialSettings(step=7.0), (SweptObject("marker"),), ((0, 0), (1, 0)))
    usual, other = plan.tasks()
    deadly = Deadly(**vars(other))
    first, second = run_tasks([usual, deadly], tmp_path, jobs=1)
    assert first["error"] == "ValueError: step: expected 0.0001 to 0.05 s, got 7.0"
    assert second["error"] == f"its worker was lost {ATTEMPTS} times"
