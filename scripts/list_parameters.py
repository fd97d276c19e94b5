"""Prints the nodes' parameters as tables for the page of topics and services (`make docs`)."""

from __future__ import annotations

from grasp_strategies.ros.parameters import PARAMETERS as SEQUENCER
from model_lab.ros.interface import PARAMETERS as MONITOR
from pneuflex_sim.ros.parameters import PARAMETERS as SIMULATOR
from pneumaticbox_driver.ros.parameters import PARAMETERS as DRIVER
from softhand_ros.parameters import markdown

NODES = {
    "Driver (`pneumaticbox`)": DRIVER,
    "Simulator (`hand_sim`)": SIMULATOR,
    "Sequencer (`grasp_sequencer`)": SEQUENCER,
    "Monitor (`monitor`)": MONITOR,
}


def tables() -> str:
    """A heading and a table for each node."""
    return "\n\n".join(f"### {node}\n\n{markdown(table)}" for node, table in NODES.items())


if __name__ == "__main__":
    print(tables())
