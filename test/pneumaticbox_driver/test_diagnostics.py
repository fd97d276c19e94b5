"""What the box tells about itself, by level."""

import numpy as np
from bottle_rig import BottleRig

from pneumaticbox_driver.diagnostics import LinkState, box_reports
from pneumaticbox_driver.note_throttle import NoteThrottle
from pneumaticbox_driver.report import Level

MG = 1e-6
SEEN = {"sensors_seen": True}


def reports(rig, **link):
    return {report.name: report for report in box_reports(rig.box, LinkState(**link))}


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
    assert told.level == Level.WARN and "/clock stands still" in told.message
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
    box = BottleRig().started().box
    link.refuse("x/command: old", 90.0)
    link.refuse("x/command: points[0]", 100.0)
    link.forget_refused(109.9)
    assert link.refused == "x/command: points[0]"
    link.forget_refused(110.1)
    report = {report.name: report for report in box_reports(box, link)}["commands"]
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
