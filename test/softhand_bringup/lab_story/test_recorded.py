"""From a session's bag to a measurement set: what counts, and that the lab reads it right."""

import numpy as np
import pytest
import recorded_run
from scipy.integrate import trapezoid

from model_lab.experiments.forward import Forward
from model_lab.measurements.load import load_measurements
from softhand_bringup.lab_story.measuring import (
    ANGLES,
    FINGER,
    RESIDUAL,
    STATE_NAME,
    PlayedRun,
    finger,
)
from softhand_bringup.lab_story.recorded import (
    ANGLE_SPACING,
    STILL_TIME,
    live_residual,
    spaced,
    still_stamps,
    write_set,
)

SECOND = 10**9
START = 100.0  # [s]; a bench that has run for a while
STEPS = ((1.0, 20e3), (3.0, 8e3))  # [s] after the start and [Pa]; each takes RISE
RISE, END = 0.2, 5.0
RUN = PlayedRun("r_1", "r", START, START + END)


def pressure(time):
    at, value = [0.0], [0.0]
    for begin, level in STEPS:
        at += [begin, begin + RISE]
        value += [value[-1], level]
    return np.interp(time - START, at, value)


@pytest.fixture
def bag(tmp_path):
    """A finger that obeys the base model exactly, but swings after each step; a constant residual
    where the pressure stands, a huge one elsewhere.
    """
    rng, actuator, messages = np.random.default_rng(1), finger(), []
    for index in range(int(END / 0.005) + 1):
        t = round(START + 0.005 * index, 6)
        noise = rng.normal(0.0, 60.0)
        messages.append(
            (STATE_NAME, t, recorded_run.joint_state(t, ["a"], effort=[pressure(t) + noise]))
        )
        if index % 4 == 0:
            swinging = any(begin - 0.01 < t - START < begin + RISE + 0.15 for begin, _ in STEPS)
            angle = float(actuator.tip_angle(pressure(t))) + 0.5 * swinging
            messages.append((ANGLES, t, recorded_run.joint_state(t, [FINGER], [angle])))
            residual = 3.0 if swinging else 0.02
            messages.append((RESIDUAL, t, recorded_run.joint_state(t, [FINGER], [residual])))
    return recorded_run.write_bag(tmp_path / "bag", messages)


def distance(stamp):
    """Time [s] from a stamp to the nearest change of pressure, or to an end of the recording."""
    t = stamp / SECOND - START
    spans = [(begin, begin + RISE) for begin, _ in STEPS]
    return min(t, END - t, *(max(begin - t, t - end) for begin, end in spans))


def test_a_stamp_is_still_when_the_pressure_stands_before_and_after_it(bag):
    still = still_stamps(bag)
    every = [round((START + 0.02 * k) * SECOND) for k in range(int(END / 0.02) + 1)]
    assert set(still) <= set(every)
    margin = 0.04  # a rise begins within the band
    for stamp in every:
        if distance(stamp) > STILL_TIME / SECOND + 0.001:
            assert stamp in still
        elif distance(stamp) < STILL_TIME / SECOND - margin:
            assert stamp not in still


def test_kept_stamps_lie_apart(bag):
    kept = spaced(still_stamps(bag))
    assert np.diff(kept).min() == ANGLE_SPACING
    assert kept[0] == still_stamps(bag)[0]


def test_the_residual_counts_where_the_pressure_stands_in_a_run(bag):
    still = still_stamps(bag)
    assert live_residual(bag, [RUN], still) == pytest.approx(0.02)
    with pytest.raises(ValueError, match="residuals where the pressure is constant, got none"):
        live_residual(bag, [PlayedRun("later", "later", START + END, START + 2 * END)], still)


def test_the_lab_finds_the_finger_as_the_model_has_it(bag, tmp_path):
    write_set(tmp_path / "set", bag, [RUN], still_stamps(bag), finger())
    data = load_measurements(tmp_path / "set")
    (run,) = data.runs
    assert run.protocol == "r"
    assert run.samples == len(spaced(still_stamps(bag)))
    forward = Forward(data, free_calibration=False)
    residual = forward.measured - forward.predict(np.zeros((1, 0)))[0]
    # noise of 60 Pa is 0.004 rad at a finger's 0.06 rad/kPa; swinging would show 0.5 rad
    assert np.sqrt(np.mean(residual**2)) < 0.006
    assert abs(np.mean(residual)) < 0.002


def test_lines_between_the_samples_hold_the_pressure_over_time_that_there_was(bag, tmp_path):
    write_set(tmp_path / "set", bag, [RUN], still_stamps(bag), finger())
    columns = load_measurements(tmp_path / "set").runs[0].columns
    first = spaced(still_stamps(bag))[0] / SECOND
    fine = first + np.arange(0.0, columns["time"][-1], 0.001)
    true = trapezoid(pressure(fine), fine)
    assert trapezoid(columns["pressure"], columns["time"]) == pytest.approx(true, rel=0.01)


def test_runs_become_bags_of_their_own(bag, tmp_path):
    halves = [
        PlayedRun("up_1", "up", START, START + 2.5),
        PlayedRun("down_1", "down", START + 2.5, START + END),
    ]
    write_set(tmp_path / "set", bag, halves, still_stamps(bag), finger())
    up, down = load_measurements(tmp_path / "set").runs
    assert up.columns["pressure"][0] == pytest.approx(0.0, abs=250.0)
    assert up.columns["pressure"][-1] == pytest.approx(20e3, abs=250.0)
    assert down.columns["pressure"][0] == pytest.approx(20e3, abs=250.0)
    assert down.columns["pressure"][-1] == pytest.approx(8e3, abs=250.0)
    assert up.columns["time"][-1] < 2.5


def test_a_bag_without_a_finger_is_refused(tmp_path):
    folder = recorded_run.write_bag(tmp_path / "bag", [(STATE_NAME, "sensor_msgs/msg/JointState")])
    with pytest.raises(ValueError, match="expected messages on /pneumaticbox/state"):
        still_stamps(folder)


def test_where_the_pressure_was_not_recorded_nothing_is_still(tmp_path):
    times = [START + 0.005 * k for k in range(500) if not 200 <= k < 300]
    messages = [(STATE_NAME, t, recorded_run.joint_state(t, ["a"], effort=[0.0])) for t in times]
    angles = [START + t for t in (0.5, 0.9, 1.2, 1.6, 2.0)]  # the gap is from 1.0 to 1.5
    messages += [(ANGLES, t, recorded_run.joint_state(t, [FINGER], [0.0])) for t in angles]
    still = still_stamps(recorded_run.write_bag(tmp_path / "bag", messages))
    assert [round(stamp / SECOND - START, 3) for stamp in still] == [0.5, 2.0]
