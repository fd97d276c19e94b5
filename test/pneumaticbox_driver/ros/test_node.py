"""The driver as a process, against a test that owns the plant and answers in lockstep."""

import math
import signal
import time

import numpy as np
import pytest
from plant_peer import BOX, CHANNELS, DEEP, MG, MODULE
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import DescribeParameters, GetParameters, SetParameters
from refused_start import refusal
from ros_peer import seconds
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import FluidPressure, JointState
from std_srvs.srv import SetBool, Trigger
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from pneumaticbox_driver.ros.parameters import PARAMETERS
from softhand_bringup.processes.launcher import NodeCommand

pytestmark = pytest.mark.system
DOUBLE = ParameterType.PARAMETER_DOUBLE


def test_it_answers_each_sample_and_brings_the_channels_to_their_masses(start, peer):
    start(state_rate=0.0)
    pressures = peer.listen(FluidPressure, "pneumaticbox/supply/pressure", DEEP)
    peer.connect()
    peer.command(20 * MG, 8 * MG)
    peer.valves.clear()
    peer.states.clear()
    peer.run(2.0)
    stamps = [seconds(message.header.stamp) for message in peer.valves]
    np.testing.assert_allclose(np.diff(stamps), 0.002, atol=1e-9)
    np.testing.assert_allclose(peer.mass(), [20 * MG, 8 * MG], atol=1 * MG)
    last = peer.valves[-1].header.stamp
    peer.wait(lambda: peer.states[-1].header.stamp == last, "the last state")
    state = peer.states[-1]
    assert state.name == CHANNELS
    np.testing.assert_allclose(state.position, peer.mass(), atol=1 * MG)
    np.testing.assert_allclose(state.effort, peer.plant.pressures - 101.3e3, atol=500.0)
    assert len(pressures) == pytest.approx(2.6 * 25, rel=0.15)
    assert pressures[-1].variance > 0
    assert pressures[-1].fluid_pressure == pytest.approx(401e3, rel=0.03)


def test_states_come_at_their_rate_and_at_every_sample_once_that_is_asked_for(start, peer):
    start()
    peer.connect()

    def gaps():
        peer.states.clear()
        peer.run(0.3)
        peer.spin(0.2)
        return np.diff([seconds(state.header.stamp) for state in peer.states])

    np.testing.assert_allclose(gaps(), 0.01, atol=1e-9)
    # at the ticks of the simulator's clock, which the sequencer waits for
    assert round(seconds(peer.states[-1].header.stamp) * 1e9) % 10**7 == 0
    every = Parameter(name="state_rate", value=ParameterValue(type=DOUBLE, double_value=0.0))
    answer = peer.call(SetParameters, "pneumaticbox/set_parameters", parameters=[every])
    assert answer.results[0].successful
    gaps()
    np.testing.assert_allclose(gaps(), 0.002, atol=1e-9)


def test_unusable_messages_are_refused_whole_and_named(start, peer):
    start()
    peer.connect()
    peer.command(10 * MG, 10 * MG)
    peer.run(1.0)
    peer.command(30 * MG, math.nan)
    peer.diagnosis("commands", "pneumaticbox/command: points[0].positions[1]", "got nan")
    peer.command(30 * MG, 30 * MG, names=["a", "z"])
    peer.diagnosis("commands", "joint_names", "got 'z'")
    late = JointTrajectoryPoint(positions=[0.0, 0.0])
    late.time_from_start.sec = -1
    message = JointTrajectory(joint_names=CHANNELS, points=[late])
    peer.deliver(JointTrajectory, "pneumaticbox/command", message)
    peer.diagnosis("commands", "points[0].time_from_start: expected 0 s or later")
    peer.publish(JointTrajectory, "pneumaticbox/valve_schedule", JointTrajectory())
    peer.diagnosis("commands", "pneumaticbox/valve_schedule: joint_names: expected", "got none")
    peer.sample([1e5, 1e5], names=CHANNELS)
    peer.diagnosis("commands", "pneumaticbox/sensors: name: expected")
    np.testing.assert_allclose(peer.mass(), 10 * MG, atol=1 * MG)


