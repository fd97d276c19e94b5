"""A killed worker, and a killed sweep, lose no finished line and do none twice."""

import os
import signal
import subprocess
import sys

import psutil
import pytest
from killed_sweep import await_results, workers

from grasp_strategies.sweep import SweepPlan, TrialLine, load_plan, read_results, run_lines
from grasp_strategies.sweep.plan import SweptObject
from grasp_strategies.sweep.pool import MOST_LOSSES
from grasp_strategies.trials import TrialSettings

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


def start(plan_file, folder):
    words = [str(plan_file), "--out", str(folder), "--jobs", "2"]
    command = [sys.executable, "-m", "grasp_strategies.sweep.command", *words]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def test_killed_workers_and_a_killed_sweep_lose_no_line_and_do_none_twice(plan_file, tmp_path):
    path, folder = plan_file(40), tmp_path / "out"
    sweep = start(path, folder)
    await_results(folder, 3)
    workers(sweep)[0].send_signal(signal.SIGKILL)
    await_results(folder, 12)
    left = workers(sweep)
    sweep.kill()
    sweep.communicate()
    assert psutil.wait_procs(left, timeout=20)[1] == [], "a worker has outlived its sweep"
    before = (folder / "results.jsonl").read_bytes()
    finished = before[: before.rfind(b"\n") + 1]
    again = start(path, folder)
    _, errors = again.communicate(timeout=60)
    assert again.returncode == 0, errors
    assert (folder / "results.jsonl").read_bytes().startswith(finished)
    records = read_results(folder)
    assert sorted(r["key"] for r in records) == sorted(ln.key for ln in load_plan(path).lines())
    assert not any("error" in record for record in records)


class Deadly(TrialLine):
    """A trial that ends the process that runs it."""

    def describe(self):
        if os.getpid() != self.home:
            os._exit(9)
        return super().describe()

    @property
    def home(self):
        return int(os.environ["SWEEP_HOME"])


def test_a_trial_that_kills_every_worker_is_a_line_with_that_error(tmp_path, monkeypatch):
    monkeypatch.setenv("SWEEP_HOME", str(os.getpid()))
    plan = SweepPlan("bad", TrialSettings(step=7.0), (SweptObject("marker"),), ((0, 0), (1, 0)))
    usual, other = plan.lines()
    deadly = Deadly(**vars(other))
    first, second = run_lines([usual, deadly], tmp_path, jobs=1)
    assert first["error"] == "ValueError: step: expected 0.0001 to 0.05 s, got 7.0"
    assert second["error"] == f"its worker was lost {MOST_LOSSES} times"
