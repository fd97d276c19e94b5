"""Bottles and relief valves that break on request: the node `faulty_plant` without ROS."""

import dataclasses

import numpy as np

from softhand_model.pneumatics import CommandWatch, load_pneumatics
from softhand_model.pneumatics.plant import PneumaticPlant

FAULTS = ("stick_valve", "burst", "stick_sensor", "lose_sensor", "lose_supply", "clear")


class FaultyPlant:
    """Steps the plant with the valves received last, and notes the highest true pressure.

    relief: whether each channel has a mechanical relief valve, at the plant's margin.
    """

    def __init__(self, channels, volumes, limits, seed=0, relief=True, supply=None):
        parameters = load_pneumatics()
        if supply is not None:
            changed = dataclasses.replace(parameters.supply, pressure=supply)
            parameters = dataclasses.replace(parameters, supply=changed)
        self.channels, self.volumes = tuple(channels), np.asarray(volumes, dtype=float)
        self.ambient = parameters.ambient_pressure
        opens = parameters.relief.pressures(limits) if relief else None
        self.plant = PneumaticPlant(self.channels, self.volumes, parameters, seed, opens)
        self.rest = self.plant.rest_mass(self.volumes)
        self.watch = CommandWatch(len(self.channels))
        self.clock_ahead = 0.0  # of the stamps [s]
        self.peak = self.gauge

    @property
    def gauge(self):
        """True pressures [Pa]."""
        return self.plant.pressures - self.ambient

    @property
    def mass(self):
        """True masses above rest [kg]."""
        return self.plant.mass - self.rest

    @property
    def stamp(self):
        """What the plant's clock shows [s]."""
        return self.plant.time + self.clock_ahead

    @property
    def silent(self):
        """Whether no valves have come for so long that the outlets are open."""
        return self.watch.silent(self.plant.time)

    def receive(self, valves):
        self.watch.receive(self.plant.time, valves)

    def advance(self, dt):
        """Let `dt` [s] pass in steps of at most 2 ms."""
        for _ in range(max(1, round(dt / 2e-3))):
            part = dt / max(1, round(dt / 2e-3))
            self.plant.step(part, self.watch.valves(self.plant.time), self.volumes)
            self.peak = np.maximum(self.peak, self.gauge)

    def order(self, text):
        """Do what an order says: `stick_valve a 1`, `burst b`, `stick_sensor 2`, `lose_sensor 0`,
        `lose_supply`, `clear`, `supply 260e3` (gauge [Pa]), `clock 5.0` (set it ahead by [s]).

        Raises ValueError for another one. The highest pressure is noted anew from here on.
        """
        name, *arguments = text.split()
        values = [_argument(word) for word in arguments]
        if name in FAULTS:
            getattr(self.plant.faults, name)(*values)
        elif name == "supply":
            self.plant.set_supply(*values)
        elif name == "clock":
            self.clock_ahead += values[0]
        else:
            raise ValueError(f"order must be one of {[*FAULTS, 'supply', 'clock']}, got {name}")
        self.peak = self.gauge


def _argument(word):
    for kind in (int, float):
        try:
            return kind(word)
        except ValueError:
            continue
    return word
