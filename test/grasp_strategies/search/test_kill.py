"""A killed worker and a killed search lose no finished evaluation and repeat none."""

import os
import signal
import subprocess
import sys

import psutil
from killed_sweep import await_results, workers

from grasp_strategies.search import load_problem, run_search
from grasp_strategies.sweep import read_results

PROBLEM = """
format: softhand-search/1
name: bowl
objective: search_objectives:bowl
variables: {{x: [-1, 1], y: [-5, 5]}}
sampler: cma
evaluations: 64
settings: {{wait: 0.02, runs: {runs}}}
"""


def start(path, folder):
    words = [str(path), "--out", str(folder), "--jobs", "2", "--allow-objectives"]
    command = [sys.executable, "-m", "grasp_strategies.search.command", *words]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    return subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment
    )


def test_killed_workers_and_a_killed_search_lose_nothing_and_the_end_is_the_same(tmp_path):
    path, folder, runs = tmp_path / "problem.yaml", tmp_path / "out", tmp_path / "runs"
    runs.mkdir()
    path.write_text(PROBLEM.format(runs=runs))
    search = start(path, folder)
    await_results(folder, 3)
    workers(search)[0].send_signal(signal.SIGKILL)
    await_results(folder, 20)
    left = workers(search)
    search.kill()
    search.communicate()
    assert psutil.wait_procs(left, timeout=20)[1] == [], "a worker has outlived its search"
    before = (folder / "results.jsonl").read_bytes()
    finished = before[: before.rfind(b"\n") + 1]
    again = start(path, folder)
    output, errors = again.communicate(timeout=90)
    assert again.returncode == 0, errors
    assert "64 evaluations" in output
    assert (folder / "results.jsonl").read_bytes().startswith(finished)
    records = read_results(folder)
    assert len({record["key"] for record in records}) == len(records) == 64
    # run more than once is only what a killed worker or search was at, and had no line
    assert 64 <= len((runs / "notes").read_text().splitlines()) <= 64 + 3
    undisturbed = run_search(load_problem(path, allow_any=True), tmp_path / "other", jobs=0)
    values = {record["key"]: record["values"] for record in records}
    assert values == {record["key"]: record["values"] for record in undisturbed.records}
