"""Every executable tells how to use it, at once; a node tells of all that others meet."""

import ast
import importlib
import os
import subprocess
import sys
from pathlib import Path

import pytest

from grasp_strategies.ros import interface as sequencer
from model_lab.ros import interface as monitor
from pneuflex_sim.ros import interface as simulator
from pneuflex_sim.ros.parameters import SOLVERS
from pneuflex_sim.world import SOLVER_SETTINGS
from pneumaticbox_driver.ros import interface as driver
from softhand_bringup import command
from softhand_bringup.ros.hand_with_box import interface as both

SOURCES = Path(__file__).parents[2] / "src"
NODES = {
    "hand_with_box": both,
    "hand_sim": simulator,
    "driver": driver,
    "sequencer": sequencer,
    "monitor": monitor,
}
HEAVY = ("pybullet", "numba", "matplotlib")


def executables():
    """What the packages install: modules by name of the executable."""
    found = {}
    for setup in sorted(SOURCES.glob("*/setup.py")):
        for node in ast.parse(setup.read_text()).body:
            if isinstance(node, ast.Assign) and node.targets[0].id == "EXECUTABLES":
                entries = (entry.split(" = ") for entry in ast.literal_eval(node.value))
                found |= {name: entry.removesuffix(":main") for name, entry in entries}
    return found


MODULES = executables() | command.modules()


@pytest.mark.parametrize("module", sorted(set(MODULES.values())))
def test_an_executable_tells_how_to_use_it(module, capsys, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["it", "--help"])
    try:
        status = importlib.import_module(module).main()
    except SystemExit as end:
        status = end.code
    assert not status
    assert "usage:" in capsys.readouterr().out


@pytest.mark.parametrize("name", NODES)
def test_the_help_of_a_node_does_not_wait_for_what_the_node_computes_with(name):
    done = subprocess.run(
        [sys.executable, "-m", command.__name__, "run", name, "--help"],
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONPROFILEIMPORTTIME": "1"},  # also beyond the exec of the node
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == NODES[name].HELP.strip()
    loaded = {line.rpartition("|")[2].strip() for line in done.stderr.splitlines()}
    ros = NODES[name].__package__
    assert "softhand_ros.parameters" in loaded  # these are the modules of the node's own process
    assert not loaded & {f"{ros}.node", "pybullet", "matplotlib", "trimesh", "rosbags"}


@pytest.mark.parametrize("name", NODES)
def test_a_node_tells_parameters_topics_and_services(name):
    assert MODULES[name] == MODULES[f"run {name}"] == NODES[name].__name__
    words = set(NODES[name].HELP.split())
    assert {parameter.name for parameter in NODES[name].PARAMETERS} <= words
    for offer in NODES[name].OFFERS:
        assert {offer.way, offer.name, offer.kind} <= words


def test_the_help_of_the_simulator_does_without_the_engine():
    program = f"import sys, {simulator.__name__}; print([m for m in {HEAVY} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout.strip() == "[]", done.stdout + done.stderr
    assert set(SOLVERS) == set(SOLVER_SETTINGS)


def test_the_documentation_has_every_topic_and_service_of_the_nodes():
    page = (SOURCES.parent / "docs/reference/topics-and-services.md").read_text()
    for node in NODES.values():
        for offer in node.OFFERS:
            assert f"`{offer.name}`" in page or f"`{offer.name.split('/')[-1]}`" in page, offer
