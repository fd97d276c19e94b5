"""The sequencer's action for grippers, by goals of real types that the test builds."""

import contextlib
from pathlib import Path

import pytest
from action_calls import Goal, check_nothing_offered, environment_with, folder_without_types
from action_msgs.msg import GoalStatus
from forked_nodes import ForkingLauncher
from rclpy.qos import DurabilityPolicy, QoSProfile
from ros_domain import held_domain
from ros_peer import Peer
from std_msgs.msg import Int32, String
from std_srvs.srv import Trigger

from softhand_bringup.processes.launcher import NodeCommand

pytestmark = [pytest.mark.system, pytest.mark.timeout(400)]
MODULE = "grasp_strategies.ros.node"
SUPPORT = Path(__file__).parents[2] / "support"
EVERY = QoSProfile(depth=20, durability=DurabilityPolicy.TRANSIENT_LOCAL)
ACTION = "grasp_sequencer/gripper_cmd"


@pytest.fixture
def run_with(tmp_path, write_strategy):
    """Start sequencer and stand-in with a folder on their PYTHONPATH; returns the test's node and
    the sequencer.
    """
    with held_domain() as domain, contextlib.ExitStack() as made:
        peer = made.enter_context(contextlib.closing(Peer(domain, tmp_path)))
        peer.phases = peer.listen(String, "grasp/phase", EVERY)
        peer.vents = peer.listen(Int32, "mock/vents", EVERY)

        def start(folder, *bench, **parameters):
            environment = environment_with(tmp_path / "log", domain, SUPPORT, folder)
            launcher = made.enter_context(ForkingLauncher(tmp_path / "log", environment))
            launcher.start(NodeCommand("bench", "mock_bench", arguments=("--factor", "2", *bench)))
            shipped = {"strategy.surface_constrained": str(write_strategy())}
            values = {"use_sim_time": True, **shipped, **parameters}
            return peer, launcher.start(NodeCommand("sequencer", MODULE, values))

        yield start


@pytest.fixture
def run(run_with, control_types):
    """Start both where the types are; returns the test's node."""

    def start(*bench, **parameters):
        return run_with(control_types[1], *bench, **parameters)[0]

    return start


@pytest.fixture
def types(control_types):
    """The types of actions."""
    return control_types[0]


def command(types, position):
    goal = types.GripperCommand.Goal()
    goal.command.position = position
    return goal


def test_a_goal_closes_and_holds_on_and_another_opens(types, run):
    peer = run()
    kind = types.GripperCommand
    goal = Goal(peer, kind, ACTION, command(types, 0.0))
    status, result = goal.result()
    assert status == GoalStatus.STATUS_SUCCEEDED
    assert (result.stalled, result.reached_goal) == (True, True)
    assert result.position == 0.0
    told = [feedback.position for feedback in goal.feedback]
    assert told == sorted(told, reverse=True) and 0.0 < told[0] < 1.0 and len(told) >= 4
    assert goal.feedback[-1].effort > 1e3
    assert "lower" not in [message.data for message in peer.phases]  # it is held until it is opened
    goal = Goal(peer, kind, ACTION, command(types, 1.0))
    status, result = goal.result()
    assert status == GoalStatus.STATUS_SUCCEEDED
    assert (result.stalled, result.reached_goal) == (False, True)
    assert result.position == 1.0 and result.effort < 3e3


def test_what_slips_from_the_hand_does_not_stall(types, run):
    peer = run("--slip", "0.05")
    status, result = Goal(peer, types.GripperCommand, ACTION, command(types, 0.0)).result()
    assert status == GoalStatus.STATUS_ABORTED
    assert (result.stalled, result.reached_goal) == (False, False)


@pytest.mark.parametrize(("action", "vents"), [("vent", 1), ("hold", 0)])
def test_a_cancel_vents_or_holds(types, run, action, vents):
    peer = run(abort_action=action)
    goal = Goal(peer, types.GripperCommand, ACTION, command(types, 0.0))
    peer.wait(lambda: "lift" in [m.data for m in peer.phases], "the lift")
    second = Goal(peer, types.GripperCommand, ACTION, command(types, 0.0))
    assert not second.accepted
    assert len(goal.cancel().goals_canceling) == 1
    status, result = goal.result()
    assert (status, result.reached_goal) == (GoalStatus.STATUS_CANCELED, False)
    peer.spin(0.3)
    assert (peer.vents[-1].data if peer.vents else 0) == vents


def test_a_parallel_gripper_has_names_and_takes_one_number(types, run):
    peer = run(gripper_type="ParallelGripperCommand")
    kind = types.ParallelGripperCommand
    goal = kind.Goal()
    goal.command.name, goal.command.position = ["hand"], [0.0]
    status, result = Goal(peer, kind, ACTION, goal).result()
    assert (status, result.stalled) == (GoalStatus.STATUS_SUCCEEDED, True)
    assert (list(result.state.name), list(result.state.position)) == (["hand"], [0.0])
    goal.command.position = [0.0, float("nan")]
    assert not Goal(peer, kind, ACTION, goal).accepted


def test_without_the_types_there_is_no_action_and_grasps_run(run_with, tmp_path):
    peer, process = run_with(folder_without_types(tmp_path))
    assert peer.call(Trigger, "grasp/surface_constrained").success
    check_nothing_offered(peer, "grasp_sequencer", process)
