"""What the box tells about itself, by level."""

import numpy as np
from bottle_rig import BottleRig

from pneumaticbox_driver.box.commands import TrajectoryPoint
from pneumaticbox_driver.box.diagnostics import (
    CommandTraffic,
    Level,
    LinkState,
    NoteThrottle,
    ValveActivity,
    box_reports,
)

MG = 1e-6
SEEN = {"sensors_seen": True}


def reports(rig, activity=None, **link):
    activity = activity or ValveActivity(len(rig.names))
    found = box_reports(rig.box, LinkState(**link), activity)
    return {report.name: report for report in found}


def test_all_is_well_in_operation():
    found = reports(BottleRig().started(), **SEEN)
    assert {report.level for report in found.values()} == {Level.OK}
    assert set(found) == {"sensors", "safety", "commands", "channel a", "channel b"}


def test_missing_samples_are_told():
    report = reports(BottleRig())["sensors"]
    assert (report.level, report.message) == (Level.WARN, "no sensor sample has come yet")


def test_a_clock_that_stands_is_told_unless_the_simulation_is_paused():
    rig = BottleRig().started()
    told = reports(rig, **SEEN, clock_stands=6.0)["sensors"]
    assert told.level == Level.WARN and "/clock does not advance" in told.message
    assert reports(rig, **SEEN, clock_stands=6.0, paused=True)["sensors"].level == Level.OK


def test_a_latched_vent_is_an_error_with_its_reasons():
    rig = BottleRig().started()
    rig.box.vent()
    report = reports(rig, **SEEN)["safety"]
    assert report.level == Level.ERROR
    assert report.message == "vented until pneumaticbox/reset: vent was requested"


def test_a_refused_message_is_named_and_counted():
    report = reports(BottleRig().started(), refused="x/command: points[0]", refusals=3)["commands"]
    assert report.level == Level.WARN and "x/command: points[0]" in report.message
    assert report.values["refused messages"] == "3"


def test_a_refused_message_is_forgotten_after_ten_seconds_but_stays_counted():
    link = LinkState(**SEEN)
    rig = BottleRig().started()
    link.refuse("x/command: old", 90.0)
    link.refuse("x/command: points[0]", 100.0)
    link.forget_refused(109.9)
    assert link.refused == "x/command: points[0]"
    link.forget_refused(110.1)
    report = reports(rig, **vars(link))["commands"]
    assert (report.level, report.values["refused messages"]) == (Level.OK, "2")


def test_two_simulators_and_a_clock_that_is_ignored_are_told():
    rig = BottleRig().started()
    report = reports(rig, **SEEN, simulators=2, clock_warning="use_sim_time is ignored")["sensors"]
    assert report.level == Level.WARN
    assert "two simulators publish pneumaticbox/sensors: stop one" in report.message
    assert "use_sim_time is ignored" in report.message


def test_a_note_that_comes_all_the_time_is_logged_every_five_seconds():
    throttle = NoteThrottle()
    seconds = np.arange(0.0, 20.0, 0.5)
    logged = [t for t in seconds if "set back" in throttle.due(["set back"] * 280, t)]
    assert logged == [0.0, 5.0, 10.0, 15.0]
    assert throttle.due(["set back", "another"], 19.9) == ["another"]


def test_a_channel_held_at_its_limit_says_so():
    rig = BottleRig(limit=20e3).started()
    rig.command(90 * MG, 0.0)
    rig.run(3.0)
    report = reports(rig, **SEEN)["channel a"]
    assert report.level == Level.WARN and "pressure limit" in report.message
    assert report.values["valve"] == "closed"


def test_two_commanders_and_a_storm_of_commands_are_told():
    rig = BottleRig().started()
    traffic = CommandTraffic(taken=1159, lost=8841, commanders=2)
    report = reports(rig, **SEEN, traffic=traffic, storm=39000.0)["commands"]
    assert report.level == Level.WARN
    assert "two nodes command the box" in report.message
    assert "command storm: 39000 messages a second" in report.message
    assert (report.values["messages"], report.values["lost messages"]) == ("1159", "8841")


def test_a_valve_that_chatters_is_told_and_one_that_fills_a_bottle_is_not():
    rig = BottleRig().started()
    rig.command(20 * MG, 0.0)
    activity = ValveActivity(2)
    for second in range(11):
        activity.note(float(second), np.array([second // 2, 9 * second]))
    found = reports(rig, activity, **SEEN)
    assert found["channel a"].level == Level.OK
    assert found["channel b"].level == Level.WARN
    assert found["channel b"].message == "valve chatters: opened 90 times within 10 s"
    assert found["channel b"].values["openings within 10 s"] == "90"


def test_each_channel_tells_its_mode_and_counts_its_openings():
    rig = BottleRig().started()
    rig.box.set_modes(("mass", "time"))
    rig.box.command("a", [TrajectoryPoint(0.0, positions=[20 * MG])], 0.0, rig.box.time)
    rig.run(1.0)
    found = reports(rig, **SEEN)
    assert [found[f"channel {name}"].values["mode"] for name in "ab"] == ["mass", "time"]
    assert found["channel a"].values["openings"] == str(rig.openings[0]) != "0"
    assert found["channel b"].values["openings"] == "0"


def test_outlets_that_do_not_open_are_told_with_what_to_do():
    rig = BottleRig().started()
    rig.box.faults.stuck_outlets = lambda: ["channel a: shut off the supply"]
    report = reports(rig, **SEEN)["safety"]
    assert (report.level, report.message) == (Level.ERROR, "channel a: shut off the supply")
