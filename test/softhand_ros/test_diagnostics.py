"""Reports of a node: their level and their sentence."""

from softhand_ros.diagnostics import OK, WARN, Report


def test_a_report_without_warnings_says_that_all_is_well():
    report = Report("simulation", "running", ("", ""))
    assert (report.level, report.message) == (OK, "running")


def test_warnings_take_the_place_of_what_is_well():
    report = Report("simulation", "running", ("no valves", "", "a second simulator"))
    assert (report.level, report.message) == (WARN, "no valves; a second simulator")
