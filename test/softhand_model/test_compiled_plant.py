"""The compiled plant against the numpy plant, with every option of the bench on and off."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from softhand_model.pneumatics import load_pneumatics
from softhand_model.pneumatics.compiled_plant import CompiledPlant
from softhand_model.pneumatics.plant import PneumaticPlant

REST = np.array([20e-6, 30e-6, 45e-6, 60e-6])
KINDS = (PneumaticPlant, CompiledPlant)


def full_options():
    """A leaky box, air that heats, and a compressor that has to start soon."""
    p = load_pneumatics()
    return replace(
        p,
        leak=replace(p.leak, conductance=(1e-11, 1e-10)),
        gas=replace(p.gas, thermal_time_constant=0.3),
        compressor=replace(p.compressor, tank_volume=5e-5, delivery=3e-4),
    )


def full_plant(kind):
    return kind("abcd", REST, full_options(), seed=3, relief_pressures=np.full(4, 8e3))


def break_things(plant):
    plant.faults.stick_valve("a", 1)
    plant.faults.burst("b", 0.2e-3)
    plant.faults.stick_sensor(1)
    plant.faults.lose_sensor(2)


def drive(plants, steps, dt=1e-3, seed=5):
    """Step all plants alike with random valves and volumes and give what they tell each time."""
    draw = np.random.default_rng(seed)
    valves = np.zeros(4, int)
    for _ in range(steps):
        if draw.random() < 0.1:
            valves = draw.choice([-1, 0, 1, 1], 4)
        volumes = REST * draw.uniform(0.98, 1.02, 4)
        yield [(plant.step(dt, valves, volumes), plant.read()) for plant in plants]


@pytest.mark.parametrize("step", [0.001, 0.005])
@pytest.mark.parametrize("full", [False, True])
def test_both_plants_run_alike_under_random_valves_and_volumes(step, full):
    plants = [full_plant(kind) if full else kind("abcd", REST, seed=3) for kind in KINDS]
    for told in drive(plants, 300, step):
        for one, other in zip(*told, strict=True):
            np.testing.assert_allclose(one, other, rtol=1e-10)
    assert told[0][0].max() > 105e3
    names = ["mass", "inflow", "outflow", "supply_pressure", "tank_pressure", "temperatures"]
    for name in names + ["leaked", "relieved", "wall_heat"] * full:
        values = [getattr(plant, name) for plant in plants]
        assert np.any(values[0] != 0), name
        np.testing.assert_allclose(values[0], values[1], rtol=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_air_is_kept_with_every_option_and_fault(kind):
    plant = full_plant(kind)
    start = plant.mass
    break_things(plant)
    for _ in drive([plant], 1500):
        pass
    assert plant.leaked.min() > 1e-9 and plant.relieved.max() > 1e-6
    left = start + plant.inflow - plant.outflow - plant.leaked - plant.relieved
    np.testing.assert_allclose(plant.mass, left, rtol=1e-11)


@pytest.mark.parametrize("kind", KINDS)
def test_a_restored_run_repeats_bit_for_bit_with_every_option_and_fault(kind):
    plant = full_plant(kind)
    for _ in drive([plant], 200):
        pass
    break_things(plant)
    plant.set_supply(280e3)
    for _ in drive([plant], 15):  # into the delays of valves under way
        pass
    saved = plant.save()
    runs = []
    for _ in range(2):
        plant.restore(saved)
        told = [np.concatenate(one) for (one,) in drive([plant], 300, seed=6)]
        scalars = (plant.supply_pressure, plant.tank_pressure, plant.time)
        runs.append((*told, plant.mass, plant.leaked, plant.relieved, plant.wall_heat, scalars))
        plant.faults.clear()
        plant.set_supply(200e3)
    for first, second in zip(*runs, strict=True):
        np.testing.assert_array_equal(first, second)


def test_the_pneumatics_alone_do_not_load_the_compiler():
    script = "import sys, softhand_model.pneumatics; sys.exit('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", script]).returncode == 0
