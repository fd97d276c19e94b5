"""How the suite is shared between processes (`make test`: two processes)."""

from pathlib import PurePath

import pytest


def share(path):
    """Name of what runs in one process, one test after the other: a file, as its fixtures are
    costly; and everything that starts nodes, as one such test loads the machine by itself.
    """
    file = PurePath(path)
    starts_nodes = "system" in file.parts or file.name.startswith("test_node")
    return "nodes" if starts_nodes else path


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    from xdist.scheduler import LoadScopeScheduling

    class Shares(LoadScopeScheduling):
        def _split_scope(self, nodeid):
            return share(nodeid.split("::")[0])

    return Shares(config, log)
