"""The driver on the simulated board, through the shipped examples: told to open, ended, used again.

How fast it is, in each control mode and for each fault, is measured by `bench.robust.boards`.
"""

import os
import signal

import pytest
from board_process import EXAMPLES, BoardProcess
from forked_nodes import ForkingLauncher
from plant_peer import BOX, MG, MODULE
from std_srvs.srv import Trigger

from softhand_bringup.processes.launcher import NodeCommand
from softhand_bringup.processes.suite import node_environment

pytestmark = pytest.mark.system


@pytest.fixture
def on_board(domain, tmp_path, peer):
    """Starts the driver on a board behind a link; board and process."""
    environment = node_environment(tmp_path / "log", domain)
    path = [str(EXAMPLES), environment.get("PYTHONPATH", "")]
    environment["PYTHONPATH"] = os.pathsep.join(filter(None, path))
    boards = []

    with ForkingLauncher(tmp_path / "log", environment) as launcher:

        def start(link):
            boards.append(BoardProcess(link, tmp_path, options=["--volumes", "1e-4", "1e-4"]))
            file = str(boards[0].hardware_file)
            parameters = {**BOX, "backend": "hardware", "hardware_file": file}
            parameters |= {"allow_board_module": True, "embedded_rate": 200.0}
            parameters["start_enabled"] = True
            return boards[0], launcher.start(NodeCommand("driver", MODULE, parameters))

        yield start
    for board in boards:
        with board:
            pass


def inflate(peer, board):
    """Reset the driver and send masses until the board is told to inflate."""

    def inflated():
        peer.call(Trigger, "pneumaticbox/reset")
        peer.call(Trigger, "pneumaticbox/tare")
        peer.command(80 * MG, 80 * MG)
        for _ in range(25):  # an inlet is open for a while only
            peer.spin(0.02)
            if board.inflating:
                return True
        return False

    peer.wait(inflated, "an inlet that opens")


@pytest.mark.parametrize(
    ("link", "fault", "said"),
    [
        ("TCP", "hang", "the board does not answer"),
        ("TCP", "huge", "no absolute pressure is 1e+300 Pa"),
        ("serial", "restart", "the connection to the board is lost"),
        ("serial", "refuse", "the board has not taken the valves"),
    ],
)
def test_a_board_that_fails_is_told_to_open_and_is_used_again(on_board, peer, link, fault, said):
    board, process = on_board(link)
    inflate(peer, board)
    board.switch(fault)
    peer.diagnosis("safety", said, keep_going=False)
    peer.wait(lambda: board.opened is not None, "open outlets")
    assert peer.call(Trigger, "pneumaticbox/vent").success
    board.switch("none")
    peer.spin(1.0)
    assert board.opened is not None  # until the reset
    inflate(peer, board)
    board.switch("hang")
    process.send(signal.SIGTERM)
    assert process.wait(10.0) == 0, process.output()
    peer.wait(lambda: board.opened is not None, "open outlets")
    assert "Traceback" not in process.output()
