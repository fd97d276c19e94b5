"""The compiled plant against the numpy plant."""

import subprocess
import sys

import numpy as np
import pytest

from softhand_model.pneumatics.compiled_plant import CompiledPlant
from softhand_model.pneumatics.plant import PneumaticPlant


@pytest.mark.parametrize("step", [0.001, 0.005])
def test_both_plants_run_alike_under_random_valves_and_volumes(step):
    draw = np.random.default_rng(5)
    rest = draw.uniform(20e-6, 60e-6, 4)
    valves = np.zeros(4, int)
    plants = [kind("abcd", rest, seed=3) for kind in (PneumaticPlant, CompiledPlant)]
    for _ in range(300):
        if draw.random() < 0.1:
            valves = draw.integers(-1, 2, 4)
        volumes = rest * draw.uniform(0.98, 1.02, 4)
        pressures = [plant.step(step, valves, volumes) for plant in plants]
        np.testing.assert_allclose(pressures[0], pressures[1], rtol=1e-10)
        np.testing.assert_allclose(plants[0].read(), plants[1].read(), rtol=1e-12)
    assert pressures[0].max() > 105e3
    for name in ("mass", "inflow", "outflow", "supply_pressure"):
        np.testing.assert_allclose(getattr(plants[0], name), getattr(plants[1], name), rtol=1e-9)


def test_the_pneumatics_alone_do_not_load_the_compiler():
    script = "import sys, softhand_model.pneumatics; sys.exit('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", script]).returncode == 0
