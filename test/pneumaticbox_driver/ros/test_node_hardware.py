"""The node with backend hardware: without its devices, and on a board that fails on the way."""

import json
import os
import signal
import time
from pathlib import Path

import numpy as np
import pytest
import yaml
from forked_nodes import ForkingLauncher
from plant_peer import BOX, MG, MODULE, VOLUME
from std_srvs.srv import SetBool, Trigger

from softhand_bringup.processes.launcher import NodeCommand
from softhand_bringup.processes.suite import node_environment

pytestmark = pytest.mark.system

SUPPORT = Path(__file__).parents[2] / "support"
WIRING = Path(__file__).parents[3] / "src/pneumaticbox_driver/config/hardware.yaml"


def test_a_device_that_is_not_there_ends_it_with_a_sentence(start, tmp_path, peer):
    wiring = yaml.safe_load(WIRING.read_text())
    wiring["converter"]["sysfs"] = str(tmp_path)  # no converter in it, on whatever machine
    file = tmp_path / "hardware.yaml"
    file.write_text(yaml.safe_dump(wiring))
    process = start(backend="hardware", use_sim_time=False, hardware_file=str(file))
    assert process.wait(20.0) == 2, process.output()
    assert process.last_words().startswith("pneumaticbox: ")
    assert str(tmp_path) in process.last_words()
    assert "Traceback" not in process.output()
    assert not peer.valves  # nothing was commanded


@pytest.fixture
def fault(tmp_path):
    """While this file exists the board fails."""
    return tmp_path / "fault"


@pytest.fixture
def start_on_board(domain, tmp_path, fault):
    """Start the driver on a `FailingBoard`."""
    settings = {"fault": str(fault), "volume": VOLUME}
    wiring = {"format": "pneumaticbox-hardware/1", "board": "failing_board:FailingBoard"}
    file = tmp_path / "hardware.yaml"
    file.write_text(yaml.safe_dump({**wiring, "vent_time": 0.2, "settings": settings}))
    environment = node_environment(tmp_path / "log", domain)
    path = [str(SUPPORT), environment.get("PYTHONPATH", "")]
    environment["PYTHONPATH"] = os.pathsep.join(filter(None, path))
    parameters = {**BOX, "backend": "hardware", "hardware_file": str(file), "embedded_rate": 100.0}
    parameters["allow_board_module"] = True
    with ForkingLauncher(tmp_path / "log", environment) as launcher:
        yield lambda **given: launcher.start(NodeCommand("driver", MODULE, parameters | given))


@pytest.fixture
def on_board(start_on_board, peer):
    """The driver on a `FailingBoard`, which takes commands from its start on."""
    return start_on_board(start_enabled=True)


def test_no_air_flows_before_it_is_enabled(start_on_board, peer, fault):
    start_on_board()
    peer.wait(lambda: peer.states, "a state")
    peer.spin(1.0)
    peer.command(20 * MG, 5 * MG)
    assert all(max(json.loads(valves)) <= 0 for _, valves in valves_told(fault))
    peer.call(Trigger, "pneumaticbox/reset")  # a busy machine may have kept the board waiting
    assert peer.call(SetBool, "pneumaticbox/enable", data=True).success
    fill(peer)


def fill(peer):
    """Until the channels hold 20 and 5 mg; again if a busy machine has kept the board waiting."""
    target = [20 * MG, 5 * MG]
    peer.wait(lambda: peer.states, "a state")
    peer.spin(1.0)

    def filled():
        peer.call(Trigger, "pneumaticbox/reset")
        peer.command(*target)
        peer.spin(2.0)
        return np.allclose(peer.states[-1].position, target, atol=2.5 * MG)

    peer.wait(filled, "the masses")


def test_a_board_that_fails_vents_and_leaves_that_by_reset_alone(on_board, peer, fault):
    fill(peer)
    fault.touch()
    peer.diagnosis("safety", "backend hardware: the board's cable is unplugged", keep_going=False)
    fault.write_text("KeyError")  # a bug of the board's own ends the driver no more than its cable
    peer.diagnosis("safety", "backend hardware: KeyError: \"the board's cable", keep_going=False)
    refused = peer.call(Trigger, "pneumaticbox/reset")
    assert not refused.success and "expected a sensor sample" in refused.message
    fault.unlink()
    peer.wait(lambda: max(peer.states[-1].effort) < 3e3, "open outlets")
    peer.diagnosis("safety", "vented until pneumaticbox/reset", keep_going=False)
    assert peer.call(Trigger, "pneumaticbox/reset").success
    assert peer.diagnosis("safety", "in operation", keep_going=False)
    assert on_board.output().count("hardware: the board's cable is unplugged") == 1
    assert on_board.output().count("in _check\n") == 1  # one traceback


def put(fault, text):
    """Let the board fail in this way, at once for every reader of the file; the time then [s]."""
    new = fault.with_suffix(".new")
    new.write_text(text)
    begun = time.monotonic()
    new.replace(fault)
    return begun


def valves_told(fault):
    """Times [s] and valves that the board was told."""
    lines = fault.with_suffix(".told").read_text().splitlines()
    return [(float(time), valves) for time, _, valves in (line.partition(" ") for line in lines)]


def test_a_board_whose_reading_blocks_is_vented_and_everything_goes_on(on_board, peer, fault):
    fill(peer)
    latencies = []
    for _ in range(3):  # the quickest counts: others are up to what else the machine does
        begun = put(fault, "read blocks")
        peer.diagnosis("safety", "the board's read has not returned in time", keep_going=False)
        after = [told - begun for told, valves in valves_told(fault) if told > begun]
        opened = [told - begun for told, valves in valves_told(fault) if valves == "[-1, -1]"]
        assert after, "the board was told nothing any more"
        latencies.append(min(latency for latency in opened if latency > 0))
        assert peer.call(Trigger, "pneumaticbox/vent").success
        fault.unlink()
        peer.wait(lambda: peer.call(Trigger, "pneumaticbox/reset").success, "a reset")
    assert min(latencies) < 0.25, latencies
    put(fault, "read blocks")
    peer.spin(0.5)
    on_board.send(signal.SIGTERM)
    assert on_board.wait(10.0) == 0, on_board.output()


def test_valves_that_cannot_be_switched_are_said_loudly_and_services_go_on(on_board, peer, fault):
    fill(peer)
    put(fault, "set_valves blocks")
    peer.diagnosis("safety", "shut off the supply", "set_valves has not returned", keep_going=False)
    assert peer.call(Trigger, "pneumaticbox/vent").success
    assert "does not open the outlets, shut off the supply" in on_board.output()
    fault.unlink()
    peer.wait(lambda: max(peer.states[-1].effort) < 3e3, "open outlets")
    put(fault, "set_valves blocks")
    peer.spin(0.5)
    on_board.send(signal.SIGTERM)
    assert on_board.wait(10.0) == 0, on_board.output()
    assert "does not open the outlets" in on_board.last_words()
