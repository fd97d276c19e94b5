"""A second driver on one set of topics names the first and does not start, unless it is told to."""

import signal

import pytest
from plant_peer import BOX, MODULE

from softhand_bringup.processes.launcher import NodeCommand

pytestmark = pytest.mark.system

WORDS = "another driver publishes /pneumaticbox/state: end it, or give each a namespace"


def test_a_second_driver_does_not_start_unless_it_is_told_to(launcher, peer):
    def start(name, **parameters):
        return launcher.start(NodeCommand(name, MODULE, {**BOX, **parameters}))

    first = start("first")
    peer.connect()
    later = start("later")
    assert later.wait(20.0) == 2, later.output()
    assert later.last_words().startswith(f"pneumaticbox: {WORDS}")
    assert "allow_second" in later.last_words()
    peer.run(0.1)
    assert first.exit_code is None
    told = start("told", allow_second=True)
    peer.wait(lambda: peer.node.count_publishers("pneumaticbox/state") == 2, "both")
    peer.diagnosis("commands", WORDS, keep_going=False)
    assert told.exit_code is None


def test_a_driver_starts_again_at_once_after_the_first_was_killed(launcher, peer):
    command = NodeCommand("driver", MODULE, {**BOX, "backend": "embedded"})
    first = launcher.start(command)
    peer.wait(lambda: peer.states, "a state")
    first.send(signal.SIGKILL)
    first.wait(5.0)
    again = launcher.start(command)
    peer.spin(0.5)
    peer.states.clear()
    peer.wait(lambda: peer.states, "a state of the new driver")
    assert again.exit_code is None
