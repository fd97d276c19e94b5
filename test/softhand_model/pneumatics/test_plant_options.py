"""The plant with every option of the bench on: air is kept, and a restored run repeats."""

from dataclasses import replace

import numpy as np

from softhand_model.pneumatics import PneumaticPlant, load_pneumatics
from softhand_model.pneumatics.air_flow import series_flow

REST = np.array([20e-6, 30e-6, 45e-6, 60e-6])


def full_options():
    """A leaky box, air that heats, and a compressor that has to start soon."""
    p = load_pneumatics()
    return replace(
        p,
        leak=replace(p.leak, conductance=(1e-11, 1e-10)),
        gas=replace(p.gas, thermal_time_constant=0.3),
        compressor=replace(p.compressor, tank_volume=5e-5, delivery=3e-4),
    )


def full_plant():
    return PneumaticPlant("abcd", REST, full_options(), seed=3, relief_pressures=np.full(4, 8e3))


def break_things(plant):
    plant.faults.stick_valve("a", 1)
    plant.faults.burst("b", 0.2e-3)
    plant.faults.stick_sensor(1)
    plant.faults.lose_sensor(2)


def drive(plant, steps, dt=1e-3, seed=5):
    """Step a plant with random valves and volumes and give what it tells each time."""
    draw = np.random.default_rng(seed)
    valves = np.zeros(4, int)
    for _ in range(steps):
        if draw.random() < 0.1:
            valves = draw.choice([-1, 0, 1, 1], 4)
        volumes = REST * draw.uniform(0.98, 1.02, 4)
        yield plant.step(dt, valves, volumes), plant.read()


def test_air_flows_as_the_orifice_and_the_line_in_series_pass_it():
    plant, dt = PneumaticPlant("abcd", REST, seed=3), 1e-4
    pressures = np.array([110e3, 150e3, 250e3, 390e3])
    plant.fill(pressures * plant.rest_mass(REST) / plant.parameters.ambient_pressure)
    for channel in "abcd":
        plant.faults.stick_valve(channel, 1)
    before, paths = plant._contents.air.copy(), plant._paths
    through = zip(pressures, paths.choke_and_valve[0], paths.line, strict=True)
    inflow = np.array([series_flow(plant.supply_pressure, *channel) for channel in through])
    plant.step(dt, [0] * 4, REST)
    np.testing.assert_allclose(plant._contents.air - before, dt * inflow, rtol=1e-9)
    assert inflow.min() > 1e-6


def test_air_is_kept_with_every_option_and_fault():
    plant = full_plant()
    start = plant.mass
    break_things(plant)
    for _ in drive(plant, 1500):
        pass
    assert plant.leaked.min() > 1e-9 and plant.relieved.max() > 1e-6
    left = start + plant.inflow - plant.outflow - plant.leaked - plant.relieved
    np.testing.assert_allclose(plant.mass, left, rtol=1e-11)


def test_a_restored_run_repeats_bit_for_bit_with_every_option_and_fault():
    plant = full_plant()
    for _ in drive(plant, 200):
        pass
    break_things(plant)
    plant.set_supply(280e3)
    for _ in drive(plant, 15):  # into the delays of valves under way
        pass
    saved = plant.save()
    runs = []
    for _ in range(2):
        plant.restore(saved)
        told = [np.concatenate(one) for one in drive(plant, 300, seed=6)]
        scalars = (plant.supply_pressure, plant.tank_pressure, plant.time)
        runs.append((*told, plant.mass, plant.leaked, plant.relieved, plant.wall_heat, scalars))
        plant.faults.clear()
        plant.set_supply(200e3)
    for first, second in zip(*runs, strict=True):
        np.testing.assert_array_equal(first, second)
