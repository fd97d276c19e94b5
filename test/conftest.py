"""Which tests run in the same process where there are several (`make test`: two)."""

import os
from pathlib import PurePath

import pytest

# each process computes on one core: nodes beside it keep the other
for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")


def share(path):
    """Name of the tests that share a process with those of a file: its own, as their fixtures are
    costly; and all tests that start nodes, as each of these loads the machine by itself.
    """
    file = PurePath(path)
    starts_nodes = {"system", "ros", "softhand_ros"} & set(file.parts)
    return "nodes" if starts_nodes else path


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    from xdist.scheduler import LoadScopeScheduling

    class Shares(LoadScopeScheduling):
        def _split_scope(self, nodeid):
            return share(nodeid.split("::")[0])

    return Shares(config, log)
