"""The bench of robustness without nodes: its groups, its options, its messages."""

import itertools
import json
import random
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

from bench.groups import groups, main
from bench.kept import Unfinished
from bench.robust.__main__ import OPTIONS
from bench.robust.faults import cases
from bench.robust.long_work import rows_of
from bench.robust.messages import hostile, long_named, message_type, messages
from bench.robust.rig import RigError, Usage
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


def test_the_page_of_measured_faults_has_every_fault_of_the_bench():
    page = (Path(__file__).parents[2] / "docs/understand/fault-times.md").read_text()
    assert [case.fault for case in cases() if f"| {case.fault} |" not in page] == []


class Nodes:
    """In place of a rig: nodes that grow by a share at every grasp, and what a grasp comes to."""

    def __init__(self, share, *outcomes):
        self.share, self.outcomes, self.done = share, outcomes, 0
        self.nodes = {"driver": None, "hand": None}
        self.running = list(self.nodes)

    def alive(self):
        return self.running

    def usage(self):
        return {name: Usage(50.0 * (1 + self.share * self.done), 20, 5) for name in self.running}

    def grasp(self):
        self.done += 1
        outcome = self.outcomes[self.done - 1]
        if outcome == "ends":
            self.running = ["driver"]
        if isinstance(outcome, BaseException):
            raise outcome
        return SimpleNamespace(success=outcome != "slips", message="it slipped")

    def begin_anew(self):
        pass

    def tell_ended(self):
        pass


@pytest.mark.parametrize(
    ("share", "outcomes", "missed"),
    [
        (0.001, ["grips", "grips", KeyboardInterrupt()], []),
        (0.03, ["grips", KeyboardInterrupt()], ["memory that grew"]),
        (0.0, ["grips", "slips", KeyboardInterrupt()], ["that failed"]),
        (0.0, ["grips", RigError("no answer")], ["that failed"]),
        (0.0, ["ends"], ["nodes that ended"]),
        (0.0, [KeyboardInterrupt()], ["one after the other"]),
    ],
)
def test_long_work_that_ends_early_has_rows_of_the_time_until_then(share, outcomes, missed):
    rows = rows_of(Nodes(share, *outcomes), 60.0)
    found = [row["name"] for row in rows if not row["met"]]
    assert len(found) == len(missed)
    assert all(word in what for word, what in zip(missed, found, strict=True))


def test_long_work_says_every_minute_what_each_node_holds(monkeypatch, capsys):
    clock = SimpleNamespace(monotonic=itertools.count(0.0, 30.0).__next__)
    monkeypatch.setattr("bench.robust.long_work.time", clock)
    rows_of(Nodes(0.01, *["grips"] * 9), 3.0)
    first = capsys.readouterr().out.splitlines()[0]
    assert "1.0 min: 1 grasps, 0 failed; driver 50.5 MB (+1.00 %), hand 50.5 MB (+1.00 %)" in first
