"""The driver's life cycle on the simulated board, which is a process of its own."""

import os
import time

import pytest
from board_process import EXAMPLES, BoardProcess
from lifecycle_msgs.msg import State, Transition, TransitionEvent
from lifecycle_msgs.srv import ChangeState, GetAvailableStates, GetState
from plant_peer import BOX, MG, MODULE
from std_srvs.srv import SetBool, Trigger

from softhand_bringup.processes.launcher import Launcher, NodeCommand, stop_process
from softhand_bringup.processes.suite import node_environment

pytestmark = pytest.mark.system


@pytest.fixture
def board(tmp_path):
    """The simulated board, behind TCP."""
    with BoardProcess("TCP", tmp_path, options=["--volumes", "1e-4", "1e-4"]) as board:
        yield board


@pytest.fixture
def start_on_board(domain, tmp_path, board):
    """Start the driver on the board."""
    environment = node_environment(tmp_path / "log", domain)
    path = [str(EXAMPLES), environment.get("PYTHONPATH", "")]
    environment["PYTHONPATH"] = os.pathsep.join(filter(None, path))
    given = {**BOX, "backend": "hardware", "hardware_file": str(board.hardware_file)}
    given |= {"allow_board_module": True, "embedded_rate": 200.0}
    with Launcher(tmp_path / "log", environment) as launcher:
        yield lambda **more: launcher.start(NodeCommand("driver", MODULE, given | more))


def change(peer, transition):
    """Ask for a transition; whether it was made."""
    kind = Transition(id=transition)
    return peer.call(ChangeState, "pneumaticbox/change_state", transition=kind).success


def state(peer):
    return peer.call(GetState, "pneumaticbox/get_state").current_state.label


def reset(peer):
    """Leave the vented state: on a busy machine the start may take so long that samples miss."""
    peer.call(Trigger, "pneumaticbox/reset")


def activates(peer):
    """Whether the transition is made from a box that is not vented."""
    reset(peer)
    return change(peer, Transition.TRANSITION_ACTIVATE)


def goes_and_comes_back(peer, by_enable=False):
    """Whether an active box activates again after it was deactivated, without a reset between."""
    if state(peer) != "active":
        activates(peer)
    if not change(peer, Transition.TRANSITION_DEACTIVATE):
        return False
    if by_enable:
        return peer.call(SetBool, "pneumaticbox/enable", data=True).success
    return change(peer, Transition.TRANSITION_ACTIVATE)


def switched_on(peer):
    """Whether `enable` is obeyed by a box that is not vented."""
    reset(peer)
    return peer.call(SetBool, "pneumaticbox/enable", data=True).success


def inflates(peer, board):
    """Whether the board is told to inflate within 2 s of a command for more air than there is."""
    reset(peer)
    peer.command(0.0, 0.0)
    peer.spin(1.0)
    begun = time.monotonic()
    peer.command(80 * MG, 80 * MG)
    while time.monotonic() < begun + 2.0 and not board.inflated_since(begun):
        peer.spin(0.1)
    return board.inflated_since(begun)


def test_air_flows_in_the_active_state_alone(start_on_board, peer, board):
    process = start_on_board()
    peer.wait(lambda: peer.states, "a state of the box, before it is active")
    events = peer.listen(TransitionEvent, "pneumaticbox/transition_event")
    assert state(peer) == "inactive"
    labels = {
        s.label
        for s in peer.call(GetAvailableStates, "pneumaticbox/get_available_states").available_states
    }
    assert {"unconfigured", "inactive", "active", "finalized"} <= labels
    assert not inflates(peer, board)
    assert not change(peer, Transition.TRANSITION_CLEANUP + 100)
    assert not change(peer, Transition.TRANSITION_CONFIGURE)  # it is configured
    peer.wait(lambda: activates(peer), "an active box")
    assert state(peer) == "active"
    peer.wait(lambda: inflates(peer, board), "an inlet that opens")
    assert change(peer, Transition.TRANSITION_DEACTIVATE)
    # not since then: a missed sample may have vented the box since it inflated
    peer.wait(lambda: board.opened is not None, "open outlets")
    vented = "safety", "vented until pneumaticbox/reset", "deactivated"  # beside missed samples
    peer.diagnosis(*vented, keep_going=False)
    # the vent was that of the state alone
    peer.wait(lambda: goes_and_comes_back(peer), "an active box after a deactivated one")
    peer.wait(lambda: inflates(peer, board), "an inlet that opens")
    assert peer.call(Trigger, "pneumaticbox/vent").success
    assert change(peer, Transition.TRANSITION_DEACTIVATE)
    assert not change(peer, Transition.TRANSITION_ACTIVATE)  # a vent that was asked for stays
    assert state(peer) == "inactive"
    assert peer.call(Trigger, "pneumaticbox/reset").success
    peer.wait(lambda: activates(peer), "an active box after the reset")
    goals = [event.goal_state.id for event in events]
    assert State.PRIMARY_STATE_ACTIVE in goals and State.PRIMARY_STATE_INACTIVE in goals
    assert stop_process(process) == 0 and "Traceback" not in process.output()


def test_after_cleanup_the_board_is_free_and_configure_connects_again(start_on_board, peer, board):
    process = start_on_board(start_enabled=True)
    peer.wait(lambda: peer.states, "a state of the box")
    assert state(peer) == "active"
    peer.wait(lambda: inflates(peer, board), "an inlet that opens")
    assert change(peer, Transition.TRANSITION_DEACTIVATE)
    assert change(peer, Transition.TRANSITION_CLEANUP)
    peer.wait(lambda: board.opened is not None, "open outlets")
    assert state(peer) == "unconfigured"
    refused = peer.call(SetBool, "pneumaticbox/enable", data=True)
    assert not refused.success and "unconfigured" in refused.message
    peer.spin(0.5)
    count = len(peer.states)
    peer.spin(1.0)
    assert len(peer.states) == count  # nothing is read
    assert change(peer, Transition.TRANSITION_CONFIGURE)
    peer.wait(lambda: len(peer.states) > count, "a state of the box")
    peer.wait(lambda: activates(peer), "an active box")
    peer.wait(lambda: inflates(peer, board), "an inlet that opens")
    assert process.exit_code is None and "Traceback" not in process.output()


def test_enable_is_the_same_as_the_transitions(start_on_board, peer, board):
    start_on_board()
    peer.wait(lambda: peer.states, "a state of the box")
    peer.wait(lambda: switched_on(peer), "an active box")
    assert state(peer) == "active"
    assert peer.call(SetBool, "pneumaticbox/enable", data=False).success
    assert state(peer) == "inactive"
    assert "deactivated" not in peer.diagnosis("safety", keep_going=False).message  # no vent
    peer.wait(lambda: switched_on(peer), "an active box")
    peer.wait(lambda: goes_and_comes_back(peer, by_enable=True), "an active box")  # its vent ends
    assert state(peer) == "active"
