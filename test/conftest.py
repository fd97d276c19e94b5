"""Which tests run in the same process where there are several (`make test`: four), and how."""

import os
from pathlib import PurePath

import pytest
from warm_nodes import WarmNode

from softhand_bringup.processes import launcher
from softhand_ros.middleware import set_up_middleware

# each process computes on one core: nodes beside it keep the other
for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")
set_up_middleware()  # a test's own nodes are found as soon as those that it starts

NODES_OF_SYSTEM, NODES_OF_PACKAGES = NODES = ("nodes of system", "nodes of packages")
GIVES_WAY = 5  # nice value of what computes beside nodes
# Shares that take longest and so come first, those with nodes before.
LONGEST = (
    "test/thesis/chapter_8",
    "test/model_lab/test_nasty_sets.py",
    "test/release/test_wheels.py",
    "test/softhand_bringup/test_workspace.py",
    "test/softhand_play/test_browser.py",
    "test/thesis/chapter_4",
    "test/pneuflex_sim/test_elastica.py",
    "test/model_lab/diagnosis/test_diagnose.py",
)


def share(path):
    """Name of the tests that share a process with those of a file: its own, as their fixtures are
    costly; of the thesis's experiments those of the folder, whose small runs are made once; and
    two for all tests that start nodes, as each of these loads the machine by itself.
    """
    file = PurePath(path)
    if "system" in file.parts:
        return NODES_OF_SYSTEM
    if {"ros", "softhand_ros"} & set(file.parts):
        return NODES_OF_PACKAGES
    return str(file.parent) if "thesis" in file.parts else path


def share_of(nodeid):
    """The share of a test."""
    return share(nodeid.split("::")[0])


def one_of_several(config):
    """Whether this process runs a part of the tests."""
    return hasattr(config, "workerinput")


def pytest_collection_modifyitems(config, items):
    """The shares that take longest come first."""
    if one_of_several(config):
        first = [*NODES, *LONGEST]
        rank = {name: number - len(first) for number, name in enumerate(first)}
        items.sort(key=lambda item: rank.get(share_of(item.nodeid), 0))


def pytest_runtest_setup(item):
    """Nodes mostly wait but must not be late: what computes beside them takes what they leave."""
    computes = one_of_several(item.config) and share_of(item.nodeid) not in NODES
    if computes and os.nice(0) < GIVES_WAY:
        os.nice(GIVES_WAY)


@pytest.fixture(scope="session", autouse=True)
def warm_nodes():
    """Nodes of all tests start without importing everything again."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(launcher, "NodeProcess", WarmNode)
        yield
        WarmNode.close()


@pytest.fixture
def cold_nodes(monkeypatch):
    """Nodes of a test about starts and ends start as those of a user."""
    monkeypatch.setattr(launcher, "NodeProcess", WarmNode.__base__)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    from xdist.scheduler import LoadScopeScheduling

    class Shares(LoadScopeScheduling):
        """Shares in the order of the tests."""

        def _split_scope(self, nodeid):
            return share_of(nodeid)

    config.option.loadscopereorder = False
    return Shares(config, log)
