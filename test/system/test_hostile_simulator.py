"""No message ends the simulator; one that has diverged stands, says so, and begins anew."""

import math
from dataclasses import replace

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool, Trigger
from suite_peer import CHANNELS, PATIENCE, status_text

from softhand_bringup.processes import suite

HUGE, ENDLESS = 1e308, math.inf
DOWN = (0.0, 0.83205, 0.0, 0.5547)  # a unit quaternion
LONGEST_LINE = 500  # characters
POSES = [
    ((HUGE, 0.0, 0.2), DOWN),
    ((0.0, -HUGE, 0.2), DOWN),
    ((2.1, 0.0, 0.2), DOWN),
    ((ENDLESS, 0.0, 0.2), DOWN),
    ((0.0, 0.0, math.nan), DOWN),
    ((0.0, 0.0, 0.2), (0.0, 0.0, 0.0, 0.0)),
    ((0.0, 0.0, 0.2), (math.nan, 0.0, 0.0, 1.0)),
    ((0.0, 0.0, 0.2), (HUGE, HUGE, 0.0, 1.0)),
]
VALVES = [
    (CHANNELS, [1.0, 1.0]),
    (CHANNELS, []),
    (CHANNELS, [0.5, 0.0, 0.0, 0.0]),
    (CHANNELS, [math.nan, 0.0, 0.0, 0.0]),
    (CHANNELS, [HUGE, 0.0, 0.0, 0.0]),
    ([], [0.0] * 4),
    (["a", "b", "c", "z"], [0.0] * 4),
    (["x" * 1_000_000], [1.0]),
]


def target(position, orientation=DOWN, frame="world"):
    """A target of the wrist."""
    message = PoseStamped()
    message.header.frame_id = frame
    place, rotation = message.pose.position, message.pose.orientation
    place.x, place.y, place.z = position
    rotation.x, rotation.y, rotation.z, rotation.w = orientation
    return message


def send(peer, kind, topic, messages):
    for message in messages:
        peer.publish(kind, topic, message)
        peer.spin(0.03)


def simulation_status(peer, limit=PATIENCE):
    """The simulator's next report on itself: level and text."""
    arrays = peer.listen(DiagnosticArray, "/diagnostics")
    del arrays[:]

    def told():
        for array in arrays:
            for status in array.status:
                if status.name == "hand_sim: simulation":
                    return status.level[0], status_text(status)
        return None

    return peer.wait(told, "a report of the simulator", limit)


def test_no_message_and_no_call_ends_the_simulator_and_what_is_refused_is_counted(
    launcher, peer, options
):
    process = launcher.start(suite.simulator(options))
    peer.wait(peer.time, "a tick of /clock")
    send(peer, PoseStamped, "wrist/target_pose", [target(*pose) for pose in POSES])
    send(peer, PoseStamped, "wrist/target_pose", [target((0.0, 0.0, 0.2), frame="x" * 1_000_000)])
    wrong = [JointState(name=names, position=position) for names, position in VALVES]
    for message in wrong:
        message.header.stamp.sec = -(2**31)
    send(peer, JointState, "pneumaticbox/valves", wrong)
    refused = len(POSES) + 1 + len(VALVES)
    assert f"refused messages: {refused}" in simulation_status(peer)[1]
    future = JointState(name=CHANNELS, position=[0.0] * 4)
    future.header.stamp.sec = 2**31 - 1
    send(peer, JointState, "pneumaticbox/valves", [future])
    assert not peer.trigger("sim/step").success
    for on in (True, True, False, False):
        assert peer.call(SetBool, "sim/pause", data=on).success
    assert peer.trigger("sim/reset").success
    peer.pass_time(0.1)
    assert process.exit_code is None, process.output()
    assert max(map(len, process.output().splitlines())) < LONGEST_LINE


@pytest.fixture
def stiff(launcher, options):
    """Three nodes, the wrist's spring strong enough to tear the hand apart; the simulator."""
    simulator, *others = suite.three_nodes(options)
    strong = {"wrist_stiffness": 1e5, "wrist_force_limit": 1e4}
    process = launcher.start(replace(simulator, parameters={**simulator.parameters, **strong}))
    for command in others:
        launcher.start(command)
    return process


def test_a_simulation_that_diverged_stands_until_a_reset_and_the_grasp_says_why(stiff, peer):
    peer.wait_for_driver()
    answer = peer.grasp()
    peer.wait(lambda: "approach" in peer.phases(), "the grasp to begin")
    for sign in (1.0, -1.0) * 20:
        send(peer, PoseStamped, "wrist/target_pose", [target((2.0 * sign, 0.0, 2.0 * sign))])
        if "diverged" in stiff.output():
            break
    level, text = simulation_status(peer)
    assert level == 2
    assert "the simulation diverged" in text
    assert "until sim/reset" in text
    peer.spin(0.5)  # until the last tick has come
    before = peer.time()
    refusal = peer.wait(answer.done, "the grasp's answer") and answer.result()
    assert not refusal.success
    # a hand that is torn squeezes its air before it diverges: the driver may have spoken first
    reasons = ("the simulator reports: the simulation diverged", "pressure far above its limit")
    assert any(reason in refusal.message for reason in reasons), refusal.message
    assert not peer.trigger("sim/step").success
    assert peer.time() == before
    assert stiff.exit_code is None
    # it begins anew
    assert peer.trigger("sim/reset").success
    peer.wait(lambda: peer.time() != before, "the clock to go on")
    peer.pass_time(0.2)
    assert simulation_status(peer)[0] < 2
    assert peer.call(Trigger, "pneumaticbox/reset").success
    peer.command([2e-5, 0.0, 0.0, 0.0])
    peer.wait(lambda: peer.state().position[0] > 1.5e-5, "channel a to be filled")
