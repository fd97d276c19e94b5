"""Events in synthesised series with a known fault of the rig, and none where there is none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import f as variance_ratio

from bench import rig_faults as rig
from model_lab.bench.hand_grasp_set import hand_grasp_set
from model_lab.bench.hand_press_set import hand_press_set
from model_lab.bench.synthesize import Synthesised, synthesize
from model_lab.experiments.forward import Forward
from model_lab.rules import RULES
from model_lab.series.events import (
    DRIFT_EVENT,
    ODD_RUN,
    SLOW_COURSE,
    STEP_EVENT,
    Series,
    examine,
    group_of_runs,
)
from model_lab.series.run_scale import run_values, within_groups
from softhand_model.effects import effect_classes

SEVENTH = 6  # index of the first run of the second half
GENTLE = 0.05  # drift of the scale over a series


def examined(data, truth) -> Series:
    """The series of a set under the base model with its true calibration."""
    forward = Forward(data, "pneuflex", (), (), truth["calibration"], False)
    residual = forward.measured - forward.predict(np.zeros((1, 0)))[0]
    return examine(data, residual, truth["noise"])


@pytest.fixture(scope="module")
def made() -> Synthesised:
    return synthesize("free_bending", 2, False)


@pytest.fixture(scope="module")
def rubbing() -> Synthesised:
    """A set that the base model does not explain."""
    return synthesize("uniaxial", 4, True, {"hysteresis": effect_classes()["hysteresis"]})


def test_no_event_in_clean_sets():
    """At a level of 1 % per set, three events or more in 40 sets are a matter of 1 in 150."""
    found = 0
    for seed in range(200, 240):
        clean = synthesize("uniaxial", seed, False)
        found += bool(examined(clean.data, clean.truth).events)
    assert found <= 2


@pytest.mark.parametrize("course", ["rest", "sun", "scatter"])
def test_repeats_that_vary_slowly_are_doubted(made, course):
    """A finger that ages, rests and ages again; a room that warms and cools: no step, no drift."""
    random, order = np.random.default_rng(0), np.arange(12)
    share = {
        "rest": order % 6 / 6.0,
        "sun": np.sin(np.pi * order / 11.0),
        "scatter": random.uniform(0.0, 1.0, 12),
    }
    runs = []
    for number, factor in enumerate(1.0 - 0.06 * share[course]):
        run = made.data.runs[number % 2]
        noise = made.truth["noise"] * random.standard_normal(run.samples)
        angle = factor * run.columns["tip_angle"] + noise
        columns = {**run.columns, "tip_angle": angle}
        runs.append(replace(run, name=f"r{number}", columns=columns))
    found = examined(replace(made.data, runs=tuple(runs)), made.truth)
    assert not found.events
    assert (found.doubted is not None) == (course != "scatter")
    assert course == "scatter" or found.doubted.kind == SLOW_COURSE


def test_scatter_of_runs_is_no_slow_course():
    """At 1 % a set, more than two of 30 are a matter of 1 in 300."""
    doubted = 0
    for seed in range(30):
        clean = synthesize("uniaxial", 500 + seed, False)
        scatter = 1.0 + 0.03 * np.random.default_rng(seed).standard_normal(len(clean.data.runs))
        runs = tuple(
            replace(run, columns={**run.columns, "stress": run.columns["stress"] * factor})
            for run, factor in zip(clean.data.runs, scatter, strict=True)
        )
        found = examined(replace(clean.data, runs=runs), clean.truth).doubted
        doubted += found is not None and found.kind == SLOW_COURSE
    assert doubted <= 2


def test_a_run_at_rest_throughout_is_no_event_and_no_error(made):
    """It has neither scale nor zero, so nothing is said of the others either."""
    runs = list(made.data.runs)
    still = {name: np.zeros_like(runs[0].columns[name]) for name in ("pressure", "tip_angle")}
    runs[0] = replace(runs[0], columns={**runs[0].columns, **still})
    assert not examined(replace(made.data, runs=tuple(runs)), made.truth).events


def six_runs(seed):
    """Three protocols, each measured twice, and the truth of the set."""
    whole = synthesize("free_bending", seed, False)
    runs = (*whole.data.runs[:3], *whole.data.runs[6:9])
    assert [run.protocol for run in runs[:3]] == [run.protocol for run in runs[3:]]
    return replace(whole.data, runs=runs), whole.truth


def test_a_changed_sensor_is_seen_in_six_runs_too():
    """Three differences between repeats prove little alone; that they are large counts as well."""
    steps = alone = false = 0
    for seed in range(300, 312):
        data, truth = six_runs(seed)
        changed = rig.slipped_winding(data, 3, 0.15)
        found = examined(changed, truth)
        steps += any(event.kind in (STEP_EVENT, DRIFT_EVENT) for event in found.events)
        alone += found.p_value <= RULES.event_p_value
        false += bool(examined(data, truth).events)
    assert steps >= 10 and false <= 1
    assert alone < steps


def test_a_drift_that_is_not_sure_is_doubted_and_scatter_is_not():
    """A scale that drifts by less than half a percent a run is not told in each set."""
    told = doubted = false = 0
    for seed in range(400, 412):
        made = synthesize("free_bending", seed, False)
        found = examined(rig.drifting_gain(made.data, GENTLE), made.truth)
        told += bool(found.events)
        doubted += found.doubted is not None
        false += examined(made.data, made.truth).doubted is not None
    assert told >= 4 and doubted >= 3 and told + doubted <= 12
    assert false <= 1


@pytest.mark.parametrize("first", [3, SEVENTH, 9])
def test_a_slipped_winding_is_a_step_at_its_run(made, first):
    data = rig.slipped_winding(made.data, first, 0.09)
    (event,) = examined(data, made.truth).events
    assert (event.kind, event.run) == (STEP_EVENT, data.runs[first].name)
    assert event.before == data.runs[first - 1].name
    assert event.size == pytest.approx(0.09, abs=0.02)


def test_an_error_of_the_model_does_not_hide_a_step(rubbing):
    data = rig.slipped_winding(rubbing.data, SEVENTH, 0.09)
    event = examined(data, rubbing.truth).events[0]
    assert (event.kind, event.run) == (STEP_EVENT, data.runs[SEVENTH].name)
    assert event.size == pytest.approx(0.09, abs=0.02)


def test_a_drift_is_told_from_a_step(made):
    (event,) = examined(rig.drifting_gain(made.data, 0.15), made.truth).events
    assert event.kind == DRIFT_EVENT
    assert event.size == pytest.approx(0.15, abs=0.03)


def test_a_changed_sensor_has_a_scale_and_a_zero(made):
    data = rig.changed_sensor(made.data, SEVENTH, -0.05, 0.1)
    events = examined(data, made.truth).events
    largest = np.abs(made.data.table.value).max()
    assert {(event.kind, event.run) for event in events} == {(STEP_EVENT, data.runs[SEVENTH].name)}
    sizes = {event.quantity: event.size for event in events}
    assert sizes["zero"] == pytest.approx(0.1 * largest, rel=0.2)
    assert sizes["scale"] == pytest.approx(-0.05, abs=0.02)


@pytest.mark.parametrize(
    "factor, column", [(180.0 / np.pi, ""), (1e-3, ""), (1.0 / 6.894757, "pressure")]
)
def test_a_run_in_another_unit_is_odd(made, factor, column):
    data = rig.run_in_other_unit(made.data, 4, factor, column)
    (event,) = examined(data, made.truth).events
    assert (event.kind, event.run, event.other) == (ODD_RUN, data.runs[4].name, data.runs[10].name)


def test_exchanged_runs_are_both_odd(made):
    data = rig.exchanged_plugs(made.data, 2, 3)
    events = examined(data, made.truth).events
    assert [event.kind for event in events] == [ODD_RUN, ODD_RUN]
    assert {event.run for event in events} == {data.runs[2].name, data.runs[3].name}


def test_a_step_of_one_specimen_leaves_the_others(made):
    thick = [index for index, run in enumerate(made.data.runs) if run.specimen == "thick"]
    data = rig.slipped_winding(made.data, SEVENTH, 0.12)
    kept = tuple(
        slipped if index in thick else run
        for index, (run, slipped) in enumerate(zip(made.data.runs, data.runs, strict=True))
    )
    events = examined(replace(data, runs=kept), made.truth).events
    assert [event.pattern.specimen for event in events] == ["thick"]


def test_the_run_with_the_largest_input_is_named(made):
    runs = list(made.data.runs)
    for index in range(SEVENTH):
        columns = dict(runs[index].columns)
        columns["pressure"] = 0.8 * columns["pressure"]
        runs[index] = replace(runs[index], columns=columns)
    data = replace(made.data, runs=tuple(runs))
    (event,) = examined(data, made.truth).events
    assert event.largest == runs[SEVENTH].name


def test_without_repeats_nothing_is_said(made):
    data = replace(made.data, runs=made.data.runs[:SEVENTH])
    assert examined(rig.slipped_winding(data, 3, 0.09), made.truth) == Series(0, 1.0, ())


def test_small_events_are_left_alone(made):
    """A step far below the scatter within a run, in a set whose runs do not scatter at all."""
    forward = Forward(made.data, "pneuflex", (), (), made.truth["calibration"], False)
    predicted = forward.predict(np.zeros((1, 0)))[0]
    step = 1.0 + 1e-4 * (made.data.table.run >= SEVENTH)
    noise = 1e-7 * np.random.default_rng(0).standard_normal(len(predicted))
    measured = predicted * step + noise
    table = replace(made.data.table, value=measured)
    data = replace(made.data)
    data.__dict__["table"] = table
    assert examine(data, measured - predicted, 1e-7).events
    assert not examine(data, measured - predicted, made.truth["noise"]).events


def test_p_value_of_a_single_pattern_is_that_of_the_f_distribution():
    """Six pairs, of which one pattern is tried: the draws reproduce the F distribution."""
    from model_lab.series.events import _p_value

    group = np.repeat(np.arange(6), 2)
    shape = within_groups(np.tile([0.0, 1.0], 6), group)
    shape /= np.linalg.norm(shape)
    share = 0.6
    exact = variance_ratio.sf(share * 5 / (1 - share), 1, 5)
    found = _p_value(share, shape[None], group, np.zeros((0, 0)), 6)
    assert found == pytest.approx(exact, rel=0.1)


def test_scale_and_zero_of_runs(made):
    table = made.data.table
    predicted = np.abs(table.value) + 0.1 * np.linspace(0.0, 1.0, table.samples)
    scaled = run_values(table, 1.2 * predicted, predicted)
    assert scaled[0].values == pytest.approx(np.full(table.runs, np.log(1.2)))
    moved = run_values(table, predicted + 0.3, predicted)
    assert moved[1].values == pytest.approx(np.full(table.runs, 0.3))


def test_repeats_of_a_hand_whose_frames_scatter_are_no_event_whatever_the_model_misses():
    """Places lie far from zero: a line through them to where they would be zero says nothing where
    a finger hardly moves aside, as in the first protocol.
    """
    data, random = synthesize("hand_pose", 3, False, noise=1e-9).data, np.random.default_rng(7)
    table, runs = data.table, len(data.runs)
    turned = 2e-4 * random.standard_normal((runs, len(data.outputs)))[table.run, table.output]
    same = 2e-3 * random.standard_normal((runs, table.samples // runs))[group_of_runs(data)].ravel()
    residual = turned + same + 5e-4 * random.standard_normal(table.samples)
    still = (table.group == 0) & (table.output % 3 == 1)
    value = np.where(still, -0.036 + 1e-4 * table.value, table.value)
    for moved, odd in ((0.0, []), (5e-3, [data.runs[2].name])):
        left = residual + moved * (table.run == 2)
        data.__dict__["table"] = replace(table, value=value + left)
        assert [event.run for event in examine(data, left, 5e-4).events] == odd


@pytest.mark.parametrize("odd", [4, 11])
def test_a_run_that_differs_from_its_repeat_is_odd_in_presses_and_not_in_grasps(odd):
    random, found = np.random.default_rng(5), []
    for empty in (hand_press_set(), hand_grasp_set(random)):
        runs = []
        for number, run in enumerate(empty.runs):
            noise = {name: 0.01 * random.standard_normal(run.samples) for name in empty.outputs}
            noise["wrench.fx"] += 1.0 if number == odd else 0.0
            runs.append(replace(run, columns={**run.columns, **noise}))
        data = replace(empty, runs=tuple(runs))
        events = examine(data, data.table.value, 0.01).events
        found.append({event.run for event in events})
    pressed, grasped = found
    assert data.runs[odd].name in pressed
    assert grasped == set()


def test_two_odd_runs_are_sought_among_repeats_of_one_protocol_alone_too(made):
    """There, none of two runs of different repeats can hide the other."""
    first = made.data.runs[0]
    data = replace(made.data, runs=tuple(replace(first, name=f"r{n}") for n in range(6)))
    assert not np.any(group_of_runs(data))
    residual = made.truth["noise"] * np.random.default_rng(1).standard_normal(data.table.samples)
    assert examine(data, residual, made.truth["noise"]).events == ()
