"""Simulations that close themselves, and a finger that lies level."""

import dataclasses
from importlib import resources

import numpy as np
import pytest

from pneuflex_sim.scene.scenes import load_scene
from pneuflex_sim.simulation import Simulation, SimulationConfig, config


@pytest.fixture
def simulate():
    """Make simulations; all are closed at the end of the test."""
    made = []

    def make(**config):
        made.append(Simulation(SimulationConfig(**config)))
        return made[-1]

    yield make
    for simulation in made:
        simulation.close()


@pytest.fixture
def level_stand(monkeypatch):
    """The scene `stand` with the finger pointing along world x, bending downwards."""
    level = dataclasses.replace(load_scene("stand"), wrist_rpy=(0.0, np.pi / 2, 0.0))
    monkeypatch.setattr(config, "load_scene", lambda *_: level)


@pytest.fixture
def weightless():
    """Model file without any effect: actuators have no weight."""
    return resources.files("softhand_model").joinpath("data/models/base.yaml")


@pytest.fixture
def mass_for_pressure():
    """Air masses of a simulation for given pressures."""

    def masses(simulation, pressures):
        """Air masses [kg above rest] that give these gauge pressures [Pa] at free bending."""
        gauge = np.asarray(pressures, float)
        bend = simulation.air.rest_bend(
            simulation.step_size, gauge, simulation.bodies.rotations, 293.15
        )
        ambient, temperature = simulation.ambient, simulation.temperature
        return simulation.air.masses(gauge + ambient, ambient, temperature, bend)

    return masses


@pytest.fixture
def hold_pressure():
    """Step a simulation with its chambers at given pressures."""

    def hold(simulation, pressures, duration, ramp=0.2):
        """Step with the chambers at given gauge pressures [Pa], after a ramp."""
        goal = np.asarray(pressures, float)
        start = simulation.time

        def impose(_valves):
            share = min(1.0, (simulation.time - start) / ramp)
            simulation._volumes = simulation.air.volumes(simulation.bodies.rotations)
            simulation.pressures_abs = simulation.ambient + share * goal

        simulation._update_air = impose
        for _ in range(round(duration / simulation.step_size)):
            simulation.step()

    return hold
