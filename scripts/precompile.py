"""Compiles the numerical kernels of simulator and driver into their cache (`make setup`).

Without it the nodes do so at their first start, and say so while the minute lasts.
"""

from __future__ import annotations

import numpy as np

from pneuflex_sim.simulation import Simulation
from pneumaticbox_driver.box.box import PneumaticBox
from pneumaticbox_driver.calibration.file import load_calibration
from pneumaticbox_driver.settings import BoxSettings


def main() -> None:
    """Take one step of the simulation, and make a box."""
    simulation = Simulation()
    simulation.step(np.zeros(len(simulation.channels)))
    simulation.read_sensors()
    simulation.close()
    PneumaticBox(BoxSettings(("a",), (1e-4,), (1e5,), ("mass",)), load_calibration(None, 1))


if __name__ == "__main__":
    main()
