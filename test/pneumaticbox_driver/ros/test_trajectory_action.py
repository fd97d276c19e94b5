"""The driver's action for trajectories, by goals of real types that the test builds."""

import contextlib
import time

import numpy as np
import pytest
from action_calls import Goal, check_nothing_offered, environment_with, folder_without_types
from action_msgs.msg import GoalStatus
from forked_nodes import ForkingLauncher
from plant_peer import BOX, MG, MODULE
from ros_peer import PATIENCE
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectoryPoint

from softhand_bringup.processes.launcher import NodeCommand, stop_process

pytestmark = [pytest.mark.system, pytest.mark.timeout(400)]
ACTION = "pneumaticbox/follow_joint_trajectory"


@pytest.fixture
def start_with(domain, tmp_path):
    """Start the driver with a folder on its PYTHONPATH."""

    def start(folder, **parameters):
        environment = environment_with(tmp_path / "log", domain, folder)
        launcher = made.enter_context(ForkingLauncher(tmp_path / "log", environment))
        values = {**BOX, "use_sim_time": True, **parameters}
        return launcher.start(NodeCommand("driver", MODULE, values))

    with contextlib.ExitStack() as made:
        yield start


@pytest.fixture
def codes(control_types):
    """Error codes of results."""
    return control_types[0].FollowJointTrajectory.Result


@pytest.fixture
def begin(start_with, control_types, peer):
    """Start the driver, send a goal; both go on while the samples do."""
    kind, folder = control_types[0].FollowJointTrajectory, control_types[1]

    def start(**parameters):
        process = start_with(folder, **parameters)
        peer.connect()
        return process

    def send(*points, names=("a", "b"), **fields):
        goal = kind.Goal(**fields)
        goal.trajectory.joint_names = list(names)
        for when, values in points:
            point = JointTrajectoryPoint(positions=[float(value) for value in values])
            point.time_from_start.sec, rest = divmod(round(when * 1e9), 10**9)
            point.time_from_start.nanosec = rest
            goal.trajectory.points.append(point)
        return Goal(peer, kind, ACTION, goal, wait)

    def wait(condition, what):
        end = time.monotonic() + PATIENCE
        while not condition():
            assert time.monotonic() < end, f"not within {PATIENCE} s: {what}"
            peer.step(0.01)
            peer.spin(0.005)

    return start, send, wait


def test_masses_follow_a_trajectory(begin, codes, peer):
    start, send, _ = begin
    start()
    goal = send((1.0, (20 * MG, 0)), (2.0, (20 * MG, 30 * MG)))
    status, result = goal.result()
    assert (status, result.error_code) == (GoalStatus.STATUS_SUCCEEDED, codes.SUCCESSFUL)
    np.testing.assert_allclose(peer.mass(), [20 * MG, 30 * MG], atol=5 * MG)
    halfway = [f.desired.positions[0] for f in goal.feedback]
    assert any(5 * MG < value < 15 * MG for value in halfway)
    last = goal.feedback[-1]
    assert list(last.joint_names) == ["a", "b"]
    np.testing.assert_allclose(
        np.subtract(last.desired.positions, last.actual.positions), last.error.positions
    )


def test_pressures_are_taken_from_positions(begin, peer):
    start, send, _ = begin
    start(control_mode=["pressure"])
    status, _ = send((1.0, (30e3,)), names=("a",)).result()
    assert status == GoalStatus.STATUS_SUCCEEDED
    assert peer.plant.pressures[0] - 101.3e3 == pytest.approx(30e3, abs=6e3)


@pytest.mark.parametrize("action", ["hold", "vent"])
def test_a_cancel_holds_or_vents(begin, peer, action):
    start, send, _ = begin
    start(cancel_action=action)
    goal = send((0.5, (30 * MG, 30 * MG)), (30.0, (30 * MG, 0)))
    for _ in range(20):  # a busy machine hears of the goal late
        peer.run(0.5, 0.01)
        if peer.mass().min() > 25 * MG:
            break
    goal.cancel()
    status, result = goal.result()
    assert status == GoalStatus.STATUS_CANCELED and result.error_string.startswith("cancelled: ")
    peer.run(1.0, 0.01)
    held = peer.mass()
    peer.run(1.5, 0.01)
    if action == "hold":
        np.testing.assert_allclose(peer.mass(), held, atol=1 * MG)
        assert held.min() > 20 * MG
    else:
        assert peer.mass().max() < 2 * MG


def test_what_is_wrong_is_told_in_the_result(begin, codes, peer):
    start, send, _ = begin
    start()
    status, result = send((1.0, (1 * MG,)), names=("thumb",)).result()
    assert (status, result.error_code) == (GoalStatus.STATUS_ABORTED, codes.INVALID_JOINTS)
    assert "thumb" in result.error_string
    status, result = send((1.0, (1.0, 0.0))).result()
    assert (status, result.error_code) == (GoalStatus.STATUS_ABORTED, codes.INVALID_GOAL)
    assert "points[0].positions[0]" in result.error_string


def test_a_new_goal_ends_the_one_before_and_a_vent_ends_both(begin, peer):
    start, send, _ = begin
    process = start()
    first = send((20.0, (30 * MG, 30 * MG)))
    second = send((20.0, (10 * MG, 10 * MG)))
    status, result = first.result()
    assert (status, result.error_string) == (GoalStatus.STATUS_ABORTED, "another goal has come")
    peer.call(Trigger, "pneumaticbox/vent")
    status, result = second.result()
    assert status == GoalStatus.STATUS_ABORTED and "vent was requested" in result.error_string
    assert stop_process(process) == 0 and "Traceback" not in process.output()


def test_far_from_the_path_it_stops_and_holds(begin, codes, peer):
    from control_msgs import msg as types

    start, send, _ = begin
    start()
    tolerance = types.JointTolerance(name="a", position=1 * MG)
    goal = send((0.2, (30 * MG, 0)), (3.0, (30 * MG, 0)), path_tolerance=[tolerance])
    status, result = goal.result()
    assert (status, result.error_code) == (
        GoalStatus.STATUS_ABORTED,
        codes.PATH_TOLERANCE_VIOLATED,
    )
    assert "channel a is off by" in result.error_string
    peer.run(0.5, 0.01)
    held = peer.mass()
    peer.run(1.0, 0.01)
    np.testing.assert_allclose(peer.mass(), held, atol=1 * MG)
    assert held[0] < 25 * MG


def test_a_command_on_the_topic_ends_the_goal(begin, peer):
    start, send, wait = begin
    start()
    goal = send((20.0, (30 * MG, 30 * MG)))
    wait(lambda: goal.feedback, "feedback")
    peer.command(10 * MG, 10 * MG)
    status, result = goal.result()
    assert status == GoalStatus.STATUS_ABORTED and "on a topic" in result.error_string
    peer.run(1.0, 0.01)
    np.testing.assert_allclose(peer.mass(), 10 * MG, atol=5 * MG)


def test_without_the_types_there_is_no_action_and_commands_are_obeyed(start_with, peer, tmp_path):
    process = start_with(folder_without_types(tmp_path))
    peer.connect()
    peer.command(10 * MG, 10 * MG)
    peer.run(1.5, 0.01)
    np.testing.assert_allclose(peer.mass(), 10 * MG, atol=5 * MG)
    check_nothing_offered(peer, "pneumaticbox", process)
