"""The monitor as a process, against a test that plays driver and simulator."""

import array
import itertools
import signal

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Point, Pose, PoseArray, PoseStamped, WrenchStamped
from rcl_interfaces.srv import DescribeParameters, GetParameters
from refused_start import refusal
from ros_peer import PATIENCE
from sensor_msgs.msg import JointState

from model_lab.ros.interface import PARAMETERS
from softhand_bringup.processes.launcher import NodeCommand
from softhand_model.hand.actuator import load_actuator

MODULE = "model_lab.ros.monitor"
USUAL = {"hand": "single_finger", "model_file": "base"}
FINGER = load_actuator("P10.finger")
VISCOUS = """
format: softhand-model/1
base: pneuflex
effects:
  - {name: viscoelasticity, parameters: {relative_modulus: 0.4, relaxation_time: 1.0}}
"""
MS = 10**6
START = 100_000 * MS  # [ns] stamp at which the tests begin
BEGIN = START * 1e-9


def message(stamp, **fields):
    made = JointState(**fields)
    made.header.stamp.sec, made.header.stamp.nanosec = divmod(stamp, 10**9)
    return made


class Bench:
    """Plays the pressures and angles of a single finger, and hears what the monitor says."""

    def __init__(self, peer):
        self.peer = peer
        self.told = peer.listen(DiagnosticArray, "/diagnostics")
        self.predictions = peer.listen(JointState, "model/prediction", 1000)
        self.residuals = peer.listen(JointState, "model/residual", 1000)

    def play(self, pressure, angle, start, stop):
        """Publish pressure(t) [Pa] every 4 ms and angle(t) [rad] every 20 ms of stamps [ns]."""
        for stamp in range(start, stop + 1, 4 * MS):
            effort = array.array("d", [pressure(stamp * 1e-9)])
            self.peer.publish(
                JointState, "pneumaticbox/state", message(stamp, name=["a"], effort=effort)
            )
            if stamp % (20 * MS) == 0:
                position = array.array("d", [angle(stamp * 1e-9)])
                self.peer.publish(
                    JointState,
                    "hand/tip_angles",
                    message(stamp, name=["finger"], position=position),
                )
                self.peer.spin(0.005)

    def connect(self):
        """Until what is played is heard and answered; the finger rests meanwhile.

        Not at 0, where a test may begin: a stamp that was there already is not answered again.
        """
        stamps = itertools.count(20 * MS, 20 * MS)

        def answered():
            self.play(lambda t: 0.0, lambda t: 0.0, stamp := next(stamps), stamp)
            return self.residuals and self.predictions

        self.peer.wait(answered, "a residual and a prediction")
        self.peer.spin(0.3)
        self.residuals.clear()
        self.predictions.clear()

    def wait_for(self, count):
        self.peer.wait(lambda: len(self.residuals) >= count, f"{count} residuals")
        self.peer.wait(lambda: len(self.predictions) >= count, f"{count} predictions")

    def status(self, name, level, *words, limit=PATIENCE):
        """Wait for a status of the monitor at a level in which all words stand."""
        self.told.clear()

        def found():
            every = [status for array in self.told for status in array.status]
            return next(
                (
                    s
                    for s in every
                    if s.name == f"monitor: {name}"
                    and s.level == level
                    and all(word in s.message for word in words)
                ),
                None,
            )

        return self.peer.wait(found, f"{name} at {level} with {words}", limit)


@pytest.fixture
def bench(peer):
    return Bench(peer)


@pytest.fixture
def start(launcher):
    def start(**parameters):
        return launcher.start(NodeCommand("monitor", MODULE, {**USUAL, **parameters}))

    return start


def test_prediction_and_residual_carry_the_stamps_and_names_of_the_measurement(start, bench):
    process = start()
    bench.connect()
    bench.play(lambda t: 20e3 * (t - BEGIN), lambda t: 0.1, START, START + 1000 * MS)
    bench.wait_for(51)
    for predicted, residual in zip(bench.predictions, bench.residuals, strict=True):
        time = predicted.header.stamp.sec + 1e-9 * predicted.header.stamp.nanosec
        expected = float(FINGER.tip_angle(20e3 * (time - BEGIN)))
        assert predicted.name == residual.name == ["finger"]
        assert residual.header.stamp == predicted.header.stamp
        assert predicted.position[0] == pytest.approx(expected, abs=1e-6)
        assert residual.position[0] == pytest.approx(0.1 - expected, abs=1e-6)
    process.send(signal.SIGTERM)
    assert process.wait(10.0) == 0, process.output()
    assert "Traceback" not in process.output()


