"""Start and end of a node's process: help, exit status, one line for what is wrong."""

import os
import signal
import threading

import pytest

from softhand_ros.run_node import run_node

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
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


def failing(error):
    def serve(_, __):
        raise error

    return serve


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_node_in_order(number):
    part = Part()

    def serve(_, stop):
        threading.Timer(0.1, os.kill, (os.getpid(), number)).start()
        assert stop.wait(10.0)

    assert run_node("part", lambda: part, serve, args=[]) == 0
    assert part.closed


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
