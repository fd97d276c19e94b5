"""What the nodes of the executable `hand_with_box` offer to others."""

from __future__ import annotations

import sys

from pneuflex_sim.ros.interface import OFFERS as OF_THE_SIMULATOR
from pneuflex_sim.ros.parameters import PARAMETERS as SIMULATOR
from pneumaticbox_driver.ros.interface import OFFERS as OF_THE_DRIVER
from pneumaticbox_driver.ros.parameters import PARAMETERS as DRIVER
from softhand_ros.parameters import usage
from softhand_ros.run_node import start_node

PURPOSE = """Runs the nodes hand_sim and pneumaticbox, simulator and driver, in one process.
Names, topics, services and parameters are those of two processes, and so is a run with the same
seed. A parameter is that of the node that has it, or of both."""
INSIDE = {("sub", "pneumaticbox/sensors"), ("sub", "pneumaticbox/valves")}  # no topics here
PARAMETERS = tuple({row.name: row for row in (*SIMULATOR, *DRIVER)}.values())
OFFERS = tuple(
    offer
    for offer in dict.fromkeys((*OF_THE_SIMULATOR, *OF_THE_DRIVER))
    if (offer.way, offer.name) not in INSIDE
)
HELP = usage("hand_with_box", PURPOSE, PARAMETERS, OFFERS)


def main(args: list[str] | None = None) -> int:
    """Print the help of the nodes, or run them."""
    return start_node(HELP, "softhand_bringup.ros.hand_with_box.node", args)


if __name__ == "__main__":
    sys.exit(main())
