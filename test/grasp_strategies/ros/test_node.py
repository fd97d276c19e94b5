"""The sequencer as a process, against a process that stands in for simulator and driver."""

import itertools
import os
import signal
from pathlib import Path

import pytest
import yaml
from diagnostic_msgs.msg import DiagnosticArray
from forked_nodes import ForkingLauncher
from rcl_interfaces.srv import DescribeParameters, SetParameters
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile
from refused_start import refusal
from ros_domain import held_domain
from ros_peer import PATIENCE, Peer, seconds
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Int32, String
from std_srvs.srv import SetBool, Trigger
from trajectory_msgs.msg import JointTrajectory

from grasp_strategies.ros.parameters import PARAMETERS
from softhand_bringup.processes.launcher import NodeCommand
from softhand_bringup.processes.suite import node_environment

pytestmark = pytest.mark.system

MODULE = "grasp_strategies.ros.node"
SUPPORT = Path(__file__).parents[2] / "support"
LIFT_DURATION = 1.875 * 0.12 / 0.2
LATCHED = QoSProfile(depth=20, durability=DurabilityPolicy.TRANSIENT_LOCAL)
PHASES = ["approach", "close", "lift", "hold", "lower", "release", "done"]


@pytest.fixture(scope="module")
def domain():
    with held_domain() as domain:
        yield domain


@pytest.fixture
def launcher(domain, tmp_path):
    environment = node_environment(tmp_path / "log", domain)
    environment["PYTHONPATH"] = os.pathsep.join(
        filter(None, [str(SUPPORT), environment.get("PYTHONPATH")])
    )
    with ForkingLauncher(tmp_path / "log", environment) as launcher:
        yield launcher


class SequencerPeer(Peer):
    """A test's node that hears what the sequencer tells."""

    def __init__(self, domain, log_folder):
        super().__init__(domain, log_folder)
        self._phases = self.listen(String, "grasp/phase", LATCHED)
        self.results = self.listen(DiagnosticArray, "grasp/result", LATCHED)
        self.ticks = self.listen(Clock, "/clock")
        self.states = self.listen(JointState, "pneumaticbox/state")
        self.vents = self.listen(Int32, "mock/vents", LATCHED)

    def phases(self):
        return [message.data for message in self._phases if message.data != "idle"]

    def await_phase(self, name, limit=PATIENCE):
        self.wait(lambda: name in self.phases(), f"phase {name}", limit)

    def await_all_phases(self, names):
        """The answer of a service may overtake the last phase."""
        self.wait(lambda: len(self.phases()) >= len(names), f"phases {names}", 3.0)
        assert self.phases() == names

    def grasp(self):
        return self.request(Trigger, "grasp/surface_constrained")

    def answer(self, future, limit=PATIENCE):
        self.wait(future.done, "an answer", limit)
        return future.result()

    def result(self):
        """Header and key-value pairs of the newest result."""
        self.wait(lambda: self.results, "a result")
        message = self.results[-1]
        return message, {pair.key: pair.value for pair in message.status[0].values}

    def diagnosis(self, word, limit=PATIENCE):
        """A status of the sequencer in whose message a word stands."""
        arrays = self.listen(DiagnosticArray, "/diagnostics")
        del arrays[:]

        def find():
            statuses = [status for array in arrays for status in array.status]
            return next((s for s in statuses if word in s.message), None)

        return self.wait(find, f"a diagnosis with {word!r}", limit)


@pytest.fixture
def peer(domain, tmp_path):
    peer = SequencerPeer(domain, tmp_path)
    yield peer
    peer.close()


@pytest.fixture
def start(launcher, write_strategy):
    """Start the sequencer, with the test's strategy and other parameters."""

    def start(strategy=None, **parameters):
        path = strategy or write_strategy()
        usual = {"use_sim_time": True, "strategy.surface_constrained": str(path)}
        command = NodeCommand("sequencer", MODULE, usual | parameters)
        return launcher.start(command)

    return start


@pytest.fixture
def bench(launcher):
    """Start the stand-in for simulator and driver."""
    names = (f"bench{number}" for number in itertools.count())
    return lambda *arguments: launcher.start(
        NodeCommand(next(names), "mock_bench", arguments=arguments)
    )


