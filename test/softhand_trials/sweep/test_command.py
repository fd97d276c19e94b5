from softhand_trials.sweep import read_results
from softhand_trials.sweep.command import main

PLAN = """
format: softhand-sweep/1
name: two
strategy: test_grasp.yaml
objects: [marker]
step: 0.01
segments: 2
cells: [[0, 0], [0.02, 0]]
"""
QUICK = """
format: softhand-strategy/1
name: quick
description: goes up
hand: single_finger
phases:
  - name: hold
    duration: 0.05
"""


def test_a_plan_is_run_and_summed_up_and_can_be_listed_before(write_strategy, tmp_path, capsys):
    write_strategy(text=QUICK)
    plan = tmp_path / "plan.yaml"
    plan.write_text(PLAN)
    out = ["--out", str(tmp_path / "out"), "--jobs", "0"]
    assert main([str(plan), *out, "--dry"]) == 0
    assert capsys.readouterr().out.splitlines() == ["two/marker/0,0/1", "two/marker/20,0/1"]
    assert main([str(plan), *out]) == 0
    assert "two/marker: 0 of 2 gripped" in capsys.readouterr().out
    records = read_results(tmp_path / "out")
    assert [record["outcome"] for record in records] == ["none", "none"]
    assert records[0]["versions"]["code"] and records[0]["cpu_time"] > 0


def test_what_cannot_be_run_is_said_in_one_line(write_strategy, tmp_path, capsys):
    plan = tmp_path / "plan.yaml"
    plan.write_text(PLAN.replace("strategy: test_grasp.yaml", "strategy: []"))
    assert main([str(plan)]) == 2
    error = capsys.readouterr().err.strip()
    assert error.startswith("softhand-sweep: ") and "strategy: expected text" in error
    plan.write_text(PLAN)
    assert main([str(plan), "--jobs", "-1"]) == 2
    assert "jobs: expected 0 or more, got -1" in capsys.readouterr().err


def test_a_plan_runs_in_two_engines_and_their_verdicts_are_compared(
    write_strategy, tmp_path, capsys
):
    write_strategy(text=QUICK)
    plan = tmp_path / "plan.yaml"
    plan.write_text(PLAN)
    out = ["--out", str(tmp_path / "out"), "--jobs", "0", "--engines", "pybullet,mujoco"]
    assert main([str(plan), *out]) == 0
    told = "two/marker, engines: gripped pybullet 0, mujoco 0 of 2; same verdict 2 of 2"
    assert told in capsys.readouterr().out
    engines = [r["settings"].get("engine", "pybullet") for r in read_results(tmp_path / "out")]
    assert engines == ["pybullet", "pybullet", "mujoco", "mujoco"]
    assert main([str(plan), "--engines", "pybullet,bullet"]) == 2
    assert "engine: expected one of pybullet, mujoco, got 'bullet'" in capsys.readouterr().err
