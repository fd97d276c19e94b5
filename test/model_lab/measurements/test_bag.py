"""Runs from rosbag2 folders: fields by path, times by stamps, inputs at the output's stamps."""

from dataclasses import replace

import numpy as np
import pytest
import recorded_run as record
from measurement_folder import SPECIMEN, document, write_set
from rosbags.rosbag2 import StoragePlugin

from model_lab.experiments.forward import Forward
from model_lab.measurements.bags.fields import MessageField
from model_lab.measurements.load import load_measurements
from model_lab.measurements.measurement_set import MeasurementSet, Run, Specimen
from softhand_common.documents.yaml_document import DocumentError
from softhand_model.effects.elastic_memory import MullinsSoftening
from softhand_model.effects.input import ClockOffset

TOPICS = {
    "pressure": {"topic": "/pneumaticbox/state", "field": "effort[a]"},
    "tip_angle": {"topic": "/hand/tip_angles", "field": "position[p10]"},
}


def _load(folder, topics=None, **changes):
    runs = {"r1": {"specimen": "f", "bag": "r1", "topics": topics or TOPICS}}
    return load_measurements(write_set(folder, document(runs=runs, **changes), {})).runs[0].columns


def _ramp():
    """Pressure every 10 ms, 1 kPa/s; angle 3 ms later every 20 ms, 0.1 rad/s."""
    times, start = np.arange(0.0, 2.001, 0.01), 5.0
    messages = []
    for seconds in times:
        state = record.joint_state(start + seconds, ["b", "a"], effort=[7.0, 1000.0 * seconds])
        messages.append(("/pneumaticbox/state", seconds, state))
    for seconds in times[::2] + 0.003:
        angles = record.joint_state(start + seconds, ["p10"], position=[0.1 * seconds])
        messages.append(("/hand/tip_angles", seconds, angles))
    return messages


@pytest.mark.parametrize("storage", [StoragePlugin.MCAP, StoragePlugin.SQLITE3])
def test_inputs_are_interpolated_at_the_stamps_of_the_output(tmp_path, storage):
    record.write_bag(tmp_path / "r1", _ramp(), storage)
    columns = _load(tmp_path)
    assert len(columns["time"]) == 100  # the last angle lies behind the last pressure
    np.testing.assert_allclose(columns["time"], 0.02 * np.arange(100), atol=1e-9)
    np.testing.assert_allclose(columns["tip_angle"], 0.1 * (columns["time"] + 0.003), atol=1e-9)
    np.testing.assert_allclose(columns["pressure"], 1e4 * columns["tip_angle"], atol=1e-6)


def test_a_unit_beside_the_field_is_converted(tmp_path):
    record.write_bag(tmp_path / "r1", _ramp())
    topics = TOPICS | {"tip_angle": TOPICS["tip_angle"] | {"unit": "deg"}}
    ratio = _load(tmp_path, topics)["tip_angle"] / _load(tmp_path)["tip_angle"]
    np.testing.assert_allclose(ratio, np.pi / 180.0)


def test_the_mend_of_exchanged_columns_can_be_pasted(tmp_path):
    record.write_bag(tmp_path / "r1", _ramp())
    right = _load(tmp_path)
    exchanged = {"pressure": TOPICS["tip_angle"], "tip_angle": TOPICS["pressure"]}
    assert np.ptp(_load(tmp_path, exchanged)["tip_angle"]) > 1e3  # a pressure
    mend = {"pressure": {"from": "tip_angle"}, "tip_angle": {"from": "pressure"}}
    pasted = {name: exchanged[name] | mend[name] for name in exchanged}
    for name in TOPICS:
        np.testing.assert_allclose(_load(tmp_path, pasted)[name], right[name])
    with pytest.raises(DocumentError, match="from"):
        _load(tmp_path, TOPICS | {"pressure": TOPICS["pressure"] | {"from": "force"}})


