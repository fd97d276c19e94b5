"""Control modes of the driver with the actuators of a hand, at its start and while it runs."""

import pytest
from plant_peer import MG, MODULE
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from pneumaticbox_driver.modes import MODES
from softhand_bringup.processes.launcher import NodeCommand

pytestmark = pytest.mark.system

EMBEDDED = {"backend": "embedded", "volume_model": "hand", "embedded_rate": 200.0}


def start_embedded(launcher, peer, **parameters):
    process = launcher.start(NodeCommand("driver", MODULE, {**EMBEDDED, **parameters}))
    peer.wait(lambda: peer.states, 20.0, "a state")
    peer.spin(0.6)
    return process


def test_with_a_hand_it_starts_in_mode_pressure_and_serves_one_channel(launcher, peer):
    process = start_embedded(launcher, peer, control_mode=["pressure"])
    point = JointTrajectoryPoint(effort=[20e3])
    command = JointTrajectory(joint_names=["b"], points=[point])
    peer.publish(JointTrajectory, "pneumaticbox/command", command)
    peer.wait(lambda: abs(peer.states[-1].effort[1] - 20e3) < 2e3, 10.0, "20 kPa")
    assert process.exit_code is None


def test_every_mode_follows_a_mass_command_on_two_channels(launcher, peer):
    process = start_embedded(launcher, peer)
    peer.command(10 * MG, 5 * MG, names=["a", "b"])
    peer.spin(0.5)
    for mode in [*MODES, *reversed(MODES)]:
        assert peer.change("control_mode", [mode]) == ""
        peer.spin(0.15)
    told = peer.diagnosis("safety", keep_going=False)
    assert told.message == "in operation"
    assert process.exit_code is None
