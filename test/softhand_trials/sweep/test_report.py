import pytest

from softhand_trials.sweep.report import agreements, summary, wilson


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


def in_engines(trial, *outcomes):
    """Records of a trial by PyBullet, the first engine of a map, and by MuJoCo beside it."""
    pybullet, mujoco = outcomes
    other = {"settings": {"engine": "mujoco"}}
    return [
        record(f"map/ball/{trial}", pybullet, settings={}),
        record(f"map/ball/engine=mujoco/{trial}", mujoco, **other),
    ]


def test_engines_are_compared_trial_by_trial():
    records = in_engines("0,0/1", "gripped", "gripped") + in_engines("0,0/2", "none", "gripped")
    records += in_engines("10,0/1", "gripped", "none") + in_engines("10,0/2", "none", "none")
    (found,) = agreements(records)
    assert found.name == "map/ball"
    assert found.gripped == {"pybullet": 2, "mujoco": 2}
    assert found.same == 2  # though both grip as often
    assert found.differing == {"0,0/2": ["mujoco"], "10,0/1": ["pybullet"]}
    assert "map/ball, engines: gripped pybullet 2, mujoco 2 of 4; same" in summary(records)


def test_a_trial_without_a_verdict_in_one_engine_is_not_compared_and_the_reason_is_told():
    records = in_engines("0,0/1", "gripped", "gripped") + in_engines("0,0/2", "none", "none")
    records[-1] = {key: records[-1][key] for key in ("key", "settings")} | {"error": "too soft"}
    (found,) = agreements(records[:-1])
    assert (len(found.verdicts), found.refusal) == (1, "")
    (found,) = agreements(records)
    assert (len(found.verdicts), found.refusal) == (1, "mujoco: too soft")
    assert found.text.endswith("same verdict 1 of 1; not compared: mujoco: too soft")


def test_results_of_one_engine_have_nothing_to_compare():
    assert agreements(in_engines("0,0/1", "gripped", "none")[:1]) == []
    assert "engines" not in summary([record("map/ball/0,0/1")])
