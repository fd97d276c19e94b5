import pytest

from softhand_trials.sweep.report import summary, wilson


def record(key, outcome="gripped", **more):
    return {"key": key, "outcome": outcome, "versions": {"code": "1"}} | more


def test_wilson_intervals_are_those_of_the_tables():
    assert wilson(8, 10) == pytest.approx((0.4902, 0.9433), abs=1e-4)
    assert wilson(0, 10) == pytest.approx((0.0, 0.2775), abs=1e-4)
    assert wilson(0, 0) == (0.0, 1.0)


def test_a_summary_counts_by_object_and_variant_and_names_the_commonest_failures():
    missed = {"outcome": "none", "cause": "missed", "phase": "close"}
    found = summary(
        [
            record("map/ball/0,0/1"),
            record("map/ball/0,0/2", **missed),
            record("map/ball/10,0/1", **missed),
            {"key": "map/ball/10,0/2", "error": "ValueError: no", "versions": {"code": "1"}},
            record("map/ball/air_scale=0/0,0/1", **missed),
        ]
    )
    assert "map/ball: 1 of 4 gripped (5 to 70 %)" in found
    assert "2 x missed in close" in found and "1 x ValueError: no" in found
    assert "map/ball/air_scale=0: 0 of 1 gripped" in found
    assert "states of the code" not in found


def test_a_summary_says_when_lines_are_of_different_code():
    records = [record("map/ball/0,0/1"), record("map/ball/0,0/2", versions={"code": "2"})]
    assert "run by 2 different states of the code: 1, 2" in summary(records)
