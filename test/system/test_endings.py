"""Every node ends with code 0 on SIGINT and SIGTERM, while all of them are busy; after SIGTERM
also where it cannot end in order; and what a launcher has started ends with it.
"""

import os
import signal
import subprocess
import sys

import pytest
from leftover import nodes_logging_to
from std_srvs.srv import SetBool

from softhand_bringup.processes import suite
from softhand_bringup.processes.launcher import Launcher, NodeCommand, wait_until

NODES = ("hand_sim", "driver", "sequencer", "recorder")
SIGNALS = {
    "SIGINT": [signal.SIGINT],
    "SIGTERM": [signal.SIGTERM],
    "twice SIGINT": [signal.SIGINT, signal.SIGINT],
}
SOON = 6.0  # wall time to end by force, and some for a machine that is busy [s]
ABORT_MESSAGES = ("terminate called", "Traceback", "core dumped", "Segmentation", "rcl_shutdown")


@pytest.fixture
def launcher(domain, tmp_path):
    """Starts nodes as a user does: as programs."""
    log_folder = tmp_path / "log"
    with Launcher(log_folder, suite.node_environment(log_folder, domain)) as launcher:
        yield launcher


@pytest.mark.parametrize("signals", SIGNALS.values(), ids=SIGNALS)
def test_each_node_ends_in_order(nodes, launcher, peer, tmp_path, signals):
    nodes["recorder"] = launcher.start(suite.recorder(tmp_path / "bag"))
    peer.wait_for_driver()
    peer.wait(lambda: (tmp_path / "bag" / "bag_0.mcap").exists(), "the bag")
    for name in NODES:
        for number in signals:
            nodes[name].send(number)
        assert nodes[name].wait(10.0) == 0, f"{name}: {nodes[name].output()}"
        for text in ABORT_MESSAGES:
            assert text not in nodes[name].output(), name


def test_a_simulator_alone_on_its_domain_ends_too(launcher, peer, options):
    process = launcher.start(suite.simulator(options))
    peer.wait(lambda: any(peer.node.get_node_names()), "the node")
    peer.wait(lambda: len(peer.node.get_node_names()) > 1, "the node")
    process.send(signal.SIGTERM)
    assert process.wait(10.0) == 0, process.output()


def terminate(processes):
    """End them one after the other by SIGTERM; names of those that do not end soon."""
    for process in processes.values():
        process.send(signal.SIGTERM)
    return [name for name, process in processes.items() if process.wait(SOON) is None]


def commands(options, folder):
    """All nodes as commands."""
    page = NodeCommand("page", "softhand_play.command", arguments=("--ros", "--port", "0"))
    return [
        *suite.three_nodes(options),
        suite.monitor(options),
        suite.recorder(folder / "bag"),
        page,
    ]


def test_nodes_end_while_they_are_loaded(launcher, options, tmp_path):
    started = {c.name: launcher.start(c) for c in commands(options, tmp_path)}
    assert terminate(started) == []


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_nodes_end_while_they_compile(domain, tmp_path, options, number):
    environment = suite.node_environment(tmp_path, domain)
    environment["NUMBA_CACHE_DIR"] = str(tmp_path / "empty")
    with Launcher(tmp_path / "log", environment) as launcher:
        for command in (suite.simulator(options), suite.driver(options)):
            process = launcher.start(command)
            assert wait_until(lambda p=process: "compiling" in p.output(), 60.0)
            process.send(number)
            assert process.wait(SOON) == 0, process.output()


def test_nodes_end_in_the_middle_of_a_grasp(nodes, launcher, peer, options, tmp_path):
    further = commands(options, tmp_path)[len(nodes) :]
    nodes |= {command.name: launcher.start(command) for command in further}
    peer.wait_for_driver()
    peer.grasp()
    peer.wait(lambda: "close" in peer.phases(), "a hand that closes")
    assert terminate(nodes) == []


@pytest.mark.parametrize("held_up", ["the simulator is paused", "the driver hangs"])
def test_nodes_end_in_a_grasp_that_does_not_go_on(nodes, peer, held_up):
    peer.wait_for_driver()
    peer.grasp()
    peer.wait(lambda: "close" in peer.phases(), "a hand that closes")
    if held_up == "the driver hangs":
        nodes["driver"].send(signal.SIGSTOP)  # the sequencer's vent has no answer
        nodes["sequencer"].send(signal.SIGINT)
        peer.spin(0.5)
    else:
        peer.call(SetBool, "sim/pause", data=True)
    ended = {name: nodes[name] for name in ("sequencer", "hand_sim")}
    assert terminate(ended) == []
    nodes["driver"].send(signal.SIGCONT)
    assert terminate(nodes) == []


def test_a_sequencer_that_waits_for_the_others_ends(launcher, peer, options):
    process = launcher.start(suite.sequencer(options))
    peer.grasp()
    peer.wait(lambda: "waiting" in process.output(), "a sequencer that waits")
    process.send(signal.SIGTERM)
    assert process.wait(SOON) == 0, process.output()


KILLED = """
import sys, time
from pathlib import Path
from softhand_bringup.processes import suite
from softhand_bringup.processes.launcher import Launcher

def test_that_is_killed(tmp_path):
    log = Path({log!r})
    with Launcher(log, suite.node_environment(log, {domain})) as launcher:
        for command in suite.three_nodes(suite.SuiteOptions()):
            launcher.start(command)
        time.sleep(100)
"""


@pytest.mark.parametrize("starter", ["demo", "pytest"])
def test_what_was_started_ends_with_a_starter_that_is_killed(domain, tmp_path, guard, starter):
    log = tmp_path / "log"
    if starter == "demo":
        line = [sys.executable, "-m", "softhand_bringup.ros.demo", "--out", str(tmp_path)]
    else:
        (tmp_path / "test_killed.py").write_text(KILLED.format(log=str(log), domain=domain))
        line = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(tmp_path)]
    with subprocess.Popen(
        line,
        cwd=tmp_path,
        env=os.environ | {"ROS_DOMAIN_ID": str(domain)},
        stdout=subprocess.PIPE,
        text=True,
        preexec_fn=guard.enrol,
    ) as process:
        expected = 3
        assert wait_until(lambda: len(nodes_logging_to(tmp_path)) == expected, 60.0)
        if starter == "demo":
            assert any("oppose" in line for line in process.stdout)  # in the middle of the grasp
        process.kill()
    assert wait_until(lambda: not nodes_logging_to(tmp_path), 15.0), nodes_logging_to(tmp_path)
