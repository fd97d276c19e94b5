"""Real nodes as processes, each test on a ROS domain that no other test worker uses."""

import fcntl
import tempfile
from pathlib import Path

import pytest
from suite_peer import SuitePeer

from softhand_bringup import suite
from softhand_bringup.environment import node_environment
from softhand_bringup.launcher import Launcher

DOMAINS = range(1, 102)  # the ports of higher ones reach into the ephemeral range


def pytest_collection_modifyitems(items):
    for item in items:
        if Path(__file__).parent in item.path.parents:
            item.add_marker(pytest.mark.system)


@pytest.fixture(scope="session")
def domain():
    """A ROS_DOMAIN_ID held by a lock file, so that test runs beside each other do not meet."""
    for number in DOMAINS:
        path = Path(tempfile.gettempdir()) / f"softhand-domain-{number}.lock"
        with path.open("w") as file:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                continue
            yield number
            return
    pytest.fail("no free ROS domain")


@pytest.fixture
def launcher(domain, tmp_path):
    """Starts nodes; none is left when the test ends."""
    log_folder = tmp_path / "log"
    with Launcher(log_folder, node_environment(log_folder, domain)) as launcher:
        yield launcher


@pytest.fixture
def peer(domain, tmp_path):
    """The test's own node."""
    peer = SuitePeer(domain, tmp_path)
    yield peer
    peer.close()


@pytest.fixture
def options():
    """What the nodes simulate: the demo's grasp."""
    return suite.SuiteOptions()


@pytest.fixture
def nodes(launcher, options):
    """Simulator, driver and sequencer by name, started."""
    return {command.name: launcher.start(command) for command in suite.three_nodes(options)}