def test_the_residual_is_judged_in_diagnostics_once_a_second(start, bench):
    start()
    bench.status("finger", DiagnosticStatus.STALE, "no message on")
    bench.connect()
    good = float(FINGER.tip_angle(20e3))
    bench.play(lambda t: 20e3, lambda t: good + 0.01, START, START + 1000 * MS)
    status = bench.status("finger", DiagnosticStatus.OK, "residual 0.57 deg rms")
    assert {pair.key: pair.value for pair in status.values}["residual, rms [deg]"] == "0.573"
    bench.play(lambda t: 20e3, lambda t: good - 0.5, START + 1020 * MS, START + 3000 * MS)
    bench.status("finger", DiagnosticStatus.WARN, "contact", "deg rms, above 2.86 deg")
    bench.status("finger", DiagnosticStatus.STALE, "no message on")


def test_a_shadow_tells_contact_from_what_the_model_lacks(start, bench, peer):
    """The fingertip is as predicted, then 20 mm off, with a force at the wrist and without one."""
    start(model_file="gravity", shadow=True)
    bench.status("shadow", DiagnosticStatus.STALE, "waiting for hand/fingertips and wrist/pose")
    bench.connect()
    shadows = peer.listen(PoseArray, "model/fingertips", 50)
    angle = float(FINGER.tip_angle(20e3))
    times = itertools.count(START, 200 * MS)

    def show(off, force):
        stamp = next(times)
        bench.play(lambda t: 20e3, lambda t: angle, stamp, stamp + 180 * MS)
        wrist = PoseStamped()
        wrist.pose.orientation.w = 1.0
        wrench = WrenchStamped()
        wrench.wrench.force.z = force
        place = shadows[-1].poses[0].position if shadows else Point()
        tip = Pose(position=Point(x=place.x + off, y=place.y, z=place.z))
        for kind, topic, made in (
            (PoseStamped, "wrist/pose", wrist),
            (WrenchStamped, "wrist/wrench", wrench),
            (PoseArray, "hand/fingertips", PoseArray(poses=[tip])),
        ):
            made.header.stamp = message(stamp + 160 * MS).header.stamp
            peer.publish(kind, topic, made)

    def told(level, words, off=0.0, force=0.0):
        def found():
            show(off, force)
            every = [s for array in bench.told[-2:] for s in array.status]
            return any(
                s.name == "monitor: shadow" and s.level == level and words in s.message
                for s in every
            )

        peer.wait(found, words)

    told(DiagnosticStatus.OK, "fingertips 0.0 mm rms")
    told(DiagnosticStatus.WARN, "contact, as the wrist bears 1.50 N", 0.02, 1.5)
    told(DiagnosticStatus.WARN, "the model lacks an effect", 0.02, 0.01)


def test_a_simulation_that_starts_again_resets_the_memory(start, bench, tmp_path):
    (tmp_path / "viscous.yaml").write_text(VISCOUS)
    start(model_file=str(tmp_path / "viscous.yaml"))
    bench.connect()
    for turn in (1, 2):
        bench.play(lambda t: 20e3, lambda t: 0.0, 0, 1000 * MS)
        bench.wait_for(51 * turn)
    first, second = ([p.position[0] for p in bench.predictions[i : i + 51]] for i in (0, 51))
    assert first[-1] - first[0] > 0.2  # it creeps
    assert second == first
    bench.status("model", DiagnosticStatus.WARN, "clock was set back")


def test_a_message_that_cannot_be_used_is_refused_and_named(start, bench, peer):
    process = start()
    bench.connect()
    peer.publish(JointState, "pneumaticbox/state", message(START, name=["a"]))
    bench.status("model", DiagnosticStatus.WARN, "pneumaticbox/state: effort: expected 1 values")
    peer.publish(JointState, "hand/tip_angles", message(START, name=["thumb"], position=[1.0]))
    bench.status(
        "model",
        DiagnosticStatus.WARN,
        "hand/tip_angles: name: expected some of the actuators finger",
    )
    bench.play(lambda t: 20e3, lambda t: 0.0, START, START + 200 * MS)
    bench.wait_for(11)
    assert process.exit_code is None


def test_parameters_are_described_and_served(start, peer):
    start(warn_above=0.2)
    names = [parameter.name for parameter in PARAMETERS]
    described = peer.call(DescribeParameters, "monitor/describe_parameters", names=names)
    for descriptor, parameter in zip(described.descriptors, PARAMETERS, strict=True):
        assert descriptor.description == parameter.text
        assert descriptor.read_only
        assert bool(descriptor.floating_point_range) == (parameter.bounds is not None)
    (value,) = peer.call(GetParameters, "monitor/get_parameters", names=["warn_above"]).values
    assert value.double_value == 0.2


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"hand": "rbo_hand_9"}, ("rbo_hand_9", "single_finger")),
        ({"model_file": "no_such_model"}, ("no_such_model", "gravity")),
        ({"warn_above": -1.0}, ("warn_above",)),
    ],
)
def test_a_parameter_that_cannot_be_used_ends_the_node_with_one_line(
    wrong, words, domain, monkeypatch, capfd
):
    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
    line = refusal(NodeCommand("monitor", MODULE, {**USUAL, **wrong}), capfd)
    for word in words:
        assert word in line
