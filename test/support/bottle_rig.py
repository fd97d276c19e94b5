"""The box on the simulated box, with bottles or compliant volumes on its channels."""

import numpy as np

from pneumaticbox_driver.box.box import PneumaticBox
from pneumaticbox_driver.box.commands import TrajectoryPoint
from pneumaticbox_driver.calibration.file import load_calibration
from pneumaticbox_driver.settings import BoxSettings
from softhand_model.gas import AMBIENT_PRESSURE, GAS_CONSTANT
from softhand_model.pneumatics import CommandWatch, load_pneumatics
from softhand_model.pneumatics.plant import PneumaticPlant

GAS = GAS_CONSTANT * 293.15  # [J/kg]
DEAD = 2 * load_pneumatics().choke.dead_volume
SWELLING_PRESSURE = 40e3  # at which a volume of compliance 1 has doubled [Pa]


class Swelling:
    """Model of volumes (n,) [m3] that grow linearly with the pressure, by `compliance`."""

    def __init__(self, volume, compliance, channels):
        self._rest = np.full(channels, volume)
        self._slope = self._rest * compliance / SWELLING_PRESSURE

    def volumes(self, gauge):
        return self._rest + self._slope * np.maximum(gauge, 0.0)

    def slopes(self, gauge):
        return self._slope


class BottleRig:
    """Runs box and plant together; `mass` is the truth [kg above rest], which the box never sees.

    compliance: growth of the volumes per 40 kPa; the volume follows the pressure without delay.
    model: of the volumes that the box is given; None for the one that the settings name.
    """

    def __init__(
        self,
        volume=30e-6,
        channels=2,
        compliance=0.0,
        limit=150e3,
        seed=1,
        mode="mass",
        model=None,
        **settings,
    ):
        self.names = tuple("abcdefgh"[:channels])
        self.volume, self.compliance = volume, compliance
        volumes = np.full(channels, volume)
        self.plant = PneumaticPlant(self.names, volumes, seed=seed)
        self.rest = self.plant.rest_mass(volumes)
        self.watch = CommandWatch(channels)
        self.box = PneumaticBox(
            BoxSettings(
                channels=self.names,
                rest_volumes=(volume,) * channels,
                pressure_limits=(limit,) * channels,
                control_modes=(mode,) * channels,
                **settings,
            ),
            load_calibration(None, channels),
            model,
        )
        self._held = None
        self.openings = np.zeros(channels, dtype=int)
        self.switchings = []  # (time, channel, valve)

    @property
    def mass(self):
        return self.plant.mass - self.rest

    @property
    def error(self):
        """Contained less estimated mass [kg]."""
        return self.mass - self.box.observer.mass

    def hold(self, volume):
        """Hold all actuators at a volume [m3], as an object in the hand does; None lets go."""
        self._held = volume

    def volumes(self):
        if self._held:
            return np.full(len(self.names), self._held)
        if not self.compliance:
            return np.full(len(self.names), self.volume)
        # p (V0 (1 + s (p - p0)) + dead) = m R T, solved for p
        slope = self.volume * self.compliance / SWELLING_PRESSURE
        linear = self.volume + DEAD - slope * AMBIENT_PRESSURE
        content = self.plant.mass * GAS
        pressure = (-linear + np.sqrt(linear**2 + 4 * slope * content)) / (2 * slope)
        return self.volume + slope * np.maximum(pressure - AMBIENT_PRESSURE, 0.0)

    def sample(self, dt):
        """One sample: let the plant run for dt [s], then let the box answer."""
        self.plant.step(dt, self.watch.valves(self.plant.time), self.volumes())
        self.answer(self.plant.read())

    def answer(self, readings):
        before = self.box.valves
        valves = self.box.on_sample(self.plant.time, readings)
        self.watch.receive(self.plant.time, valves)
        changed = np.flatnonzero(valves != before)
        self.openings += (valves != before) & (valves != 0)
        self.switchings += [(self.plant.time, int(i), int(valves[i])) for i in changed]

    def run(self, duration, dt=2e-3, jitter=None):
        """Samples for `duration` [s], dt [s] apart, or that times a factor drawn from `jitter`."""
        end = self.plant.time + duration
        while self.plant.time < end - 1e-9:
            self.sample(dt if jitter is None else dt * jitter.uniform(0.5, 1.5))

    def started(self, dt=2e-3):
        """The rig, once the box has averaged its sensors."""
        self.run(1.2, dt)
        return self

    def command(self, *masses, stamp=0.0, after=0.0):
        point = TrajectoryPoint(after, positions=masses)
        self.box.command(self.names, [point], stamp, self.box.time)

    def schedule(self, *events, names=None, stamp=0.0):
        """Schedule valves: (time, valve of all named channels) each."""
        names = names or self.names
        points = [TrajectoryPoint(time, [valve] * len(names)) for time, valve in events]
        self.box.schedule_valves(names, points, stamp, self.box.time)

    def smallest_pulses(self):
        """What the shortest pulse would bring and take now, the larger of both (n,) [kg]."""
        box = self.box
        pulse = box.settings.shortest_pulse
        return np.maximum(*box.observer.pulse_mass(pulse, box.pressures_abs, box.supply_abs))
