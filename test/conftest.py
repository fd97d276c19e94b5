"""Which tests run in the same process where there are several (`make test`: two)."""

from pathlib import PurePath

import pytest


def share(path):
    """Name of the tests that share a process with those of a file: its own, as their fixtures are
    costly; and all tests that start nodes, as each of these loads the machine by itself.
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
