"""Reports of a node: their level and their sentence."""

from softhand_ros.diagnostics import ERROR, OK, WARN, Report


def test_a_report_without_warnings_says_that_all_is_well():
    report = Report("simulation", "running", ("", ""))
    assert (report.level, report.message) == (OK, "running")


def test_warnings_take_the_place_of_what_is_well():
    report = Report("simulation", "running", ("no valves", "", "a second simulator"))
    assert (report.level, report.message) == (WARN, "no valves; a second simulator")


def test_an_error_stands_before_the_warnings():
    report = Report("simulation", "running", ("no valves",), errors=("it has diverged",))
    assert (report.level, report.message) == (ERROR, "it has diverged; no valves")