def test_services_vent_reset_tare_and_enable(start, peer):
    start()
    peer.connect()
    peer.command(10 * MG, 10 * MG)
    peer.run(1.0)
    assert peer.call(Trigger, "pneumaticbox/vent").success
    peer.run(2.0)
    np.testing.assert_allclose(peer.mass(), 0.0, atol=0.1 * MG)
    refused = peer.call(Trigger, "pneumaticbox/tare")
    assert not refused.success and "valves are open" in refused.message
    peer.command(10 * MG, 10 * MG)
    peer.diagnosis("commands", "vented until reset (vent was requested)")
    early = peer.call(SetBool, "pneumaticbox/enable", data=True)
    assert not early.success and "pneumaticbox/reset must come first" in early.message
    assert peer.call(Trigger, "pneumaticbox/reset").success
    peer.diagnosis("commands OK")
    peer.run(0.6)
    assert peer.call(Trigger, "pneumaticbox/tare").success
    peer.command(10 * MG, 5 * MG)
    peer.run(1.0)
    np.testing.assert_allclose(peer.mass(), [10 * MG, 5 * MG], atol=1 * MG)
    assert peer.call(SetBool, "pneumaticbox/enable", data=False).success
    peer.diagnosis("safety", "disabled")


def test_without_samples_it_vents_and_latches_until_reset(start, peer):
    start(use_sim_time=False)
    peer.connect()
    peer.command(10 * MG, 10 * MG)
    peer.run(0.2)
    peer.wait(lambda: list(peer.valves[-1].position) == [-1.0, -1.0], "open outlets", 1.0)
    peer.diagnosis("safety", "no sensor sample for 250 ms", keep_going=False)

    def refused():  # a driver that was held up may have taken the last sample after the vent
        answer = peer.call(Trigger, "pneumaticbox/reset")
        return answer if not answer.success else None

    assert "expected a sensor sample" in peer.wait(refused, "a reset that is refused").message
    peer.run(0.02)
    assert list(peer.valves[-1].position) == [-1.0, -1.0]
    assert peer.call(Trigger, "pneumaticbox/reset").success


def test_on_simulated_time_neither_a_pause_nor_a_slow_simulator_is_a_fault(start, peer):
    start()
    tick = Clock()

    def beat(duration):
        end = time.monotonic() + duration
        while time.monotonic() < end:
            peer.publish(Clock, "/clock", tick)
            peer.spin(0.1)

    peer.connect()
    tick.clock.nanosec = 600_000_000
    beat(3.0)
    peer.told.clear()
    beat(1.2)
    states = {s.name: s for message in peer.told for s in message.status}
    assert states["pneumaticbox: safety"].message == "in operation"
    assert {v.key: v.value for v in states["pneumaticbox: sensors"].values}["simulation"]
    peer.diagnosis("sensors", "/clock does not advance", limit=20.0, keep_going=False)
    peer.diagnosis("safety", "in operation", keep_going=False)
    answered = len(peer.valves)
    peer.run(0.02)
    assert len(peer.valves) > answered
    assert list(peer.valves[-1].position) == [0.0, 0.0]


def test_a_sensor_without_a_number_is_a_fault(start, peer):
    process = start()
    peer.connect()
    peer.sample([1e5, math.nan, 4e5])
    peer.diagnosis("safety", "sensor b: not a number")
    assert (
        process.output().count(
            "sensor b: not a number: venting until the service pneumaticbox/reset is called"
        )
        == 1
    )


@pytest.mark.parametrize("simulated", [False, True])
def test_the_embedded_backend_runs_on_the_wall_clock(start, peer, simulated):
    process = start(
        backend="embedded", embedded_rate=200.0, use_sim_time=simulated, real_time_priority=20
    )
    peer.wait(lambda: peer.states, "a state")
    peer.spin(1.0)
    peer.command(20 * MG, 5 * MG)
    # to the smallest pulse: when the samples come is up to the machine
    peer.wait(
        lambda: np.allclose(peer.states[-1].position, [20 * MG, 5 * MG], atol=2.5 * MG),
        "the masses",
    )
    # the clock of the samples is the wall's
    assert abs(seconds(peer.states[-1].header.stamp) - time.time()) < 5.0
    ignored = "use_sim_time is ignored: backend embedded follows the wall clock"
    assert process.output().count(ignored) == simulated
    if simulated:
        peer.diagnosis("sensors", ignored, keep_going=False)
    assert peer.change("use_sim_time", True) == ignored


