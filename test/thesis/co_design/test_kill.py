"""A killed worker and a killed search lose no finished trial, and the end is the same."""

import json
import os
import signal
import subprocess
import sys

import made_up_designs
import psutil
from killed_sweep import await_results, workers

from grasp_strategies.sweep import read_results


def start(folder, notes):
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, made_up_designs.__file__, str(folder), str(notes)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment)


def test_killed_workers_and_a_killed_search_lose_no_finished_trial(tmp_path):
    folder, notes = tmp_path / "out", tmp_path / "notes"
    running = start(folder, notes)
    await_results(folder, 3)
    workers(running)[0].send_signal(signal.SIGKILL)
    await_results(folder, 25)
    left = workers(running)
    running.kill()
    running.communicate()
    assert psutil.wait_procs(left, timeout=20)[1] == [], "a worker has outlived its search"
    before = (folder / "results.jsonl").read_bytes()
    finished = before[: before.rfind(b"\n") + 1]
    again = start(folder, notes)
    output, _ = again.communicate(timeout=90)
    assert again.returncode == 0
    assert (folder / "results.jsonl").read_bytes().startswith(finished)
    records = read_results(folder)
    assert len({record["key"] for record in records}) == len(records) == made_up_designs.PLAN.budget
    # run more than once is only what a killed worker or search was at, and had no line
    assert len(records) <= len(notes.read_text().splitlines()) <= len(records) + 3
    undisturbed = made_up_designs.search(tmp_path / "other")
    assert json.loads(output) == [one.score for one in undisturbed]