# ---------------------------------------------------------------- grasps
@pytest.mark.parametrize("factor", [0.7, 4.0])
def test_a_grasp_takes_the_same_simulated_time_at_any_real_time_factor(start, bench, peer, factor):
    bench("--factor", str(factor), "--slip", "0.002")
    start()
    answer = peer.answer(peer.grasp())
    assert answer.success, answer.message
    peer.await_all_phases(PHASES)
    message, values = peer.result()
    assert values["outcome"] == message.status[0].message == "gripped"
    late = 0.15 + 0.2 * factor  # of simulated time, should the machine be busy for 0.2 s
    # it sinks from when all channels are full enough, halfway through the ramp
    height = 0.12 - 0.002 * (0.2 + LIFT_DURATION)
    assert float(values["lift_height"]) == pytest.approx(height, abs=0.002 * late)
    assert float(values["slip"]) == pytest.approx(0.002 * 1.2, abs=0.002 * late)
    duration = 0.5 + 0.4 + LIFT_DURATION + 1.2 + 0.6
    # five phases, each of which may be late; by wall time it would be off by at least 1.1 s of 3.8
    assert float(values["duration"]) == pytest.approx(duration, abs=0.15 + 0.4 * factor)
    assert float(values["turn"]) == pytest.approx(0.0, abs=1e-6)
    assert (values["phase"], values["cause"], values["failed_at"]) == ("", "", "nan")
    assert values["touching"] == "index, thumb"
    peer.wait(lambda: peer.ticks, "/clock")
    assert duration - late < seconds(message.header.stamp) < seconds(peer.ticks[-1].clock) + late


def test_a_grasp_can_be_called_again_after_it_has_ended(start, bench, peer):
    bench("--factor", "2")
    start()
    assert peer.answer(peer.grasp()).success
    assert peer.answer(peer.grasp()).success
    peer.await_all_phases(PHASES * 2)


def test_without_lowering_the_hand_goes_on_holding(start, bench, peer):
    bench("--factor", "2")
    start(lower_and_release=False)
    assert peer.answer(peer.grasp()).success
    peer.await_all_phases([*PHASES[:4], "done"])
    peer.spin(0.3)
    assert min(peer.states[-1].position) > 1e-5


def test_who_joins_late_reads_the_last_phase_alone(start, bench, peer, domain, tmp_path):
    bench("--factor", "2")
    start()
    assert peer.answer(peer.grasp()).success
    peer.await_phase("done")
    late = SequencerPeer(domain, tmp_path)
    late.await_phase("done")
    late.spin(0.2)
    assert late.phases() == ["done"]
    late.close()


# ---------------------------------------------------------------- who commands the air
def test_the_sequencer_is_a_commander_while_a_strategy_runs_and_not_before_or_after(
    start, bench, peer
):
    bench("--factor", "2")
    start()

    def commanders():
        return peer.node.count_publishers("pneumaticbox/command")

    assert commanders() == 0
    future = peer.grasp()
    peer.await_phase("close")
    assert commanders() == 1
    assert peer.answer(future).success
    peer.wait(lambda: commanders() == 0, "an end of the commander", 2.0)


def test_a_hand_that_holds_on_is_commanded_until_the_sequencer_is_killed(start, bench, peer):
    bench("--factor", "2", "--command-timeout", "3")
    process = start(lower_and_release=False)
    assert peer.answer(peer.grasp()).success
    peer.diagnosis("holding what was grasped")
    peer.spin(4.0)  # 8 s of simulated time
    assert min(peer.states[-1].position) > 1e-5
    process.send(signal.SIGKILL)
    peer.wait(lambda: max(peer.states[-1].position) == 0.0, "empty channels")