@pytest.mark.parametrize(
    ("parameters", "simulated"),
    [({}, True), ({"use_sim_time": False}, False), ({"backend": "embedded"}, False)],
    ids=["plain", "false", "embedded"],
)
def test_it_follows_simulated_time_unless_told_otherwise(launcher, peer, parameters, simulated):
    launcher.start(NodeCommand("driver", MODULE, {**BOX, **parameters}))
    service = "pneumaticbox/get_parameters"
    answer = peer.call(GetParameters, service, names=["use_sim_time"])
    assert answer.values[0].bool_value == simulated
    peer.wait(lambda: peer.told, "diagnostics")
    assert (peer.told[-1].header.stamp.sec == 0) == simulated  # there is no /clock


def test_two_simulators_are_told_and_do_not_flood_the_log(start, peer):
    process = start()
    peer.connect()
    other = peer.node.create_publisher(JointState, "pneumaticbox/sensors", 10)
    peer.diagnosis("sensors", "two simulators publish pneumaticbox/sensors: stop one")
    for _ in range(20):
        peer.sample()
        other.publish(JointState(name=[*CHANNELS, "supply"], effort=[1e5, 1e5, 4e5]))
        peer.spin(0.1)
    peer.node.destroy_publisher(other)
    assert process.output().count("the clock was set back") == 1


@pytest.mark.parametrize(
    ("parameters", "words"),
    [
        ({"hand": "rbo_hand_9", "rest_volumes": [0.0]}, ("rbo_hand_9", "rbo_hand_2")),
        ({"backend": "bench"}, ("backend: expected one of topic", "hardware", "got 'bench'")),
        ({"backend": "hardware"}, ("hardware_file must be the path of a hardware file, got none",)),
        ({"control_mode": ["force"]}, ("control_mode: expected one of", "got 'force'")),
        ({"control_mode": ["volume"]}, ("'volume' expects volume_model 'hand', got 'fixed'",)),
        ({"outlets": [1]}, ("outlets must be 2 numbers from 1", "got [1]")),
        ({"backend": "embedded", "embedded_plant": "/none.yaml"}, ("/none.yaml", "readable file")),
        ({"calibration_file": "/none.yaml"}, ("/none.yaml", "expected a readable file")),
        ({"command_timeout": -1.0}, ("command_timeout",)),
        ({"pressure_limits": [1e5]}, ("pressure_limits must have 2 values",)),
    ],
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else "",
)
def test_parameters_that_cannot_be_used_end_it_with_one_line(
    parameters, words, domain, monkeypatch, capfd
):
    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
    line = refusal(NodeCommand("driver", MODULE, {**BOX, **parameters}), capfd)
    assert all(word in line for word in words)


def test_parameters_are_described_and_control_mode_is_checked(start, peer):
    start()
    peer.connect()
    names = [parameter.name for parameter in PARAMETERS]
    described = peer.call(DescribeParameters, "pneumaticbox/describe_parameters", names=names)
    for descriptor in described.descriptors:
        assert descriptor.description
        assert descriptor.type != ParameterType.PARAMETER_NOT_SET
    fixed = {descriptor.name for descriptor in described.descriptors if descriptor.read_only}
    assert fixed == {parameter.name for parameter in PARAMETERS if parameter.read_only}
    assert "control_mode" not in fixed and "channels" in fixed
    assert "got 'force'" in peer.change("control_mode", ["force"])
    assert "expected backend embedded, got topic" in peer.change("embedded_supply", 2e5)


@pytest.mark.parametrize("backend", ["topic", "embedded"])
@pytest.mark.parametrize(
    "signals",
    [[signal.SIGTERM], [signal.SIGINT, signal.SIGINT]],
    ids=["SIGTERM", "twice SIGINT"],
)
def test_it_ends_in_order_and_leaves_the_outlets_open(start, peer, signals, backend):
    process = start(backend=backend, use_sim_time=backend == "topic")
    if backend == "topic":
        peer.connect()
    peer.wait(lambda: peer.valves, "the driver")
    for number in signals:
        process.send(number)
    assert process.wait(10.0) == 0, process.output()
    for text in ("terminate called", "Traceback", "rcl_shutdown"):
        assert text not in process.output()
    peer.wait(lambda: list(peer.valves[-1].position) == [-1.0, -1.0], "open outlets", 2.0)
