"""The bench of robustness without nodes: its groups, its options, its messages."""

import json
import random
import sys
from pathlib import Path
from types import ModuleType

import pytest

from bench.groups import groups, main
from bench.kept import Unfinished
from bench.robust.__main__ import OPTIONS
from bench.robust.faults import cases
from bench.robust.messages import hostile, long_named, message_type, messages
from bench.row import at_most

HEARD = [
    "diagnostic_msgs/msg/DiagnosticArray",
    "geometry_msgs/msg/PoseStamped",
    "geometry_msgs/msg/WrenchStamped",
    "rosgraph_msgs/msg/Clock",
    "sensor_msgs/msg/JointState",
    "trajectory_msgs/msg/JointTrajectory",
    "visualization_msgs/msg/MarkerArray",
]


def test_every_group_of_the_folder_takes_part():
    assert {"messages", "calls", "faults", "two_hands", "long_work"} <= set(groups("robust"))
    assert {"maps", "table_grasps", "steps", "rate", "early_end"} <= set(groups("grasps"))


def test_a_group_gets_those_of_the_options_that_it_takes(monkeypatch, tmp_path, capsys):
    group = ModuleType("bench.robust.calls")
    group.run = lambda seed: [at_most("seed", seed, "", 3)]
    monkeypatch.setitem(sys.modules, "bench.robust.calls", group)
    monkeypatch.chdir(tmp_path)
    words = ["--rows", "calls", "--seed", "3", "--minutes", "60"]
    assert main("robust", "Attack.", OPTIONS, words) == 0
    assert "bench: minutes 60, seed 3" in capsys.readouterr().out
    (row,) = json.loads((tmp_path / "out/bench/bench-robust.json").read_text())
    assert row["value"] == 3.0 and row["met"]


def test_the_rows_of_other_groups_stay_in_the_file(monkeypatch, tmp_path, capsys):
    monkeypatch.chdir(tmp_path)
    values = {"calls": 3.0, "messages": 4.0}
    for name in values:
        group = ModuleType(f"bench.robust.{name}")
        group.run = lambda name=name: [at_most(name, values[name], "", 3)]
        monkeypatch.setitem(sys.modules, f"bench.robust.{name}", group)
    main("robust", "Attack.", OPTIONS, ["--rows", "calls", "messages"])
    values["calls"] = 1.0
    main("robust", "Attack.", OPTIONS, ["--rows", "calls"])
    rows = json.loads((tmp_path / "out/bench/bench-robust.json").read_text())
    assert {row["group"]: row["value"] for row in rows} == {"calls": 1.0, "messages": 4.0}
    assert all(row["measured"] for row in rows)


def test_a_group_whose_time_is_over_says_how_to_go_on(monkeypatch, tmp_path, capsys):
    def run():
        raise Unfinished("3 of 4 are left")

    group = ModuleType("bench.robust.calls")
    group.run = run
    monkeypatch.setitem(sys.modules, "bench.robust.calls", group)
    monkeypatch.chdir(tmp_path)
    assert main("robust", "Attack.", OPTIONS, ["--rows", "calls"]) == 1
    error = capsys.readouterr().err
    assert "calls is not finished, start it again to go on: 3 of 4 are left" in error
    assert "Traceback" not in error


@pytest.mark.parametrize("name", HEARD)
def test_hostile_messages_are_of_their_type_and_drawn_by_the_seed(name):
    kind = message_type(name)
    drawn = [list(messages(kind, random.Random(7), 50)) for _ in range(2)]
    assert all(isinstance(message, kind) for message in drawn[0])
    assert str(drawn[0]) == str(drawn[1])
    assert len({str(message) for message in drawn[0]}) > 15


def test_numbers_of_a_message_are_now_and_then_none():
    kind = message_type("geometry_msgs/msg/PoseStamped")
    places = [hostile(kind, random.Random(k)).pose.position.x for k in range(100)]
    assert any(place != place for place in places) and any(abs(p) == 1e308 for p in places)


def test_one_message_of_a_type_with_names_has_a_name_of_ten_million_characters():
    assert len(long_named(message_type("sensor_msgs/msg/JointState")).name[0]) == 10_000_000
    pose = long_named(message_type("geometry_msgs/msg/PoseStamped"))
    assert len(pose.header.frame_id) == 10_000_000
    assert long_named(message_type("rosgraph_msgs/msg/Clock")) is None


def test_the_page_on_safety_has_every_fault_of_the_bench():
    page = (Path(__file__).parents[2] / "docs/use/safety.md").read_text()
    assert [case.fault for case in cases() if f"| {case.fault} |" not in page] == []