def test_what_is_held_is_left_to_a_node_that_commands_and_not_to_one_that_could(start, bench, peer):
    bench("--factor", "2")
    start(lower_and_release=False)
    assert peer.answer(peer.grasp()).success
    peer.diagnosis("holding what was grasped")
    publisher = peer.node.create_publisher(JointTrajectory, "pneumaticbox/command", 10)
    # the driver's and, while it holds, the sequencer's own
    peer.wait(lambda: publisher.get_subscription_count() == 2, "who hears of commands")
    peer.spin(2.0)
    assert peer.node.count_publishers("pneumaticbox/command") == 2
    peer.diagnosis("holding what was grasped")
    publisher.publish(JointTrajectory())
    peer.diagnosis("idle")
    peer.wait(lambda: peer.node.count_publishers("pneumaticbox/command") == 1, "one commander", 2.0)


def test_a_second_sequencer_does_not_start_unless_it_shall(start, launcher, peer, write_strategy):
    start()
    peer.wait(peer.listen(String, "grasp/phase", LATCHED).__len__, "the first one's phase")
    second = launcher.start(NodeCommand("second", MODULE, {"use_sim_time": True}))
    assert second.wait(20.0) == 2
    assert "another sequencer publishes /grasp/phase" in second.last_words()
    launcher.start(NodeCommand("third", MODULE, {"use_sim_time": True, "allow_second": True}))
    peer.diagnosis("another sequencer publishes /grasp/phase")


def test_a_simulator_that_is_started_last_is_waited_for(start, bench, peer):
    start()
    future = peer.grasp()
    peer.spin(1.0)
    assert not future.done()
    bench("--factor", "2")
    assert peer.answer(future).success


def test_a_grasp_waits_while_the_simulation_is_paused(start, bench, peer):
    bench("--factor", "2")
    start()
    future = peer.grasp()
    peer.await_phase("lift")
    assert peer.call(SetBool, "sim/pause", data=True).success
    peer.spin(2.5)  # longer than topics may be silent
    assert not future.done()
    peer.call(SetBool, "sim/pause", data=False)
    assert peer.answer(future).success


# ---------------------------------------------------------------- abort and refusals
@pytest.mark.parametrize("phase", ["approach", "hold"])
def test_an_abort_vents_at_once_and_ends_the_call(start, bench, peer, phase):
    bench("--factor", "1")
    start()
    future = peer.grasp()
    peer.await_phase(phase)
    aborted = peer.call(Trigger, "grasp/abort")
    assert aborted.success
    assert aborted.message == f"aborted in phase {phase}: vented"
    answer = peer.answer(future, 2.0)
    assert not answer.success and aborted.message in answer.message
    peer.wait(lambda: peer.vents, "the vent")
    peer.wait(lambda: max(peer.states[-1].position) == 0.0, "empty channels")
    peer.await_phase("aborted")
    assert peer.phases()[-1] == "aborted"
    values = peer.result()[1]
    assert values["completed"] == "False"
    assert (values["phase"], values["cause"]) == (phase, "aborted")


def test_an_abort_acts_while_the_simulation_is_paused(start, bench, peer):
    bench("--factor", "2")
    start()
    future = peer.grasp()
    peer.await_phase("close")
    peer.call(SetBool, "sim/pause", data=True)
    assert peer.call(Trigger, "grasp/abort", limit=3.0).success
    assert not peer.answer(future, 2.0).success


def test_an_abort_can_hold_the_air_instead(start, bench, peer):
    bench("--factor", "2")
    start()
    changed = Parameter("abort_action", value="hold").to_parameter_msg()
    service = "grasp_sequencer/set_parameters"
    assert peer.call(SetParameters, service, parameters=[changed]).results[0].successful
    future = peer.grasp()
    peer.await_phase("lift")
    assert peer.call(Trigger, "grasp/abort").message == "aborted in phase lift: holds"
    assert not peer.answer(future, 2.0).success
    peer.spin(0.5)
    assert not peer.vents
    assert peer.states[-1].position.tolist() == pytest.approx([4e-5, 2e-5, 2e-5, 2e-5], rel=0.1)


def test_an_abort_without_a_strategy_vents(start, bench, peer):
    bench("--factor", "5")
    start()
    aborted = peer.call(Trigger, "grasp/abort")
    assert aborted.success
    assert aborted.message.startswith(
        "no strategy is running; vented; commands are taken again after"
    )
    peer.wait(lambda: peer.vents, "the vent")