def test_the_noise_of_a_set_of_bags_is_in_the_unit_of_the_field(tmp_path):
    record.write_bag(tmp_path / "r1", _ramp())
    topics = TOPICS | {"tip_angle": TOPICS["tip_angle"] | {"unit": "deg"}}
    runs = {"r1": {"specimen": "f", "bag": "r1", "topics": topics}}
    content = document(runs=runs, columns={}, noise={"tip_angle": 2.0})
    data = load_measurements(write_set(tmp_path, content, {}))
    assert data.noise == pytest.approx({"tip_angle": np.radians(2.0)})


def test_without_header_the_time_of_reception_counts(tmp_path):
    times = np.arange(0.0, 1.001, 0.1)
    messages = [("/p", seconds, record.number(10.0 * seconds)) for seconds in times]
    messages += [("/angle", seconds, record.numbers([9.0, seconds])) for seconds in times + 0.05]
    record.write_bag(tmp_path / "r1", messages)
    topics = {
        "pressure": {"topic": "p", "field": "data"},
        "tip_angle": {"topic": "/angle", "field": "data[1]"},
    }
    columns = _load(tmp_path, topics)
    np.testing.assert_allclose(columns["time"], times[:-1], atol=1e-6)
    np.testing.assert_allclose(columns["pressure"], 10.0 * columns["tip_angle"], atol=1e-6)


def test_times_of_reception_are_simulated_times_where_the_clock_was_recorded(tmp_path):
    # the simulation runs at half the speed of the wall, and its header stamps tell its own time
    times = np.arange(0.0, 1.001, 0.1)
    messages = [("/clock", 2.0 * seconds, record.clock(50.0 + seconds)) for seconds in times]
    messages += [("/p", 2.0 * seconds, record.number(seconds)) for seconds in times]
    for seconds in times:
        angles = record.joint_state(50.0 + seconds, ["p10"], position=[seconds])
        messages.append(("/hand/tip_angles", 2.0 * seconds, angles))
    record.write_bag(tmp_path / "r1", messages)
    topics = TOPICS | {"pressure": {"topic": "/p", "field": "data"}}
    columns = _load(tmp_path, topics)
    np.testing.assert_allclose(columns["time"], times, atol=1e-6)
    np.testing.assert_allclose(columns["pressure"], columns["tip_angle"], atol=1e-6)


def test_of_messages_with_one_stamp_the_last_counts(tmp_path):
    messages = _ramp()
    again = record.joint_state(5.003, ["p10"], position=[0.5])
    messages.insert(-100, ("/hand/tip_angles", 0.0031, again))
    record.write_bag(tmp_path / "r1", messages)
    columns = _load(tmp_path)
    assert columns["tip_angle"][0] == 0.5
    assert np.all(np.diff(columns["time"]) > 0.0)


def test_plain_fields_are_read_by_path(tmp_path):
    times = np.arange(0.0, 0.5, 0.1)
    messages = []
    for seconds in times:
        messages.append(("/wrench", seconds, record.wrench(seconds, (1.0, 2.0, 3.0 + seconds))))
        messages.append(("/tip", seconds, record.pose(seconds, (seconds, 5.0, 6.0))))
        messages.append(("/p", seconds, record.fluid_pressure(seconds, 101300.0 + seconds)))
    record.write_bag(tmp_path / "r1", messages)
    tip = {f"tip_{axis}": f"pose.position.{axis}" for axis in "xyz"}
    tip |= {f"tip_q{axis}": f"pose.orientation.{axis}" for axis in "xyzw"}
    topics = {name: {"topic": "/tip", "field": field} for name, field in tip.items()}
    for axis in "xyz":
        topics[f"torque_{axis}"] = {"topic": "/wrench", "field": f"wrench.torque.{axis}"}
    topics["pressure"] = {"topic": "/p", "field": "fluid_pressure"}
    columns = _load(tmp_path, topics, experiment="base_torque")
    np.testing.assert_allclose(columns["torque_z"], 3.0 + times)
    np.testing.assert_allclose(columns["tip_x"], times, atol=1e-12)
    np.testing.assert_allclose(columns["tip_qw"], 1.0)
    np.testing.assert_allclose(columns["pressure"], 101300.0 + times)


