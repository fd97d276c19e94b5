"""Calls of the grasp services while things are under way."""

import signal

import pytest
from std_srvs.srv import SetBool


@pytest.fixture
def gripping(nodes, peer):
    """The peer and the future of a grasp in which the hand is being filled."""
    peer.wait_for_driver()
    answer = peer.grasp()
    peer.wait(
        lambda: answer.done() or (peer.state() and max(peer.state().effort) > 15e3),
        "a channel under pressure",
    )
    assert not answer.done(), answer.result().message
    return peer, answer


def test_abort_in_mid_grasp_vents_and_ends_the_call(gripping):
    peer, answer = gripping
    abort = peer.trigger("grasp/abort")
    assert abort.success, abort.message
    peer.wait(answer.done, "the answer of the grasp that was aborted")
    assert not answer.result().success
    assert "abort" in answer.result().message
    peer.pass_time(2.0)
    assert max(peer.state().effort) < 5e3
    assert peer.wait(peer.result, "a result")["completed"] == "False"


def test_a_driver_that_is_disabled_ends_the_grasp_at_once_with_that_reason(gripping):
    peer, answer = gripping
    assert peer.call(SetBool, "pneumaticbox/enable", data=False).success
    peer.wait(answer.done, "the answer of a grasp that cannot go on", 1.0)
    assert not answer.result().success
    assert "the driver reports: disabled" in answer.result().message


def test_when_the_sequencer_is_killed_the_driver_lets_go(nodes, gripping):
    peer, _ = gripping
    nodes["sequencer"].send(signal.SIGKILL)
    peer.diagnosis("pneumaticbox: safety", "no command for 5.0 s")
    peer.pass_time(2.0)
    assert max(peer.state().effort) < 5e3
