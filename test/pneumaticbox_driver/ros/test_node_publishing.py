"""The node in this process, its topic of the valves cannot be published: the board comes first."""

import os
import sys

import numpy as np
import pytest
import rclpy
from rclpy.signals import SignalHandlerOptions
from ros_domain import held_domain

from pneumaticbox_driver.ros.node import PneumaticBoxNode
from softhand_bringup.processes.suite import node_environment

BOARD = """
import time
import numpy as np

class Board:
    told = []
    def __init__(self, outlets, ambient):
        self.pressures = np.full(len(outlets) + 1, ambient)
    def set_valves(self, valves):
        self.told.append(valves.tolist())
    def read(self):
        return time.monotonic(), self.pressures
    def close(self):
        self.told.append("closed")
"""
PARAMETERS = (
    "allow_board_module:=true",
    "use_sim_time:=false",
    "channels:=[a, b]",
    "rest_volumes:=[1e-4, 1e-4]",
    "pressure_limits:=[1e5, 1e5]",
)


@pytest.fixture
def node(tmp_path, monkeypatch):
    (tmp_path / "plain_board.py").write_text(BOARD)
    monkeypatch.syspath_prepend(tmp_path)
    file = tmp_path / "hardware.yaml"
    file.write_text("format: pneumaticbox-hardware/1\nboard: plain_board:Board\nvent_time: 0.0\n")
    values = (*PARAMETERS, "backend:=hardware", "start_enabled:=true")
    values += (f"hardware_file:={file}",)
    arguments = [word for value in values for word in ("-p", value)]
    with held_domain() as domain:
        for name, value in node_environment(tmp_path, domain).items():
            monkeypatch.setitem(os.environ, name, value)
        rclpy.init(args=["--ros-args", *arguments], signal_handler_options=SignalHandlerOptions.NO)
        try:
            node = PneumaticBoxNode()
            yield node
            node.board.close()
            node.destroy_node()
        finally:
            rclpy.try_shutdown()
    del sys.modules["plain_board"]


def test_a_vent_reaches_the_board_though_it_cannot_be_published(node):
    told = sys.modules["plain_board"].Board.told
    node.destroy_publisher(node._valves._publisher)
    assert node.command_vent() == ""
    assert told == [[0, 0], [-1, -1]]


def test_an_answer_that_cannot_be_published_reaches_the_board_and_vents(node):
    told = sys.modules["plain_board"].Board.told
    node.serve_board(node.board)
    assert told == [[0, 0], [0, 0]]
    node.box._closed = np.array([1, 0], dtype=np.int8)  # an answer that is published at once
    node.destroy_publisher(node._valves._publisher)
    node.serve_board(node.board)
    assert told[2:] == [[1, 0], [-1, -1]]
    assert node.box.latch.reasons[0].startswith("backend hardware: InvalidHandle")
    node.serve_board(node.board)
    assert told[-1] == [-1, -1]
