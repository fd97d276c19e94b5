"""The configuration files that are shipped are accepted by their nodes."""

import re
from dataclasses import replace
from pathlib import Path

import pytest
from rcl_interfaces.srv import GetParameters
from refused_start import refusal

from softhand_bringup.processes import suite
from softhand_bringup.processes.launcher import NodeCommand, wait_until

PARAMETERS = "ros__parameters"  # in files for nodes; others describe wiring
CHANGED = {  # a parameter of each node, and a value that is not the default
    "hand_sim": ("wrist_force_limit", 19.0),
    "pneumaticbox": ("embedded_rate", 400.0),
    "grasp_sequencer": ("connect_time_out", 11.0),
    "monitor": ("window", 4.0),
}
SOURCE = Path(__file__).parents[2] / "src"
CONFIGURATIONS = [
    ("pneuflex_sim.ros.node", "pneuflex_sim/config/hand_sim.yaml", "hand_sim"),
    (
        "pneumaticbox_driver.ros.node",
        "pneumaticbox_driver/config/pneumaticbox.yaml",
        "pneumaticbox",
    ),
    ("pneumaticbox_driver.ros.node", "pneumaticbox_driver/config/embedded.yaml", "pneumaticbox"),
    ("grasp_strategies.ros.node", "grasp_strategies/config/sequencer.yaml", "grasp_sequencer"),
    ("model_lab.ros.monitor", "model_lab/config/monitor.yaml", "monitor"),
]


@pytest.mark.parametrize(
    ("module", "path", "name"), CONFIGURATIONS, ids=[path for _, path, _ in CONFIGURATIONS]
)
def test_a_node_takes_its_shipped_configuration_in_any_namespace(
    launcher, peer, tmp_path, module, path, name
):
    file = tmp_path / "changed.yaml"
    changed, value = CHANGED[name]
    text, count = re.subn(rf"(    {changed}: )\S+", rf"\g<1>{value}", (SOURCE / path).read_text())
    assert count == 1
    file.write_text(text)
    arguments = ("--ros-args", "--params-file", str(file), "-r", "__ns:=/left")
    process = launcher.start(NodeCommand("node", module, arguments=arguments))
    full_name = (name, "/left")
    peer.wait(
        lambda: (
            process.exit_code is not None or full_name in peer.node.get_node_names_and_namespaces()
        ),
        name,
    )
    assert process.exit_code is None, process.output()
    taken = peer.call(GetParameters, f"left/{name}/get_parameters", names=[changed])
    assert taken.values[0].double_value == value


def test_no_shipped_configuration_is_left_out():
    files = [file for file in SOURCE.glob("*/config/*.yaml") if PARAMETERS in file.read_text()]
    shipped = {str(file.relative_to(SOURCE)) for file in files}
    assert shipped == {path for _, path, _ in CONFIGURATIONS}


WRONG = {
    "pneuflex_sim.ros.node": ("objekt", "object"),
    "pneumaticbox_driver.ros.node": ("bakend", "backend"),
    "grasp_strategies.ros.node": ("strategy.surface_constraint", "strategy.surface_constrained"),
    "model_lab.ros.monitor": ("hands", "hand"),
}


@pytest.mark.parametrize("module", WRONG)
def test_a_parameter_that_a_node_does_not_have_ends_it(domain, monkeypatch, capfd, module):
    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
    given, meant = WRONG[module]
    told = refusal(NodeCommand("node", module, {given: "ball"}), capfd)
    assert f"no parameter {given}, did you mean {meant}?" in told


def test_the_recorder_has_no_parameters(launcher, tmp_path):
    command = suite.recorder(tmp_path / "bag")
    process = launcher.start(replace(command, parameters={"topics": "all"}))
    assert process.wait(60.0) == 2
    assert "recorder: no parameter topics" in process.output()


def test_whole_numbers_are_taken_for_fractions_and_nodes_say_when_they_are_up(launcher):
    command = NodeCommand("hand_sim", "pneuflex_sim.ros.node", {"real_time_factor": 0})
    process = launcher.start(command)
    assert wait_until(lambda: "ready: rbo_hand_2" in process.output(), 60.0), process.output()