def test_after_an_abort_a_grasp_is_refused_until_the_driver_is_reset(start, bench, peer):
    bench("--factor", "2")
    start()
    peer.grasp()
    peer.await_phase("approach")
    assert peer.call(Trigger, "grasp/abort").success
    peer.spin(1.5)  # until the driver has told
    refused = peer.answer(peer.grasp())
    assert not refused.success
    assert "the driver reports: vented until pneumaticbox/reset" in refused.message
    peer.call(Trigger, "pneumaticbox/reset")
    assert peer.answer(peer.grasp()).success


def test_a_driver_that_vents_by_itself_ends_the_grasp_with_its_reason(start, bench, peer):
    bench("--factor", "0.5")
    start()
    future = peer.grasp()
    peer.await_phase("approach")
    peer.call(Trigger, "pneumaticbox/vent")
    answer = peer.answer(future)
    assert not answer.success
    assert "the driver reports: vented until pneumaticbox/reset" in answer.message


def test_a_driver_that_is_disabled_ends_the_grasp_at_once_with_that_reason(start, bench, peer):
    bench("--factor", "0.5")
    start()
    future = peer.grasp()
    peer.await_phase("approach")
    peer.call(SetBool, "pneumaticbox/enable", data=False)
    answer = peer.answer(future, limit=0.5)
    assert not answer.success
    assert "the driver reports: disabled" in answer.message


def test_an_abort_that_the_driver_refuses_is_told(start, bench, peer):
    bench("--factor", "5", "--refuse-vent")
    start()
    peer.grasp()
    peer.await_phase("close")
    aborted = peer.call(Trigger, "grasp/abort")
    assert not aborted.success
    assert "could not vent: the driver refused to vent" in aborted.message
    peer.wait(
        lambda: peer.states and max(peer.states[-1].position) == 0.0,
        "air commanded out all the same",
    )


def test_a_second_call_is_refused_with_the_reason_while_the_first_goes_on(start, bench, peer):
    bench("--factor", "2")
    start()
    future = peer.grasp()
    peer.await_phase("close")
    second = peer.call(Trigger, "grasp/surface_constrained")
    assert not second.success
    assert second.message.startswith("test_grasp is running (phase ")
    assert peer.answer(future).success


def test_services_run_what_is_shipped_for_the_hand_or_tell_for_which_hand_it_is(start, peer):
    start(connect_time_out=0.2)
    for service in ("push", "edge"):
        answer = peer.call(Trigger, f"grasp/{service}")
        assert not answer.success
        assert f"for the hand rbo_hand_2, got rbo_hand_1_{service} for rbo_hand_1" in answer.message
    peer.call(Trigger, "grasp/slide_to_wall")  # there is nobody to grasp with
    status = peer.result()[0].status[0]
    assert status.name.endswith("rbo_hand_2_slide_to_wall")


def test_a_strategy_for_another_hand_is_refused(start, peer, write_strategy):
    start(write_strategy(("hand: rbo_hand_2", "hand: rbo_hand_1")))
    answer = peer.answer(peer.grasp())
    assert not answer.success
    assert "for the hand rbo_hand_2, got test_grasp for rbo_hand_1" in answer.message


# ---------------------------------------------------------------- what is missing
@pytest.mark.parametrize(
    ("parts", "there", "missing"),
    [
        ("simulator", "hand_sim", ["pneumaticbox/state", "is driver running"]),
        ("driver", "driver", ["/clock", "scene/object_pose", "is hand_sim running"]),
    ],
)
def test_a_missing_node_is_named_after_the_time_out(start, bench, peer, parts, there, missing):
    bench("--parts", parts)
    start(connect_time_out=1.5)
    answer = peer.answer(peer.grasp())
    assert not answer.success
    for words in ["after 1.5 s of waiting", *missing]:
        assert words in answer.message
    assert f"is {there} running" not in answer.message


