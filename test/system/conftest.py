"""Real nodes as processes, each test on a ROS domain that no other test worker uses."""

from pathlib import Path

import pytest
from forked_nodes import ForkingLauncher
from ros_domain import held_domain
from suite_peer import SuitePeer

from softhand_bringup.processes import suite
from softhand_bringup.processes.launcher import Guard
from softhand_bringup.processes.suite import node_environment


def pytest_collection_modifyitems(items):
    for item in items:
        if Path(__file__).parent in item.path.parents:
            item.add_marker(pytest.mark.system)


@pytest.fixture(scope="session")
def domain():
    """A ROS_DOMAIN_ID that no other test run uses."""
    with held_domain() as number:
        yield number


@pytest.fixture(scope="session")
def guard():
    """Ends processes that enrol themselves, should the test run be killed."""
    guard = Guard()
    yield guard
    guard.close()


@pytest.fixture
def launcher(domain, tmp_path):
    """Starts nodes; none is left when the test ends."""
    log_folder = tmp_path / "log"
    with ForkingLauncher(log_folder, node_environment(log_folder, domain)) as launcher:
        yield launcher


@pytest.fixture
def peer(launcher, domain, tmp_path):
    """The test's own node."""
    peer = SuitePeer(domain, tmp_path)
    peer.launcher = launcher
    yield peer
    peer.close()


@pytest.fixture
def options():
    """What the nodes simulate: the demo's grasp, in steps that take half the time."""
    return suite.SuiteOptions(step=0.004)


@pytest.fixture
def nodes(launcher, options):
    """Simulator, driver and sequencer by name, started."""
    return {command.name: launcher.start(command) for command in suite.three_nodes(options)}
