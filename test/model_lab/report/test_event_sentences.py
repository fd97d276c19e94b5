"""What happened in a series, in sentences: one for each thing that happened."""

from model_lab.measurements.units import Display
from model_lab.report.event_sentences import event_sentences


def step(quantity, size, p_value, run="r7"):
    about = {"kind": "step", "run": run, "before": "r6", "specimen": None}
    return {**about, "quantity": quantity, "size": size, "p_value": p_value}


def test_a_step_that_changes_scale_and_zero_is_told_once():
    events = [step("scale", 0.09, 2e-6), step("zero", -1.5, 1e-3)]
    (said,) = event_sentences(events, [], Display("deg"))
    assert said.startswith(
        "Repeats before and after run r7 do not agree (+9 % and -1.5 deg, p 2e-06)"
    )


def test_steps_at_two_runs_are_told_apart():
    events = [step("scale", 0.09, 2e-6), step("scale", 0.05, 1e-3, run="r9")]
    assert [
        ("r7" in said, "r9" in said) for said in event_sentences(events, [], Display("deg"))
    ] == [
        (True, False),
        (False, True),
    ]
