"""A Dask cluster of two processes on this machine runs what the pool runs."""

import os
import signal
import subprocess
import sys
from dataclasses import replace

import psutil
import pytest
from distributed import LocalCluster

from softhand_trials.search import SearchProblem, Variable, run_search
from softhand_trials.sweep import SweepPlan, cluster, read_results, run_sweep
from softhand_trials.sweep.plan import SweptObject
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
TIMES = ("wall_time", "cpu_time", "versions")


@pytest.fixture
def plan(write_strategy):
    settings = TrialSettings(strategy=str(write_strategy(text=WAIT)), step=0.005, segments=3)
    cells = tuple((0.01 * k, 0.0) for k in range(20))
    return SweepPlan("map", settings, (SweptObject("cylinder"), SweptObject("ball")), cells)


@pytest.fixture(scope="module")
def local():
    with LocalCluster(2, threads_per_worker=1, dashboard_address=None, host="127.0.0.1") as local:
        yield local


def without_times(record):
    return {key: value for key, value in record.items() if key not in TIMES}


def test_the_cluster_of_these_tests_listens_on_loopback_alone(local):
    sockets = psutil.Process().net_connections()
    assert {one.laddr.ip for one in sockets if one.status == psutil.CONN_LISTEN} == {"127.0.0.1"}


def test_a_cluster_gives_what_one_process_gives_and_a_killed_worker_costs_nothing(
    plan, local, tmp_path, monkeypatch
):
    results, killed = cluster._results, []

    def kill_one(client, lines):
        """A worker, in the midst of the sweep."""
        for record in results(client, lines):
            if not killed:
                killed.append(local.workers[0].pid)
                os.kill(killed[0], signal.SIGKILL)
            yield record

    monkeypatch.setattr(cluster, "_results", kill_one)
    records = run_sweep(plan, tmp_path / "dask", scheduler=local.scheduler_address)
    assert len(killed) == 1
    written = [record["key"] for record in read_results(tmp_path / "dask")]
    assert sorted(written) == sorted(line.key for line in plan.tasks())
    few = replace(plan, cells=plan.cells[:3])
    alone = run_sweep(few, tmp_path / "alone", jobs=0)
    by_key = {record["key"]: record for record in records}
    for record in alone:
        assert without_times(by_key[record["key"]]) == without_times(record)


def test_a_lost_scheduler_ends_the_sweep_with_a_sentence_and_it_goes_on_later(
    plan, tmp_path, monkeypatch
):
    start = [sys.executable, "-m", "distributed.cli.dask_scheduler"]
    scheduler = subprocess.Popen(
        [*start, "--host", "127.0.0.1", "--port", "0", "--dashboard-address", "127.0.0.1:0"],
        stderr=subprocess.PIPE,
        text=True,
    )
    address = next(line.split()[-1] for line in scheduler.stderr if "Scheduler at:" in line)
    worker = subprocess.Popen(
        [sys.executable, "-m", "distributed.cli.dask_worker", address, "--nthreads", "1"]
        + ["--host", "127.0.0.1", "--dashboard-address", "127.0.0.1:0", "--no-nanny"],
        stderr=subprocess.DEVNULL,
    )
    results, done = cluster._results, []

    def kill_scheduler(client, lines):
        for record in results(client, lines):
            done.append(record["key"])
            if len(done) == 10:
                scheduler.kill()
            yield record

    monkeypatch.setattr(cluster, "_results", kill_scheduler)
    try:
        with pytest.raises(ConnectionError, match="scheduler"):
            run_sweep(plan, tmp_path, scheduler=address)
    finally:
        for process in (worker, scheduler):
            process.kill()
            process.wait()
            process.stderr and process.stderr.close()
    before = read_results(tmp_path)
    assert 10 <= len(before) < 40
    records = run_sweep(replace(plan), tmp_path, jobs=1)
    assert [record["key"] for record in records] == [line.key for line in plan.tasks()]
    assert read_results(tmp_path)[: len(before)] == before
    assert len(read_results(tmp_path)) == 40


def test_a_scheduler_that_is_not_there_is_said(plan, tmp_path, monkeypatch):
    monkeypatch.setattr(cluster, "TIME_OUT", 0.5)
    with pytest.raises(ConnectionError, match="tcp://127.0.0.1:9: expected a Dask scheduler"):
        run_sweep(plan, tmp_path, scheduler="tcp://127.0.0.1:9")


def test_batches_are_of_one_hand_and_scene_and_enough_for_all_workers(plan):
    lines = plan.tasks()
    parts = cluster.batches(lines, 2)
    assert [line for part in parts for line in part] == lines
    assert all(len({line.settings for line in part}) == 1 for part in parts)
    assert len(parts) >= 8 and max(map(len, parts)) == 5
    assert max(map(len, cluster.batches(lines * 50, 2))) == cluster.LARGEST_BATCH


def test_a_search_on_a_cluster_evaluates_what_it_does_here(local, tmp_path):
    problem = SearchProblem(
        "bowl",
        "search_objectives:bowl",
        (Variable("x", -1.0, 1.0), Variable("y", -1.0, 1.0)),
        evaluations=20,
        allow_any=True,
    )
    alone = run_search(problem, tmp_path / "alone", jobs=0)
    there = run_search(problem, tmp_path / "dask", scheduler=local.scheduler_address)
    pairs = zip(there.records, alone.records, strict=True)
    assert all(a["values"] == b["values"] and a["cost"] == b["cost"] for a, b in pairs)
    assert there.records[0]["process"] != alone.records[0]["process"]
