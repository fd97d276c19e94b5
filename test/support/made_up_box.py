"""What a controller sees of a box, as stated: masses, flows, pressures; nothing drifts."""

from types import SimpleNamespace

import numpy as np

from pneumaticbox_driver.control.interface import BoxView
from pneumaticbox_driver.observer.volume_model import FixedVolumes
from softhand_model.gas import AMBIENT_PRESSURE, GAS_CONSTANT

GAS = GAS_CONSTANT * 293.15
MG, KPA = 1e-6, 1e3
REST = 30e-6
SUPPLY = 300 * KPA + AMBIENT_PRESSURE
SHORTEST = 0.045
LIMIT = 150 * KPA


class Swelling(FixedVolumes):
    """Volumes that grow by `slope` [m3/Pa]."""

    def __init__(self, rest, slope):
        super().__init__(rest)
        self.slope = slope

    def volumes(self, pressures):
        return self._volumes + self.slope * pressures

    def slopes(self, pressures):
        return np.full_like(self._volumes, self.slope)


def made_up_view(
    mass,
    setpoints,
    gain=2 * MG,
    loss=1 * MG,
    flow=0.0,
    direction=0,
    empty=False,
    dt=2e-3,
    model=None,
):
    """View of channels with these estimates [kg] and setpoints; `asked` holds the pulses that were
    asked for.
    """
    mass = np.atleast_1d(np.asarray(mass, float))
    n, asked = len(mass), []

    def pulse_mass(duration, pressures_abs, supply_abs):
        asked.append((duration, pressures_abs, supply_abs))
        return np.full(n, gain), np.full(n, loss)

    observer = SimpleNamespace(mass=mass, flow=np.full(n, flow), pulse_mass=pulse_mass)
    rest = np.full(n, REST)
    view = BoxView(
        observer=observer,
        volume_model=model or FixedVolumes(rest),
        rest_volumes=rest,
        limits=np.full(n, LIMIT),
        ambient=AMBIENT_PRESSURE,
        gas=GAS,
        shortest_pulse=SHORTEST,
    )
    view.pressures_abs = AMBIENT_PRESSURE + mass * GAS / rest
    view.setpoints = np.atleast_1d(np.asarray(setpoints, float))
    view.direction = np.full(n, direction, dtype=np.int8)
    view.empty, view.mine = np.full(n, empty), np.ones(n, dtype=bool)
    view.supply_abs, view.dt, view.asked = SUPPLY, dt, asked
    return view


class MadeUpChannel:
    """A channel whose true volume is as stated, under a controller that believes in another.

    Air flows at `flow` [kg/s] while a valve is open, without delay, and the estimate is the truth.
    """

    def __init__(
        self, controller, setpoint, rest=REST, slope=0.0, model=None, flow=50 * MG, dt=2e-3
    ):
        self.controller, self.rest, self.slope, self.flow = controller, rest, slope, flow
        self.view = made_up_view(0.0, setpoint, gain=0.2 * MG, loss=0.2 * MG, dt=dt, model=model)
        self.gauge, self.push, self.valves, self.moved = 0.0, 0.0, [], []

    @property
    def volume(self):
        return self.rest + self.slope * self.gauge

    def step(self):
        """One sample, then `dt` with the valve as the controller says."""
        view = self.view
        mass = float(view.observer.mass[0])
        content = mass * GAS + AMBIENT_PRESSURE * REST
        # p*(rest + slope*(p - ambient)) = content
        b = self.rest - self.slope * AMBIENT_PRESSURE
        absolute = (
            content / b
            if not self.slope
            else (np.sqrt(b * b + 4 * self.slope * content) - b) / (2 * self.slope)
        )
        self.gauge = absolute - AMBIENT_PRESSURE
        view.pressures_abs = np.array([absolute + self.push])
        valve = int(self.controller.update(view)[0])
        self.valves.append(valve)
        self.moved.append(mass)
        view.direction = np.array([valve], dtype=np.int8)
        view.observer.flow[:] = valve * self.flow
        view.observer.mass[0] += valve * self.flow * view.dt

    def run(self, duration):
        for _ in range(round(duration / self.view.dt)):
            self.step()
        return self

    @property
    def pulses(self):
        """Number of openings so far."""
        valves = np.array([0, *self.valves])
        return int(np.sum((valves[1:] != 0) & (valves[:-1] != valves[1:])))
