"""The bench of grasps without its long runs."""

import time
from collections import Counter
from types import SimpleNamespace

import pytest
from made_up_sweep import lines_gripped

from bench.grasps import maps, over_ros, verdicts
from bench.grasps.steps import COUNT, SIDES, at_step, beside, scattered
from bench.grasps.table_grasps import OBJECTS, strategy_for
from bench.groups import groups, main
from bench.kept import Unfinished
from thesis.__main__ import main as thesis_main
from thesis.chapter_8 import map_evidence, object_map


def test_every_object_on_the_table_has_a_strategy_of_the_hand():
    assert [strategy_for(name) for name in OBJECTS] == [
        "surface_constrained",
        "rbo_hand_2_lying_cylinder",
        "rbo_hand_2_lying_cylinder",
        "rbo_hand_2_ball",
    ]
    with pytest.raises(ValueError, match="tissue: expected a strategy of rbo_hand_2"):
        strategy_for("tissue")


@pytest.fixture
def kept_here(monkeypatch, tmp_path):
    """A working directory of its own."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_scattered_trials_are_of_all_three_maps_and_drawn_by_the_seed(kept_here):
    lines = scattered(3)
    assert len({line.key for line in lines}) == COUNT
    counts = Counter(line.key.split("/")[0] for line in lines)
    assert set(counts) == {"push_map", "surface_map", "edge_map"}
    assert max(counts.values()) - min(counts.values()) <= 1
    assert lines == scattered(3) != scattered(4)
    assert {line.object for line in lines}.isdisjoint({"water_balloon", "tissue"})


def test_maps_that_are_not_made_are_rows_and_so_is_what_they_lack(kept_here, monkeypatch):
    rows = maps.run()
    assert [row["name"] for row in rows] == [
        f"{name}: not made, python -m thesis run {name}" for name in maps.MAPS
    ]
    assert not any(row["met"] for row in rows)
    monkeypatch.setattr(object_map, "run_tasks", lines_gripped)
    monkeypatch.setattr(map_evidence, "run_tasks", lines_gripped)
    cell = ["--x", "0", "0.02", "--y", "0", "0.02", "--pitch", "0.02", "--replicates", "1"]
    thesis_main(["run", "push_map", *cell, "--objects", "cylinder", "--checks", "no_air"])
    found = {row["name"]: row["met"] for row in maps.run()}
    assert found["push_map: negative control: 0 kPa: 4 successes of 4 (0)"] is False
    assert found["push_map: largest hole: 0 cells, cylinder (<= 2)"] is True
    assert found["push_map: checks: other_step was not run"] is False
    assert found["push_map: objects: marker was not run"] is False


def test_the_help_tells_how_long_each_row_takes(capsys):
    with pytest.raises(SystemExit):
        main("grasps", "", {}, ["--help"])
    told = capsys.readouterr().out.partition("rows:")[2].split("\n  ")[1:]
    assert [line.split()[0] for line in told] == groups("grasps")
    assert all(line.rstrip().endswith(")") for line in told)


def test_a_trial_beside_another_differs_in_its_place_alone(kept_here):
    line = scattered(0, 1)[0]
    moved = beside(line, SIDES[2])
    assert moved.settings == line.settings and moved.key != line.key
    shift = [b - a for a, b in zip(line.placement.offset, moved.placement.offset, strict=True)]
    assert shift == pytest.approx([0.0, 0.003])
    assert at_step(line, 0.001).placement == line.placement


def test_verdicts_stop_when_their_time_is_over_and_go_on_from_those_of_before(
    kept_here, monkeypatch
):
    ran = []

    def run(lines, folder, jobs):
        ran.append((len(lines), folder.parent))
        return lines_gripped(lines, folder, jobs)

    monkeypatch.setattr(verdicts, "run_tasks", run)
    monkeypatch.setattr(verdicts, "PART", 3)
    lines = scattered(0, 8)
    times = iter([0.0, 0.0, 2.0])
    with monkeypatch.context() as clock:
        clock.setattr(verdicts, "time", SimpleNamespace(monotonic=lambda: next(times)))
        with pytest.raises(Unfinished, match="some: 2 of 8 trials are left"):
            verdicts.gripped("some", lines, 1, 1.0)
    assert ran == [(3, verdicts.OUT), (6, verdicts.OUT)]
    found = verdicts.gripped("some", lines, 1, time.monotonic() + 60)
    assert found == {line.key: True for line in lines}
    assert ran[2:] == [(6, verdicts.OUT), (8, verdicts.OUT)]
    assert verdicts.gripped("some", lines, 1, time.monotonic() - 1) == found
    verdicts.gripped("some", scattered(1, 8), 1, time.monotonic() + 60)


def test_a_trial_without_a_verdict_is_not_taken_for_a_failed_grasp(kept_here, monkeypatch):
    raised = [{"key": "push_map/cup/0,0/0", "error": "ValueError: no"}]
    monkeypatch.setattr(verdicts, "run_tasks", lambda *_: raised)
    with pytest.raises(RuntimeError, match=r"1 trials without verdict: push_map/cup/0,0/0"):
        verdicts.gripped("some", scattered(0, 1), 1, time.monotonic() + 60)


def test_grasps_over_ros_are_counted_both_ways_and_made_once(kept_here, monkeypatch):
    made = []

    def way(name, lifts):
        def grasp(strategy, options):
            made.append((name, strategy, options.seed))
            outcome = "gripped" if lifts(strategy, options.seed) else "lost"
            return {"outcome": outcome, "reason": "so"}

        return grasp

    ways = {
        "in process": way("in", lambda *_: True),
        "over ROS": way("over", lambda strategy, seed: seed != 1),
    }
    monkeypatch.setattr(over_ros, "WAYS", ways)
    names = ("surface_constrained", "rbo_hand_1_push")
    rows = over_ros.run(0, minutes=1, seeds=2, many=4, names=names)
    assert len(made) == len(set(made)) == 2 * (2 * 2 + 2)
    assert [row["value"] for row in rows] == [2, 1, 2, 1, 50, 75]
    assert over_ros.run(0, minutes=0, seeds=2, many=4, names=names) == rows
    assert len(made) == 12
    with pytest.raises(Unfinished, match="4 of 16 grasps are left"):
        over_ros.run(0, minutes=-1, seeds=3, many=5, names=names)
    assert len((kept_here / over_ros.LINES).read_text().splitlines()) == 12


def test_a_grasp_over_ros_begins_in_the_world_of_its_strategy():
    options = over_ros.options_of("rbo_hand_2_slide_to_wall", 3)
    assert (options.scene, options.wall_inclination, options.object) == (
        "wall",
        60,
        "thin_cylinder",
    )
    assert options.await_commander and options.seed == 3
    again = over_ros.options_of("rbo_hand_2_slide_to_wall", 4)
    assert again.object_offset != options.object_offset
