"""The rig of bottles with relief valves, pushes, other noise and faults."""

import dataclasses

import numpy as np
from bottle_rig import BottleRig

from pneumaticbox_driver.box.box import PneumaticBox
from pneumaticbox_driver.box.commands import TrajectoryPoint
from pneumaticbox_driver.calibration.file import load_calibration
from softhand_model.gas import AMBIENT_PRESSURE
from softhand_model.pneumatics import load_pneumatics
from softhand_model.pneumatics.plant import PneumaticPlant


class BrokenRig(BottleRig):
    """Notes the highest true pressure; `squeeze` is a function of time that scales the volumes.

    noise: factor on the noise of all sensors; supply: gauge [Pa]; rest: the volume that the box
    takes the channels to have [m3], None for the true one.
    """

    def __init__(self, noise=1.0, supply=None, squeeze=None, rest=None, **options):
        super().__init__(**options)
        self.squeeze = squeeze
        if rest is not None:
            n = len(self.names)
            settings = dataclasses.replace(self.box.settings, rest_volumes=(rest,) * n)
            self.box = PneumaticBox(settings, load_calibration(None, n))
        volumes = np.full(len(self.names), self.volume)
        parameters = with_noise(load_pneumatics(), noise)
        limits = self.box.guard.limits
        relief = parameters.relief.pressures(limits)
        seed = options.get("seed", 1)
        self.plant = PneumaticPlant(self.names, volumes, parameters, seed, relief)
        if supply is not None:
            self.plant.set_supply(supply)
        self.peak = self.gauge

    @property
    def gauge(self):
        """True pressures [Pa]."""
        return self.plant.pressures - AMBIENT_PRESSURE

    def volumes(self):
        factor = 1.0 if self.squeeze is None else self.squeeze(self.plant.time)
        return super().volumes() * factor

    def sample(self, dt):
        super().sample(dt)
        self.peak = np.maximum(self.peak, self.gauge)

    def command_field(self, field, values):
        """Command `values` (n,) as another `field` of a point, "effort" for pressures [Pa]."""
        point = TrajectoryPoint(0.0, **{field: tuple(float(value) for value in values)})
        self.box.command(self.names, [point], 0.0, self.box.time)

    def until_vented(self, limit):
        """Run until the box has latched; the time that took, `limit` [s] at most."""
        start = self.plant.time
        while not self.box.latch and self.plant.time < start + limit:
            self.run(2e-3)
        return self.plant.time - start


def with_noise(parameters, factor):
    """The constants of a plant with so many times the noise on its sensors."""
    sections = {
        name: dataclasses.replace(
            getattr(parameters, name), noise=factor * getattr(parameters, name).noise
        )
        for name in ("channel_sensor", "supply_sensor")
    }
    return dataclasses.replace(parameters, **sections)