def test_a_ros1_bag_is_read(tmp_path):
    messages = []
    for number in range(21):
        seconds = 0.1 * number
        state = record.ros1_joint_state(number, 5 + seconds, ["a"], effort=[1e3 * seconds])
        angles = record.ros1_joint_state(number, 5 + seconds, ["p10"], position=[0.1 * seconds])
        messages += [("/pneumaticbox/state", seconds, state), ("/hand/tip_angles", seconds, angles)]
    record.write_ros1_bag(tmp_path / "r1.bag", messages)
    runs = {"r1": {"specimen": "f", "bag": "r1.bag", "topics": TOPICS}}
    columns = load_measurements(write_set(tmp_path, document(runs=runs), {})).runs[0].columns
    np.testing.assert_allclose(columns["time"], 0.1 * np.arange(21), atol=1e-9)
    np.testing.assert_allclose(columns["tip_angle"], 0.1 * columns["time"], atol=1e-9)
    np.testing.assert_allclose(columns["pressure"], 1e4 * columns["tip_angle"], atol=1e-6)


def test_what_the_input_did_before_a_late_output_is_kept_and_drives_the_model(tmp_path):
    # softening rubber: the angle depends on the peak of 40 kPa that came before the first angle
    late, offset = 2.0, ClockOffset(offset=2.0, drift=0.0)
    times = np.arange(0.0, 6.001, 0.05)
    pressure = np.interp(times, [0.0, 1.0, 2.0, 4.0, 6.0], [0.0, 4e4, 0.0, 2e4, 0.0])
    softening = MullinsSoftening(softening=0.4, stretch_scale=0.2)
    truth = Run("r1", "f", "r1", 293.15, {"time": times, "pressure": pressure})
    given = MeasurementSet("free_bending", "", {"f": Specimen("f", SPECIMEN)}, (truth,))
    angle = Forward(given, fixed=[softening], free_calibration=False).predict(np.zeros((1, 0)))[0]
    messages = [
        ("/p", seconds, record.fluid_pressure(seconds, value))
        for seconds, value in zip(times, pressure, strict=True)
    ]
    for seconds, value in zip(times + late, angle, strict=True):
        if seconds > 3.6:  # the camera starts after the peak
            tip = record.joint_state(seconds, ["p10"], position=[value])
            messages.append(("/hand/tip_angles", seconds, tip))
    record.write_bag(tmp_path / "r1", messages)
    topics = TOPICS | {"pressure": {"topic": "/p", "field": "fluid_pressure"}}
    runs = {"r1": {"specimen": "f", "bag": "r1", "topics": topics}}
    data = load_measurements(write_set(tmp_path, document(runs=runs), {}))
    assert data.runs[0].lead["pressure"].max() == pytest.approx(4e4)
    assert data.runs[0].lead["time"][-1] == pytest.approx(-0.05)
    assert data.runs[0].columns["time"][0] == 0.0

    def error(of):
        model = Forward(of, fixed=[softening, offset], free_calibration=False)
        return np.abs(model.predict(np.zeros((1, 0)))[0] - data.table.value).max() / angle.max()

    assert error(data) < 2e-3
    assert error(replace(data, runs=(replace(data.runs[0], lead={}),))) > 0.05


# ------------------------------------------------------------------ what is refused
def _message(folder, topics=None):
    with pytest.raises(DocumentError) as caught:
        _load(folder, topics)
    message = str(caught.value)
    assert "\n" not in message
    return message


WRONG_TOPICS = {
    "topic": ("tip_angle", {"topic": "/hand/angles"}, "it holds /hand/tip_angles, /pneumaticbox"),
    "joint": ("pressure", {"field": "effort[c]"}, "effort[b], effort[a]"),
    "index": ("pressure", {"field": "effort[2]"}, "effort[b], effort[a]"),
    "empty field": ("tip_angle", {"field": "effort[p10]"}, "position[p10]"),
    "name": ("tip_angle", {"field": "angle"}, "no angle"),
    "whole array": ("pressure", {"field": "effort"}, "no single number"),
    "text": ("pressure", {"field": "effort[a"}, "got 'effort[a'"),
    "unit": ("pressure", {"unit": "deg"}, "'deg'"),
}