def test_a_node_that_is_preparing_is_waited_for_and_named_with_its_words(
    start, bench, peer, tmp_path
):
    start(connect_time_out=1.0)
    preparing = tmp_path / "preparing"
    preparing.touch()
    bench("--factor", "2", "--preparing", str(preparing))
    peer.diagnosis("compiling")
    future = peer.grasp()
    status = peer.diagnosis("waiting: ")
    assert "hand_sim reports: compiling the numerical kernels" in status.message
    preparing.unlink()
    assert peer.answer(future).success


def assert_nothing_moves(peer):
    """Neither a phase begins nor is anything commanded once simulator and driver are there."""
    commands = peer.listen(JointTrajectory, "pneumaticbox/command")
    peer.wait(lambda: peer.states, "a state of the driver")
    peer.spin(2.0)
    assert peer.phases() == ["failed"]
    assert not commands


@pytest.fixture
def preparing(bench, tmp_path):
    """A file; while it is there, the nodes of the bench say that they compile."""
    file = tmp_path / "preparing"
    file.touch()
    bench("--factor", "2", "--preparing", str(file))
    return file


def test_nodes_that_compile_too_long_end_a_call_and_nothing_moves_afterwards(
    start, preparing, peer
):
    start(connect_time_out=1.0, prepare_time_out=2.0)
    peer.diagnosis("compiling")
    answer = peer.answer(peer.grasp(), limit=4.0)
    assert not answer.success
    assert "after 2 s of waiting (prepare_time_out)" in answer.message
    assert "hand_sim reports: compiling the numerical kernels" in answer.message
    preparing.unlink()
    assert_nothing_moves(peer)


def test_a_caller_that_has_gone_gets_no_motion(start, preparing, peer):
    start(connect_time_out=1.0)
    peer.diagnosis("compiling")
    client = peer.node.create_client(Trigger, "grasp/surface_constrained")
    peer.wait(client.service_is_ready, "the service")
    client.call_async(Trigger.Request())
    peer.diagnosis("waiting: ")
    peer.node.destroy_client(client)
    _, values = peer.result()
    assert "the caller of grasp/surface_constrained has gone" in values["reason"]
    preparing.unlink()
    assert_nothing_moves(peer)


def test_a_bench_that_ends_in_mid_grasp_fails_the_grasp_by_name(start, bench, peer):
    process = bench("--factor", "2")
    start()
    future = peer.grasp()
    peer.await_phase("close")
    process.send(signal.SIGTERM)
    answer = peer.answer(future)
    assert not answer.success
    assert "/clock has no publisher any more" in answer.message
    peer.await_phase("failed")
    assert peer.phases()[-1] == "failed"


def test_a_driver_that_ends_in_mid_grasp_fails_the_grasp_by_name(start, bench, peer):
    bench("--parts", "simulator", "--factor", "1")
    driver = bench("--parts", "driver", "--factor", "1")
    start()
    future = peer.grasp()
    peer.await_phase("close")
    driver.send(signal.SIGTERM)
    answer = peer.answer(future)
    assert not answer.success
    assert "no usable message on pneumaticbox/state" in answer.message


# ---------------------------------------------------------------- diagnostics and parameters
def test_a_message_that_cannot_be_used_is_refused_and_named_in_diagnostics(start, bench, peer):
    bench("--factor", "2", "--spoil-every", "7")
    start()
    assert peer.answer(peer.grasp()).success
    status = peer.diagnosis("refused scene/object_pose: pose.position")
    assert status.level == b"\x01"
    refused = {pair.key: pair.value for pair in status.values}["refused scene/object_pose"]
    assert int(refused) > 5


def test_diagnostics_come_once_a_second_with_the_phase(start, bench, peer):
    bench("--factor", "0.2")
    start()
    peer.grasp()
    status = peer.diagnosis("test_grasp: approach")
    assert status.name == "grasp_sequencer: sequencer"
    assert status.hardware_id == "rbo_hand_2"
    assert status.level == b"\x00"
    arrays = peer.listen(DiagnosticArray, "/diagnostics")
    del arrays[:]
    peer.spin(4.0)
    own = [array for array in arrays if array.status[0].name == status.name]
    assert len(own) in (3, 4, 5)


def test_wall_time_beside_a_simulator_is_told(start, bench, peer):
    bench()
    start(use_sim_time=False)
    assert "use_sim_time is false" in peer.diagnosis("/clock").message


