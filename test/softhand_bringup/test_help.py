"""Every executable tells how to use it, at once; a node tells of all that others meet."""

import ast
import importlib
import resource
import subprocess
import sys
from pathlib import Path

import pytest

from grasp_strategies.ros import interface as sequencer
from model_lab.ros import interface as monitor
from pneuflex_sim.ros import interface as simulator
from pneuflex_sim.ros.parameters import SOLVERS
from pneuflex_sim.world import SETTINGS
from pneumaticbox_driver.ros import interface as driver
from softhand_bringup import command

SOURCES = Path(__file__).parents[2] / "src"
NODES = {"hand_sim": simulator, "driver": driver, "sequencer": sequencer, "monitor": monitor}
LIMIT, NODE_LIMIT = 2.0, 1.0  # CPU time, which a busy machine does not stretch [s]
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


@pytest.mark.parametrize("name", [*NODES, "film", "demo"])
def test_the_help_takes_less_than_two_seconds_and_that_of_a_node_less_than_one(name):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    words = ["run", name] if name in NODES else [name]
    done = subprocess.run(
        [sys.executable, "-m", command.__name__, *words, "--help"], capture_output=True, text=True
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    duration = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    assert done.returncode == 0, done.stderr
    assert duration < (NODE_LIMIT if name in NODES else LIMIT)
    if name in NODES:
        assert done.stdout.strip() == NODES[name].HELP.strip()


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
    assert set(SOLVERS) == set(SETTINGS)


def test_the_documentation_has_every_topic_and_service_of_the_nodes():
    page = (SOURCES.parent / "docs/reference/topics-and-services.md").read_text()
    for node in NODES.values():
        for offer in node.OFFERS:
            assert f"`{offer.name}`" in page or f"`{offer.name.split('/')[-1]}`" in page, offer
