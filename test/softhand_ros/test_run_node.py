"""Start and end of a node's process: help, exit status, one line for what is wrong."""

import gc
import os
import signal
import subprocess
import sys
import threading

import pytest
from rclpy.node import Node
from ros_peer import Peer
from std_msgs.msg import String

from softhand_ros.run_node import ENDING, IGNORED, run_node

pytestmark = pytest.mark.system


class Part:
    """Stands for a node."""

    def __init__(self):
        self.closed = False

    def close(self):
        self.closed = True


@pytest.fixture(autouse=True)
def handlers(domain, monkeypatch):
    """The signals' handlers as they were, and a ROS domain of its own."""
    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
    before = {number: signal.getsignal(number) for number in (*ENDING, *IGNORED)}
    signal.signal(signal.SIGHUP, signal.SIG_DFL)  # the tests may run under nohup
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


def failing(error):
    def serve(_, __):
        raise error

    return serve


@pytest.mark.parametrize("number", ENDING)
def test_a_signal_ends_the_node_in_order(number):
    part = Part()

    def serve(_, stop):
        threading.Timer(0.1, os.kill, (os.getpid(), number)).start()
        assert stop.wait(10.0)

    assert run_node("part", lambda: part, serve, args=[]) == 0
    assert part.closed


def test_what_a_terminal_sends_does_not_stop_a_node_that_may_have_to_vent():
    seen = []

    def serve(_, stop):
        for number in (signal.SIGTSTP, signal.SIGTTIN):
            os.kill(os.getpid(), number)  # the test itself would stand still
        seen.append(stop.is_set())

    assert run_node("part", Part, serve, args=[]) == 0
    assert seen == [False]


def test_under_nohup_a_node_outlives_its_terminal():
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    seen = []

    def serve(_, stop):
        os.kill(os.getpid(), signal.SIGHUP)
        seen.append(stop.wait(0.3))

    assert run_node("part", Part, serve, args=[]) == 0
    assert seen == [False]


@pytest.mark.parametrize(
    ("error", "status"),
    [(ValueError("hand: got x"), 2), (OSError("no board"), 2), (KeyError("diverged"), 1)],
)
def test_an_error_is_one_line_with_the_name_and_gives_the_status(error, status, capsys):
    part = Part()
    done = run_node("part", lambda: part, failing(error), args=[], failures=(KeyError,))
    assert done == status
    assert part.closed
    assert capsys.readouterr().err == f"part: {error}\n"


class Refusing(Node):
    """A node that publishes a topic, which `found` awaits, when it turns out not to be possible."""

    def __init__(self, found):
        super().__init__("refusing")
        self.create_publisher(String, "left_over", 1)
        self.create_subscription(String, "heard", self.hear, 1)
        found()
        raise ValueError("hand: got x")

    def hear(self, _):
        """Unused; as a callback it refers to the node, which refers to it."""


def test_a_node_that_could_not_be_made_leaves_nothing_that_others_find(domain, tmp_path):
    peer = Peer(domain, tmp_path)

    def published(count):
        peer.wait(lambda: peer.node.count_publishers("left_over") == count, f"{count} there")

    gc.disable()  # only what the end of the node does itself counts
    try:
        assert run_node("part", lambda: Refusing(lambda: published(1)), None, args=[]) == 2
        published(0)
    finally:
        gc.enable()
        peer.close()


def test_what_is_nobodys_fault_is_not_swallowed_but_the_node_is_closed():
    part = Part()
    with pytest.raises(RuntimeError, match="unexpected"):
        run_node("part", lambda: part, failing(RuntimeError("unexpected")), args=[])
    assert part.closed


def test_the_help_is_printed_without_making_a_node(capsys):
    made = []
    assert run_node("part", lambda: made.append(1), None, usage="usage: part", args=["-h"]) == 0
    assert capsys.readouterr().out == "usage: part\n"
    assert not made


HANGING = """
import sys, time
from softhand_ros.run_node import ENDING, IGNORED, run_node

class Part:
    def close(self):
        print("closing", flush=True)
        time.sleep(60)

def make():
    if sys.argv[1] == "made":
        print("making", flush=True)
        time.sleep(60)
    return Part()

def serve(part, stop):
    print("serving", flush=True)
    stop.wait(60) if sys.argv[1] == "closed" else time.sleep(60)

sys.exit(run_node("part", make, serve, args=[]))
"""


@pytest.mark.parametrize(
    ("state", "signals", "status"),
    [
        ("made", [signal.SIGINT], 0),
        ("made", [signal.SIGTERM], 0),
        ("served", [signal.SIGTERM], 1),
        ("closed", [signal.SIGTERM, signal.SIGTERM], 1),
        ("closed", [signal.SIGINT, signal.SIGTERM], 1),
    ],
)
def test_a_node_that_hangs_is_ended_by_force(state, signals, status):
    line = [sys.executable, "-c", HANGING, state]
    pipe = subprocess.PIPE
    with subprocess.Popen(line, stdout=pipe, stderr=pipe, text=True) as process:
        process.stdout.readline()
        process.send_signal(signals[0])
        if state == "closed":
            assert process.stdout.readline() == "closing\n"
            process.send_signal(signals[1])
        assert process.wait(20.0) == status
        forced = "part: not closed 1.7 s after the signal: ended by force\n"
        assert process.stderr.read() == (forced if status else "")