@pytest.mark.parametrize(
    ("parameters", "words"),
    [
        ({"hand": "fist"}, "rbo_hand_2"),
        ({"abort_action": "drop"}, "expected one of vent, hold"),
        ({"control_step": 5.0}, "control_step"),
    ],
)
def test_a_start_with_a_parameter_that_cannot_be_used_says_so_in_one_line(
    parameters, words, domain, monkeypatch, capfd
):
    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
    line = refusal(NodeCommand("sequencer", MODULE, parameters), capfd)
    assert line.startswith("sequencer: ")
    assert words in line


# ---------------------------------------------------------------- the end
SIGNALS = {"SIGTERM": [signal.SIGTERM], "double SIGINT": [signal.SIGINT, signal.SIGINT]}


def assert_ended_in_order(process):
    assert process.wait(10.0) == 0, process.output()
    for words in ("Traceback", "terminate called", "core dumped", "rcl_shutdown"):
        assert words not in process.output()


@pytest.mark.parametrize("signals", SIGNALS.values(), ids=SIGNALS.keys())
def test_a_signal_in_mid_grasp_vents_and_ends_the_node_in_order(start, bench, peer, signals):
    bench("--factor", "1")
    process = start()
    peer.grasp()
    peer.await_phase("close")
    for number in signals:
        process.send(number)
    assert_ended_in_order(process)
    peer.wait(lambda: peer.vents, "the vent")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_idle_node_in_order(start, peer, number):
    process = start()
    peer.diagnosis("idle")
    process.send(number)
    assert_ended_in_order(process)


def test_the_shipped_configuration_is_accepted_and_names_every_parameter(launcher, bench, peer):
    config = Path(__file__).parents[3] / "src" / "grasp_strategies" / "config" / "sequencer.yaml"
    bench("--factor", "5")
    arguments = ("--ros-args", "--params-file", str(config))
    launcher.start(NodeCommand("sequencer", MODULE, arguments=arguments))
    assert peer.diagnosis("idle").hardware_id == "rbo_hand_2"
    shipped = yaml.safe_load(config.read_text())["/**"]["ros__parameters"]
    names = {f"strategy.{name}" for name in shipped.pop("strategy")} | set(shipped)
    assert names == {parameter.name for parameter in PARAMETERS} | {"use_sim_time"}


# ---------------------------------------------------------------- alone, to the end of the module
@pytest.fixture(scope="module")
def plain(domain, tmp_path_factory):
    """The sequencer as it is started without parameters, alone."""
    folder = tmp_path_factory.mktemp("plain")
    with ForkingLauncher(folder, node_environment(folder, domain)) as launcher:
        yield launcher.start(NodeCommand("sequencer", MODULE))


def test_started_plainly_it_follows_simulated_time_and_tells_that_the_clock_stands(plain, peer):
    assert "/clock has stood still" in peer.diagnosis("/clock").message


def test_parameters_are_declared_with_text_unit_and_range(plain, peer):
    names = ["connect_time_out", "abort_action", "lower_and_release", "strategy.push", "hand"]
    service = "grasp_sequencer/describe_parameters"
    described = {d.name: d for d in peer.call(DescribeParameters, service, names=names).descriptors}
    assert set(described) == set(names)
    assert all(descriptor.description for descriptor in described.values())
    time_out = described["connect_time_out"]
    assert "wall time" in time_out.description
    assert "[s]" in time_out.description
    assert time_out.floating_point_range[0].to_value == 120.0
    assert described["hand"].read_only


def test_parameters_that_cannot_be_used_are_refused(plain, peer):
    changes = {"abort_action": "drop", "control_step": 5.0, "hand": "rbo_hand_1"}
    messages = [Parameter(name, value=value).to_parameter_msg() for name, value in changes.items()]
    service = "grasp_sequencer/set_parameters"
    results = peer.call(SetParameters, service, parameters=messages).results
    assert not any(result.successful for result in results)
    reasons = ("expected one of vent, hold, got 'drop'", "range", "read-only")
    for result, reason in zip(results, reasons, strict=True):
        assert reason in result.reason
