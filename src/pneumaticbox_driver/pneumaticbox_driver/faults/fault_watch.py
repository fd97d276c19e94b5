"""Fault watch: recognises broken valves, tubes, sensors and supply from the pressures."""

import math
from dataclasses import dataclass

import numpy as np

from pneumaticbox_driver.arrays import Flags, Floats, Valves
from pneumaticbox_driver.faults.pulse_effect import (
    LEAST_DROP,
    RANGE_END,
    SETTLING,
    SMOOTHING,
    UNMOVED,
    PulseEffect,
    Seen,
)
from pneumaticbox_driver.settings import BoxSettings
from softhand_model.gas import air_mass

LESSON = 100  # samples from which a sensor's noise is learnt
# A sensor whose noise is far below its converter's step stands still in its own right. These mark
# noise that shows wherever between two steps the pressure lies: it turns back at a fifth of the
# samples, and reaches four readings. Both together rule out noise at one edge, and a slow drift.
LEAST_REVERSALS = 0.2
LEAST_READINGS = 4
CHANCE = 1e-12  # of a run of equal readings that is still taken for noise
PERIOD = 0.008  # between two looks at what pulses do, which takes ten times as long to show [s]
# A channel at ambient pressure that holds so much more than at rest would have to be pulled open
# by that share, with nothing in it that pulls.
SURPLUS = 0.05  # of the fill at rest
LEAST_SURPLUS = 5e-6  # twice what the estimate drifts within a minute [kg]
EMPTY_FOR = 0.4  # at ambient pressure, to the noise: a hand that moves only passes through [s]
# The supply's sensor is good to 2.5 % of 700 kPa: a supply below this may be none at all.
NO_SUPPLY = 20e3  # gauge [Pa]
SUPPLY_SEEN = 40e3  # gauge; above it there is one [Pa]
SUPPLY_PATIENCE = 0.05  # for noise and for the drop of a pulse [s]
BACKFLOW_PATIENCE = 0.1  # after an inlet was opened; the valve itself takes 40 ms [s]


class FrozenReading:
    """Learns at rest how readings differ, and marks sensors that repeat one for too long.

    `frozen` (m,) marks them, `run` (m,) counts the equal readings in a row. A sensor without
    visible noise is never marked. `noise` (m,) is one sigma [Pa], infinite until it is learnt.

    Args:
        sensors: number of sensors m.
    """

    def __init__(self, sensors: int) -> None:
        self._longest: Floats = np.full(sensors, np.inf)  # run that noise may bring about
        self._last: Floats = np.full(sensors, np.nan)
        self._lesson: list[Floats] = []
        self._learnt = False
        self.run: Floats = np.zeros(sensors)
        self.noise: Floats = np.full(sensors, np.inf)

    @property
    def frozen(self) -> Flags:
        """Sensors whose reading stands still (m,)."""
        return self.run > self._longest

    def look(self, readings: Floats, in_range: Flags) -> None:
        """Take the readings of one sample (m,), as the sensors gave them.

        Those not `in_range` (m,) may well stand still.
        """
        self.run = np.where((readings == self._last) & in_range, self.run + 1.0, 0.0)
        self._last = readings
        if not self._learnt:
            self._lesson.append(readings)
            if len(self._lesson) == LESSON:
                self._learn(np.array(self._lesson))
                self._lesson.clear()

    def _learn(self, lesson: Floats) -> None:
        self._learnt = True
        steps = np.diff(lesson, axis=0)
        self.noise = np.sqrt(0.5 * np.mean(steps**2, axis=0))
        reversals = np.mean(steps[1:] * steps[:-1] < 0, axis=0)
        for sensor in range(lesson.shape[1]):
            readings = len(np.unique(lesson[:, sensor]))
            if reversals[sensor] < LEAST_REVERSALS or readings < LEAST_READINGS:
                continue
            # half the share that was seen: it varies with where between two steps the pressure is
            share = 0.5 * float(np.mean(steps[:, sensor] != 0))
            self._longest[sensor] = math.log(CHANCE) / math.log1p(-share)


@dataclass(frozen=True)
class FaultView:
    """What the watch sees of the box when it looks; arrays (n,), SI, pressures gauge.

    `valves` were commanded until now, `flow` [kg/s] is predicted for them; `mass` [kg] is the
    estimate above rest, `mass_known` marks where it means anything: not in a calibration, and not
    in a channel emptied while its actuator is held away from rest. `ready` tells that the sensors
    have been averaged.
    """

    pressures: Floats
    supply: float
    valves: Valves
    flow: Floats
    mass: Floats
    mass_known: Flags
    ready: bool


