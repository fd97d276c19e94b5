"""What the box tells about itself, by level."""

from bottle_rig import BottleRig

from pneumaticbox_driver.diagnostics import LinkState, box_reports
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


def test_a_channel_held_at_its_limit_says_so():
    rig = BottleRig(limit=20e3).started()
    rig.command(90 * MG, 0.0)
    rig.run(3.0)
    report = reports(rig, **SEEN)["channel a"]
    assert report.level == Level.WARN and "pressure limit" in report.message
    assert report.values["valve"] == "closed"
