"""The configuration files that are shipped are accepted by their nodes."""

from pathlib import Path

import pytest

from softhand_bringup.processes.launcher import NodeCommand

PARAMETERS = "ros__parameters"  # in files for nodes; others describe wiring
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
def test_a_node_starts_with_its_shipped_configuration(launcher, peer, module, path, name):
    arguments = ("--ros-args", "--params-file", str(SOURCE / path))
    process = launcher.start(NodeCommand("node", module, arguments=arguments))
    peer.wait(
        lambda: process.exit_code is not None or name in peer.node.get_node_names(), 60.0, name
    )
    assert process.exit_code is None, process.output()


def test_no_shipped_configuration_is_left_out():
    files = [file for file in SOURCE.glob("*/config/*.yaml") if PARAMETERS in file.read_text()]
    shipped = {str(file.relative_to(SOURCE)) for file in files}
    assert shipped == {path for _, path, _ in CONFIGURATIONS}