@pytest.mark.parametrize(("column", "change", "part"), WRONG_TOPICS.values(), ids=WRONG_TOPICS)
def test_a_bag_without_topic_or_field_lists_what_it_holds(tmp_path, column, change, part):
    record.write_bag(tmp_path / "r1", _ramp())
    message = _message(tmp_path, TOPICS | {column: TOPICS[column] | change})
    assert f"runs.r1.topics.{column}" in message
    assert part in message


def test_a_component_of_a_quaternion_is_no_angle(tmp_path):
    messages = [("/p", s, record.fluid_pressure(s, 1e3)) for s in (0.0, 1.0)]
    messages += [("/tip", s, record.pose(s, (0.0, 0.0, 0.0))) for s in (0.0, 1.0)]
    record.write_bag(tmp_path / "r1", messages)
    topics = {
        "pressure": {"topic": "/p", "field": "fluid_pressure"},
        "tip_angle": {"topic": "/tip", "field": "pose.orientation.y"},
    }
    message = _message(tmp_path, topics)
    assert "numbers of a quaternion" in message
    assert "`model-lab import BAG" in message


def test_a_missing_column_is_named(tmp_path):
    record.write_bag(tmp_path / "r1", _ramp())
    message = _message(tmp_path, {"tip_angle": TOPICS["tip_angle"]})
    assert "runs.r1.topics: expected the column pressure" in message


def test_a_topic_without_messages_is_named(tmp_path):
    messages = [("/hand/tip_angles", "sensor_msgs/msg/JointState"), *_ramp()[:201]]
    record.write_bag(tmp_path / "r1", messages)
    assert "expected messages on /hand/tip_angles" in _message(tmp_path)


def test_a_value_that_is_not_finite_is_located(tmp_path):
    angles = record.joint_state(6.5, ["p10"], position=[np.nan])
    messages = [*_ramp(), ("/hand/tip_angles", 2.1, angles)]
    record.write_bag(tmp_path / "r1", messages)
    assert "got nan in message 102 of /hand/tip_angles" in _message(tmp_path)


def test_a_clock_that_was_reset_is_located(tmp_path):
    angles = record.joint_state(5.0, ["p10"], position=[0.0])
    record.write_bag(tmp_path / "r1", [*_ramp(), ("/hand/tip_angles", 2.1, angles)])
    message = _message(tmp_path)
    assert "/hand/tip_angles: expected rising stamps" in message
    assert "message 102" in message


def test_topics_that_do_not_overlap_are_told_with_their_times(tmp_path):
    late = [("/hand/tip_angles", 2.0, record.joint_state(60.0, ["p10"], position=[0.0]))]
    record.write_bag(tmp_path / "r1", _ramp()[:201] + late)
    message = _message(tmp_path)
    assert "overlap" in message
    assert "from 60.000 to 60.000 s" in message


def test_a_missing_or_cut_off_bag_is_named(tmp_path):
    assert "nothing there" in _message(tmp_path)
    record.write_bag(tmp_path / "r1", _ramp())
    (tmp_path / "r1" / "metadata.yaml").unlink()
    message = _message(tmp_path)
    assert str(tmp_path / "r1") in message
    assert "r1.mcap" in message
    assert "repairs a truncated" in message


def test_a_broken_bag_is_named(tmp_path):
    record.write_bag(tmp_path / "r1", _ramp())
    file = next((tmp_path / "r1").glob("*.mcap"))
    file.write_bytes(file.read_bytes()[:200])
    assert str(tmp_path / "r1") in _message(tmp_path)


def test_names_of_joints_may_hold_dots_and_slashes():
    message = record.joint_state(0.0, ["left/p.1", "p.2"], position=[1.0, 2.0])
    assert MessageField.parse("position[left/p.1]").value(message) == 1.0
    assert MessageField.parse("position[p.2]").value(message) == 2.0


@pytest.mark.parametrize("text", ["", "[a]", "a..b", "a.", "a[]", "a b", "1a"])
def test_texts_that_are_no_field_are_refused(text):
    with pytest.raises(ValueError, match="expected a field"):
        MessageField.parse(text)
