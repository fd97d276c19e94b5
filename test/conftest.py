"""Which tests run in the same process where there are several (`make test`: three), and how."""

import importlib.util
import os
from pathlib import Path, PurePath

import pytest

from softhand_ros.middleware import set_up_middleware

# each process computes on one core: nodes beside it keep the other
for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")
set_up_middleware()  # a test's own nodes are found as soon as those that it starts

NODES = "nodes"
GIVES_WAY = 5  # nice value of what computes beside nodes


def share(path):
    """Name of the tests that share a process with those of a file: its own, as their fixtures are
    costly; of the thesis's experiments those of the folder, whose small runs are made once; and all
    tests that start nodes, as each of these loads the machine by itself.
    """
    file = PurePath(path)
    if {"system", "ros", "softhand_ros"} & set(file.parts):
        return NODES
    return str(file.parent) if "thesis" in file.parts else path


def pytest_runtest_setup(item):
    """Nodes mostly wait but must not be late: what computes beside them takes what they leave."""
    one_of_several = hasattr(item.config, "workerinput")
    if one_of_several and share(item.nodeid.split("::")[0]) != NODES and os.nice(0) < GIVES_WAY:
        os.nice(GIVES_WAY)


@pytest.fixture(scope="session")
def control_types():
    """The module control_msgs.action, and the folder where a node finds it: the installed ones, or
    else built from their definitions.
    """
    from built_interfaces import CAN_BUILD, control_msgs

    with pytest.MonkeyPatch.context() as patch:
        if importlib.util.find_spec("control_msgs") is None:
            if not CAN_BUILD:
                pytest.skip("needs control_msgs, or g++ and the headers of Python to build it")
            patch.syspath_prepend(control_msgs())
        from control_msgs import action

        yield action, Path(action.__file__).parents[2]


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    from xdist.scheduler import LoadScopeScheduling

    class Shares(LoadScopeScheduling):
        """The largest share comes first: the nodes', which take the longest."""

        def _split_scope(self, nodeid):
            return share(nodeid.split("::")[0])

    return Shares(config, log)
