"""Which tests run in the same process where there are several (`make test`: two)."""

import os
from pathlib import PurePath

import pytest

from softhand_ros.middleware import set_up_middleware

# each process computes on one core: nodes beside it keep the other
for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")
set_up_middleware()  # a test's own nodes are found as soon as those that it starts

NODES = "nodes"


def share(path):
    """Name of the tests that share a process with those of a file: its own, as their fixtures are
    costly; and all tests that start nodes, as each of these loads the machine by itself.
    """
    file = PurePath(path)
    starts_nodes = {"system", "ros", "softhand_ros"} & set(file.parts)
    return NODES if starts_nodes else path


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    from xdist.scheduler import LoadScopeScheduling

    class Shares(LoadScopeScheduling):
        def _split_scope(self, nodeid):
            return share(nodeid.split("::")[0])

        def _assign_work_unit(self, node):
            if NODES in self.workqueue:  # nodes have the machine to themselves: after all else
                self.workqueue.move_to_end(NODES)
            super()._assign_work_unit(node)

    return Shares(config, log)
