"""Compiles the numerical kernels of simulator, driver and lab into their cache (`make setup`).

Without it they are compiled at first use; a node logs this at its first start.
"""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor

import numpy as np

from model_lab.bench.synthesize import EMPTY
from model_lab.experiments.forward import Forward, inapplicable
from pneuflex_sim.simulation import Simulation
from pneumaticbox_driver.box.box import PneumaticBox
from pneumaticbox_driver.calibration.file import load_calibration
from pneumaticbox_driver.settings import BoxSettings
from softhand_model.effects import effect_classes
from softhand_model.effects.hand import HandEffect


def compile_simulator() -> None:
    """Take one step of the simulation, and make a box."""
    simulation = Simulation()
    simulation.step(np.zeros(len(simulation.channels)))
    simulation.read_sensors()
    simulation.close()
    PneumaticBox(BoxSettings(("a",), (1e-4,), (1e5,), ("mass",)), load_calibration(None, 1))


def compile_lab() -> None:
    """Predict each experiment of the lab with each effect that acts in it, at its first place."""
    for empty in EMPTY.values():
        data = empty(np.random.default_rng(0))
        for effect in effect_classes().values():
            if inapplicable(effect, data, "pneuflex") is None:
                if issubclass(effect, HandEffect):
                    effect = effect.at(**effect.places(data.hand, data.markers)[0])
                forward = Forward(data, effects=[effect])
                for lanes in (1, 2):  # to the compiler they are of different kinds
                    forward.predict(np.tile(forward.start(), (lanes, 1)))


def main() -> None:
    """Both at once."""
    with ProcessPoolExecutor(2) as processes:
        for part in [processes.submit(compile_simulator), processes.submit(compile_lab)]:
            part.result()


if __name__ == "__main__":
    main()
