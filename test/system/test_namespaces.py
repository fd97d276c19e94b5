"""Two hands side by side: each in its namespace, both by the clock of one simulator."""

import statistics
import time
from dataclasses import replace

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseArray
from ros_peer import seconds
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Header
from std_srvs.srv import SetBool, Trigger
from suite_peer import CHANNELS, PATIENCE

from grasp_strategies.ros.interface import OFFERS as OF_THE_SEQUENCER
from model_lab.ros.interface import OFFERS as OF_THE_MONITOR
from pneuflex_sim.ros.clock import FOLLOWERS
from pneuflex_sim.ros.interface import OFFERS as OF_THE_SIMULATOR
from pneumaticbox_driver.ros.interface import OFFERS as OF_THE_DRIVER
from softhand_bringup.processes import suite

HANDS = ("left", "right")
GRASP_LIMIT = 240.0  # [s] of wall time for both
OFFERS = {
    "hand_sim": OF_THE_SIMULATOR,
    "pneumaticbox": OF_THE_DRIVER,
    "grasp_sequencer": OF_THE_SEQUENCER,
    "monitor": OF_THE_MONITOR,
}
OF_EVERY_NODE = (
    "/rosout",
    "/parameter_events",
    *(f"_{way}" for way in ("parameters", "parameters_atomically", "parameter_types")),
    "_type_description",
)
LEFT_OUT = {  # by the name of the node
    # messages that are not on PyPI, and what a simulator does with another's clock
    "hand_sim": {"pub /tf", "sub /clock", "pub /clock_followers"},
    "grasp_sequencer": {"pub pneumaticbox/command"},  # only while a strategy runs
}


@pytest.fixture
def hands(launcher):
    """Six nodes: the left hand's simulator is the clock; processes by name."""
    common = suite.SuiteOptions(step=0.004)
    left = replace(common, namespace="left")
    right = replace(common, namespace="right", publish_clock=False)
    commands = [*suite.three_nodes(left), *suite.three_nodes(right)]
    return {command.name: launcher.start(command) for command in commands}


def heard(peer, kind, topic):
    """Wait for the next message of a topic."""
    messages = peer.listen(kind, topic)
    del messages[:]
    return peer.wait(lambda: messages and messages[-1], f"a message on {topic}")


def told_by(peer, name):
    """The next diagnostic status of that name."""
    arrays = peer.listen(DiagnosticArray, "/diagnostics")
    del arrays[:]

    def found():
        return next((s for array in arrays for s in array.status if s.name == name), None)

    return peer.wait(found, f"a status of {name}")


def test_two_hands_grasp_at_once_by_one_clock(hands, peer):
    ticks = peer.listen(Clock, "/clock")
    for hand in HANDS:  # the strategy waits for 10 s; six nodes may start for longer
        peer.wait(
            lambda hand=hand: peer.listen(JointState, f"{hand}/pneumaticbox/state"),
            f"the {hand} driver",
            PATIENCE,
        )
    followers = peer.listen(Header, FOLLOWERS)
    peer.wait(lambda: followers, "the right hand's time, for which the left one waits", PATIENCE)
    calls = [peer.request(Trigger, f"{hand}/grasp/surface_constrained", PATIENCE) for hand in HANDS]
    samples = [peer.listen(JointState, f"{hand}/pneumaticbox/sensors", 1) for hand in HANDS]
    lags, answered = [], []
    end = time.monotonic() + GRASP_LIMIT
    while len(answered) < len(calls):
        assert time.monotonic() < end, [process.last_words() for process in hands.values()]
        peer.spin(0.2)
        answered = [call for call in calls if call.done()]
        if ticks and all(samples):
            first, second = (seconds(times[-1].header.stamp) for times in samples)
            lags.append(abs(first - second))
    for hand, call in zip(HANDS, calls, strict=True):
        assert call.result().success, f"{hand}: {call.result().message}"
    assert peer.node.count_publishers("/clock") == 1
    joined = next(k for k, lag in enumerate(lags) if lag < 0.1)  # it may have started later
    # the middle of them: a busy machine may hold one of the two up at any moment
    assert statistics.median(lags[joined:]) < 0.1
    stamps = [seconds(tick.clock) for tick in ticks]
    assert stamps == sorted(stamps)
    for hand in HANDS:
        tips = heard(peer, PoseArray, f"{hand}/hand/fingertips")
        assert tips.header.frame_id == f"{hand}/wrist"
        status = told_by(peer, f"{hand}/hand_sim: simulation")
        assert status.hardware_id == f"{hand}/pneuflex_sim"
        assert told_by(peer, f"{hand}/pneumaticbox: safety").level == b"\x00"
    # the one that follows is not paused; a reset leaves its time, which is the other's
    refused = peer.call(SetBool, "right/sim/pause", data=True)
    assert not refused.success
    assert "pause the simulation that publishes it" in refused.message
    now = ticks[-1].clock.sec
    assert peer.trigger("right/sim/reset").success
    assert heard(peer, JointState, "right/pneumaticbox/sensors").header.stamp.sec >= now


def offered(peer, name, namespace):
    """What a running node offers, as way and name; nothing before it is discovered."""
    node = peer.node
    found = {
        "pub": node.get_publisher_names_and_types_by_node,
        "sub": node.get_subscriber_names_and_types_by_node,
        "srv": node.get_service_names_and_types_by_node,
    }
    if (name, namespace) not in node.get_node_names_and_namespaces():
        return set()
    return {
        f"{way} {topic.removeprefix(f'{namespace}/')}"
        for way, look in found.items()
        for topic, _ in look(name, namespace)
        if not topic.endswith(OF_EVERY_NODE)
    }


def described(name):
    """What the help of a node tells, as way and name."""
    told = {(offer.way, offer.name) for offer in OFFERS[name] if offer.way != "action"}  # optional
    return {
        f"{way} {topic.replace('<channel>', channel)}"
        for way, topic in told
        for channel in CHANNELS
    }


def test_nodes_in_a_namespace_offer_what_their_help_tells_and_name_a_second_clock(launcher, peer):
    options = suite.SuiteOptions(namespace="robot/left")
    for command in suite.three_nodes(options):
        launcher.start(command)
    launcher.start(
        replace(suite.monitor(options, {"shadow": True}), remappings={"__ns": "/robot/left"})
    )
    peer.wait(
        lambda: peer.listen(JointState, "robot/left/pneumaticbox/state"), "the driver", PATIENCE
    )
    for name in OFFERS:
        expected = described(name) - LEFT_OUT.get(name, set())
        found = set()

        def complete(name=name, expected=expected):
            nonlocal found
            found = offered(peer, name, "/robot/left")
            return found == expected

        end = time.monotonic() + 20.0
        while not complete() and time.monotonic() < end:
            peer.spin(0.2)
        assert found == expected, name
    second, *_ = suite.three_nodes(suite.SuiteOptions(namespace="right"))
    launcher.start(second)
    for name in (
        "right/hand_sim: simulation",
        "robot/left/hand_sim: simulation",
        "robot/left/pneumaticbox: sensors",
        "robot/left/grasp_sequencer: sequencer",
    ):
        peer.diagnosis(name, "two nodes publish /clock", "publish_clock:=false", limit=PATIENCE)
