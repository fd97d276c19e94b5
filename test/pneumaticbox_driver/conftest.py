"""Test pulses on the simulated box, and the driver as a process; ROS is loaded when asked for."""

import pytest
from forked_nodes import ForkingLauncher
from ros_domain import held_domain

from pneumaticbox_driver.calibration.command import BOTTLE, record_on_rig
from softhand_bringup.processes.launcher import NodeCommand
from softhand_bringup.processes.suite import node_environment


@pytest.fixture(scope="session")
def bench_pulses():
    """Record pulses per channel on bottles of 0.5 L."""

    def record(cycles, seed, channels, supply):
        return record_on_rig(cycles, seed, channels, BOTTLE, supply)

    return record


@pytest.fixture(scope="module")
def domain():
    """A ROS_DOMAIN_ID that no other test uses."""
    with held_domain() as domain:
        yield domain


@pytest.fixture
def launcher(domain, tmp_path):
    """Starts processes; none is left when the test ends."""
    with ForkingLauncher(tmp_path / "log", node_environment(tmp_path / "log", domain)) as launcher:
        yield launcher


@pytest.fixture
def start(launcher):
    """Start the driver; on simulated time without a /clock a test may take its time."""
    from plant_peer import BOX, MODULE

    def start(**parameters):
        values = {**BOX, "use_sim_time": True, **parameters}
        return launcher.start(NodeCommand("driver", MODULE, values))

    return start


@pytest.fixture
def peer(domain, tmp_path):
    """The test's own node, with the plant's side of the driver."""
    from plant_peer import PlantPeer

    peer = PlantPeer(domain, tmp_path)
    yield peer
    peer.close()
