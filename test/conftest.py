"""Which tests run in the same process where there are several (`make test`: three), and how."""

import gc
import importlib.util
import os
from pathlib import Path, PurePath

import pytest

from softhand_ros.middleware import set_up_middleware

# each process computes on one core: nodes beside it keep the other
for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")
set_up_middleware()  # a test's own nodes are found as soon as those that it starts

gc.disable()  # until all tests are collected, of which nothing is garbage

NODES = "nodes"
GIVES_WAY = 10  # nice value of what computes beside nodes
LONGEST = (  # shares that take more than 30 s, begun first so that none is left alone at the end
    "test/model_lab/experiments/test_hand_grasp.py",
    "test/model_lab/test_real_data.py",
    "test/model_lab/slips/test_of_hand.py",
    "test/model_lab/diagnosis/test_diagnose.py",
    "test/release/test_wheels.py",
    "test/model_lab/test_nasty_sets.py",
    "test/thesis/chapter_8",
    "test/thesis/chapter_4",
    "test/softhand_play/test_lab_tab.py",
    "test/softhand_play/test_browser.py",
    "test/softhand_trials/sweep/test_cluster.py",
    "test/softhand_trials/sweep/test_cluster_security.py",
    "test/softhand_bringup/test_workspace.py",
    "test/examples/test_notebooks.py",
    "test/model_lab/learning/test_learn.py",
    "test/model_lab/diagnosis/test_next_experiment.py",
    "test/model_lab/cli/test_demo.py",
    "test/model_lab/slips/test_find.py",
    "test/model_lab/test_hidden_sets.py",
    "test/grasp_strategies/test_rbo_hand_1_strategies.py",
    "test/grasp_strategies/test_rbo_hand_2_strategies.py",
    "test/softhand_design/test_hand_parts.py",
    "test/softhand_design/test_mould.py",
)


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


def pytest_collection_finish(session):
    """What was collected stays: the garbage collector need not look at it again."""
    gc.collect()
    gc.freeze()
    gc.enable()


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
        """The nodes' share comes first, then LONGEST, then those with the most tests."""

        def _split_scope(self, nodeid):
            return share(nodeid.split("::")[0])

        def _assign_work_unit(self, node):
            for name in reversed((NODES, *LONGEST)):
                if name in self.workqueue:
                    self.workqueue.move_to_end(name, last=False)
            super()._assign_work_unit(node)

    return Shares(config, log)
