"""Control modes of the driver with the actuators of a hand, at its start and while it runs."""

import os
from itertools import pairwise
from pathlib import Path

import pytest
import yaml
from forked_nodes import ForkingLauncher
from plant_peer import BOX, MG, MODULE, VOLUME
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from pneumaticbox_driver.modes import MODES
from softhand_bringup.processes.launcher import NodeCommand
from softhand_bringup.processes.suite import node_environment

pytestmark = pytest.mark.system

SUPPORT = Path(__file__).parents[2] / "support"
HAND = {"hand": "rbo_hand_1_split", "volume_model": "hand"}  # of two channels
WALK = ["mass", "pressure", "volume", "pressure", "mass_flow", "volume", "time", "volume", "mass"]


def test_with_a_hand_it_starts_in_mode_pressure_and_serves_one_channel(launcher, peer):
    parameters = {"backend": "embedded", "volume_model": "hand", "control_mode": ["pressure"]}
    process = launcher.start(NodeCommand("driver", MODULE, parameters))
    peer.wait(lambda: peer.states, "a state")
    peer.spin(0.6)
    point = JointTrajectoryPoint(effort=[20e3])
    command = JointTrajectory(joint_names=["b"], points=[point])
    peer.publish(JointTrajectory, "pneumaticbox/command", command)
    peer.wait(lambda: abs(peer.states[-1].effort[1] - 20e3) < 2e3, "20 kPa")
    assert process.exit_code is None


@pytest.fixture
def on_backend(domain, tmp_path):
    """Starts the driver of a two-channel hand on a backend."""
    environment = node_environment(tmp_path / "log", domain)
    path = [str(SUPPORT), environment.get("PYTHONPATH", "")]
    environment["PYTHONPATH"] = os.pathsep.join(filter(None, path))
    settings = {"fault": str(tmp_path / "fault"), "volume": VOLUME}
    board = {"board": "failing_board:FailingBoard", "settings": settings}
    file = tmp_path / "hardware.yaml"
    head = {"format": "pneumaticbox-hardware/1", "vent_time": 0.2}
    file.write_text(yaml.safe_dump(head | board))
    with ForkingLauncher(tmp_path / "log", environment) as launcher:

        def start(backend):
            given = {**BOX, **HAND, "backend": backend, "embedded_rate": 200.0}
            if backend == "hardware":
                given |= {"hardware_file": str(file), "allow_board_module": True}
                given["start_enabled"] = True
            return launcher.start(NodeCommand("driver", MODULE, given))

        yield start


@pytest.mark.parametrize("backend", ["topic", "embedded", "hardware"])
def test_every_mode_follows_a_mass_command_on_one_of_two_channels(on_backend, peer, backend):
    process = on_backend(backend)
    if backend == "topic":
        peer.connect()
    else:
        peer.wait(lambda: peer.states, "a state")
        peer.spin(0.6)
    peer.command(10 * MG, names=["a"])
    assert set(WALK) == set(MODES)
    for before, mode in pairwise(WALK):
        assert peer.change("control_mode", [mode]) == "", before
        if backend == "topic":
            peer.run(0.1, 0.005)
        else:
            peer.spin(0.1)
    told = peer.diagnosis("safety", keep_going=backend == "topic")
    assert told.message == "in operation"
    assert process.exit_code is None