class FaultWatch:
    """Takes the readings of each sample, looks at the box when it is due, says what is broken.

    It knows the channels by their rest volume and equation 4.1 alone, so it waits for evidence
    that neither another volume, nor a push, nor a poor calibration can bring about.

    Args:
        settings: of the box.
    """

    def __init__(self, settings: BoxSettings) -> None:
        self._names = settings.channels
        self._settings = settings
        rest = air_mass(settings.ambient, settings.rest_volumes, settings.temperature)
        self._surplus = np.maximum(SURPLUS * rest, LEAST_SURPLUS)
        self._effect = PulseEffect(settings)
        # beyond the limit a sensor may be at its end; the guard sees to that
        self._range_end = np.array([*settings.pressure_limits, np.inf])
        self.begin()

    def begin(self) -> None:
        """Begin anew: nothing is known of the sensors and the supply either."""
        self._frozen = FrozenReading(len(self._names) + 1)
        self._supply_seen = False
        self._lost: Flags = np.zeros(len(self._names), dtype=bool)
        self.restart()

    def restart(self) -> None:
        """Forget the evidence: the user has reset the box."""
        n = len(self._names)
        self._effect.restart()
        self._smooth: Floats = np.full(n, np.nan)  # low-passed pressures [Pa]
        self._spread = 1.0  # of their noise, in squares of the sensor's
        self._since_vented: Floats = np.zeros(n)  # the outlet was last commanded open [s]
        self._closed_for: Floats = np.zeros(n)
        self._highest: Floats = np.full(n, -np.inf)
        self._empty_for: Floats = np.zeros(n)
        self._without_supply = 0.0
        self._backward: Floats = np.zeros(n)
        self._unseen = 0.0  # time since the last look at the pulses [s]

    def due(self, dt: float, readings: Floats) -> bool:
        """Take the readings of a sample, and tell whether it is time to `look`.

        Args:
            dt: time since the last sample [s].
            readings: absolute pressures as the sensors gave them, the supply last (n + 1,) [Pa].
        """
        if not math.isfinite(readings.sum()):
            self._lost = ~np.isfinite(readings[:-1])
            return False  # the box vents for that reason
        self._lost[:] = False
        raw = readings - self._settings.ambient
        self._frozen.look(readings, (raw > RANGE_END) & (raw < self._range_end))
        self._unseen += dt
        return self._unseen > PERIOD - 1e-9

    def look(self, view: FaultView) -> list[str]:
        """Look at the box, once that is `due`.

        Returns:
            Reasons to vent until reset, none when all is well.
        """
        dt, self._unseen = self._unseen, 0.0
        self._follow(dt, view.pressures)
        if not view.ready:
            return []
        noise = self._frozen.noise[:-1] * math.sqrt(self._spread)
        seen = Seen(self._smooth, noise, view.flow, view.mass)
        self._effect.look(dt, seen, view.supply, view.valves)
        return [
            *self._sensor_faults(),
            *self._supply_faults(dt, view),
            *self._pulse_faults(),
            *self._pressure_losses(dt, view),
        ]

    def _follow(self, dt: float, pressures: Floats) -> None:
        """Low-pass the pressures, and keep account of the noise: lost samples let more through."""
        share = dt / (dt + SMOOTHING)
        fresh = np.isnan(self._smooth)
        self._smooth = np.where(fresh, pressures, self._smooth + share * (pressures - self._smooth))
        self._spread = (1 - share) ** 2 * self._spread + share**2

    def stuck_outlets(self) -> list[str]:
        """Say which outlets, commanded open, do not let the air out or may not do so."""
        blind = self._lost | self._frozen.frozen[:-1]
        told = []
        for i, name in enumerate(self._names):
            if blind[i]:
                told.append(f"channel {name}: without its sensor it cannot be seen to empty")
            elif self._effect.unvented[i]:
                told.append(
                    f"channel {name}: pressure does not fall with the outlet commanded open: "
                    "shut off the supply"
                )
        return told

    def _sensor_faults(self) -> list[str]:
        frozen = self._frozen.frozen
        if not frozen.any():
            return []
        names = (*self._names, "supply")
        return [
            f"sensor {names[i]}: its reading stands still" for i in np.flatnonzero(frozen).tolist()
        ]

    def _supply_faults(self, dt: float, view: FaultView) -> list[str]:
        self._supply_seen |= view.supply > SUPPLY_SEEN
        inflating = view.valves > 0
        missing = view.supply < NO_SUPPLY and bool(self._supply_seen or inflating.any())
        self._without_supply = self._without_supply + dt if missing else 0.0
        if self._without_supply > SUPPLY_PATIENCE:
            return ["supply lost: its pressure is below what any channel needs"]
        backward = inflating & (view.supply + 0.5 * LEAST_DROP < self._smooth)
        self._backward = np.where(backward, self._backward + dt, 0.0)
        return [
            f"channel {self._names[i]}: the supply is below its pressure, air flows back"
            for i in np.flatnonzero(self._backward > BACKFLOW_PATIENCE).tolist()
        ]

    def _pulse_faults(self) -> list[str]:
        effect = self._effect
        if not (effect.idle.any() or effect.unvented.any()):
            return []
        told = []
        frozen = self._frozen.frozen
        for i, name in enumerate(self._names):
            if frozen[i]:
                continue
            if effect.unvented[i]:
                told.append(
                    f"channel {name}: pressure does not fall with the outlet commanded open"
                )
            elif effect.idle[i]:
                told.append(
                    f"channel {name}: pulses do not move its pressure: valve stuck or burst"
                )
        return told

    def _pressure_losses(self, dt: float, view: FaultView) -> list[str]:
        """Channels that should hold air and have fallen to ambient pressure by themselves."""
        vented = view.valves < 0
        self._since_vented = np.where(vented, 0.0, self._since_vented + dt)
        self._closed_for = np.where(view.valves == 0, self._closed_for + dt, 0.0)
        apart = self._since_vented > SETTLING
        self._highest = np.where(apart, np.maximum(self._highest, self._smooth), -np.inf)
        # with an outlet open the pressure may fall, whatever the estimate
        empty = (self._closed_for > SETTLING) & (self._highest > 2 * UNMOVED)
        empty &= np.abs(self._smooth) < UNMOVED
        empty &= view.mass_known & (view.mass > self._surplus)
        self._empty_for = np.where(empty, self._empty_for + dt, 0.0)
        return [
            f"channel {self._names[i]}: has lost its pressure with the valve closed: burst, or "
            "outlet stuck open"
            for i in np.flatnonzero(self._empty_for > EMPTY_FOR).tolist()
        ]
