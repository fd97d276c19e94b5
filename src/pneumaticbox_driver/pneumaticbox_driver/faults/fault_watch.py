"""Fault watch: detects faults of valves, tubes, sensors and supply from the pressures."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from pneumaticbox_driver.arrays import Flags, Floats, Valves, some
from pneumaticbox_driver.faults.frozen_reading import FrozenReading
from pneumaticbox_driver.faults.pulse_effect import (
    EFFECT_SETTLING,
    LEAST_DROP,
    PRESSURE_SMOOTHING,
    RANGE_END,
    UNMOVED,
    PulseEffect,
    Seen,
)
from pneumaticbox_driver.settings import BoxSettings
from softhand_common.numerics.compiled import compiled
from softhand_model.gas import air_mass

FAULT_PERIOD = 0.008  # between two checks of pulses, whose effects take ten times as long [s]
# A channel at ambient pressure that holds so much more than at rest would have to be pulled open
# by that share, with nothing in it that pulls.
SURPLUS = 0.05  # of the fill at rest
LEAST_SURPLUS = 5e-6  # twice what the estimate drifts within a minute [kg]
EMPTY_FOR = 0.4  # at ambient pressure, to the noise: a hand that moves only passes through [s]
# The supply's sensor is good to 2.5 % of 700 kPa: a supply below this may be none at all.
NO_SUPPLY = 20e3  # gauge [Pa]
SUPPLY_SEEN = 40e3  # gauge; above it there is a supply [Pa]
SUPPLY_PATIENCE = 0.05  # longer than noise and the drop by a pulse [s]
BACKFLOW_PATIENCE = 0.1  # after the opening of an inlet, which takes 40 ms [s]
NO_SUPPLY_REASON = "supply lost: its pressure is below what any channel needs"


@dataclass(frozen=True)
class FaultView:
    """State of the box for the fault watch; arrays (n,), SI units, gauge pressures.

    `valves` were commanded until now, `flow` [kg/s] is predicted for them; `mass` [kg] is the
    estimate above rest, `mass_known` marks valid estimates: not during a calibration, and not in a
    channel that was emptied while its actuator was held away from rest. `ready` is whether the
    sensors have been averaged.
    """

    pressures: Floats
    supply: float
    valves: Valves
    flow: Floats
    mass: Floats
    mass_known: Flags
    ready: bool


class FaultWatch:
    """Detects faults from the readings of each sample and from periodic checks of the box.

    It knows only the rest volumes and equation 4.1, and therefore waits for evidence that cannot be
    explained by another volume, by an external force or by a poor calibration.

    Args:
        settings: settings of the box.
    """

    def __init__(self, settings: BoxSettings) -> None:
        self._names = settings.channels
        self._settings = settings
        rest = air_mass(settings.ambient, settings.rest_volumes, settings.temperature)
        self._surplus = np.maximum(SURPLUS * rest, LEAST_SURPLUS)
        self._effect = PulseEffect(settings)
        # beyond the pressure limit, which the guard handles, a sensor may saturate
        self._range_end = np.array([*settings.pressure_limits, np.inf])
        self._in_range = np.zeros(len(self._range_end), dtype=bool)
        self._rehearse()
        self.begin()

    def _rehearse(self) -> None:
        """Compile or load the kernels before the first sample."""
        zeros, no = np.zeros(len(self._names)), np.zeros(len(self._names), dtype=bool)
        self.begin()
        self.due(0.0, np.full(len(self._range_end), self._settings.ambient))
        self.look(FaultView(zeros, 0.0, no.astype(np.int8), zeros, zeros, no, ready=True))

    def begin(self) -> None:
        """Clear all evidence, including that on sensors and supply."""
        self._frozen = FrozenReading(len(self._names) + 1)
        self._supply_seen = False
        self._lost: Flags = np.zeros(len(self._names), dtype=bool)
        self.restart()

    def restart(self) -> None:
        """Clear the evidence after a reset of the box."""
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
        """Add the readings of a sample; returns whether `look` is due.

        Args:
            dt: time since the last sample [s].
            readings: absolute pressures as read by the sensors, the supply last (n + 1,) [Pa].
        """
        if not look_at_range(readings, self._settings.ambient, self._range_end, self._in_range):
            self._lost = ~np.isfinite(readings[:-1])
            return False  # the box vents for this reason
        self._lost[:] = False
        self._frozen.look(readings, self._in_range)
        self._unseen += dt
        return self._unseen > FAULT_PERIOD - 1e-9

    def look(self, view: FaultView) -> list[str]:
        """Check the box; call it when `due`.

        Returns:
            Reasons to vent until reset; none without a fault.
        """
        dt, self._unseen = self._unseen, 0.0
        self._follow(dt, view.pressures)
        if not view.ready:
            return []
        noise = self._frozen.noise[:-1] * math.sqrt(self._spread)
        seen = Seen(self._smooth, noise, view.flow, view.mass)
        self._effect.look(dt, seen, view.supply, view.valves)
        lost = self._supply_lost(dt, view)
        memory = self._since_vented, self._closed_for, self._highest
        evidence = self._empty_for, self._backward
        air = self._smooth, view.mass, view.mass_known, view.valves
        supply = math.inf if lost else view.supply
        told = watch_air(dt, supply, air, self._surplus, memory, evidence)
        return [
            *self._sensor_faults(),
            *([NO_SUPPLY_REASON] if lost else self._backflow() if told else ()),
            *self._pulse_faults(),
            *(self._pressure_losses() if told else ()),
        ]

    def _follow(self, dt: float, pressures: Floats) -> None:
        """Low-pass the pressures and update their noise, which grows with lost samples."""
        share = dt / (dt + PRESSURE_SMOOTHING)
        self._smooth = self._smooth.copy()  # what was handed out stays
        smooth_pressures(share, pressures, self._smooth)
        self._spread = (1 - share) ** 2 * self._spread + share**2

    def stuck_outlets(self) -> list[str]:
        """Warnings on channels that do not empty, or may not empty, with the outlet commanded
        open.
        """
        blind = self._lost | self._frozen.frozen[:-1]
        warnings = []
        for i, name in enumerate(self._names):
            if blind[i]:
                warnings.append(f"channel {name}: without its sensor it cannot be seen to empty")
            elif self._effect.unvented[i]:
                warnings.append(
                    f"channel {name}: pressure does not fall with the outlet commanded open: "
                    "shut off the supply"
                )
        return warnings

    def _sensor_faults(self) -> list[str]:
        frozen = self._frozen.frozen
        if not some(frozen):
            return []
        names = (*self._names, "supply")
        return [
            f"sensor {names[i]}: its reading is constant" for i in np.flatnonzero(frozen).tolist()
        ]

    def _supply_lost(self, dt: float, view: FaultView) -> bool:
        self._supply_seen |= view.supply > SUPPLY_SEEN
        missing = view.supply < NO_SUPPLY and (self._supply_seen or some(view.valves > 0))
        self._without_supply = self._without_supply + dt if missing else 0.0
        return self._without_supply > SUPPLY_PATIENCE

    def _backflow(self) -> list[str]:
        return [
            f"channel {self._names[i]}: the supply is below its pressure, air flows back"
            for i in np.flatnonzero(self._backward > BACKFLOW_PATIENCE).tolist()
        ]

    def _pulse_faults(self) -> list[str]:
        effect = self._effect
        if not (some(effect.idle) or some(effect.unvented)):
            return []
        faults = []
        frozen = self._frozen.frozen
        for i, name in enumerate(self._names):
            if frozen[i]:
                continue
            if effect.unvented[i]:
                faults.append(
                    f"channel {name}: pressure does not fall with the outlet commanded open"
                )
            elif effect.idle[i]:
                faults.append(
                    f"channel {name}: pulses do not move its pressure: valve stuck or burst"
                )
        return faults

    def _pressure_losses(self) -> list[str]:
        """Channels that should contain air but have lost it with the valve closed."""
        return [
            f"channel {self._names[i]}: has lost its pressure with the valve closed: burst, or "
            "outlet stuck open"
            for i in np.flatnonzero(self._empty_for > EMPTY_FOR).tolist()
        ]


@compiled
def look_at_range(readings: Floats, ambient: float, range_end: Floats, in_range: Flags) -> bool:
    """Mark the readings (m,) [Pa] `in_range` (m,), in gauge pressure between RANGE_END and
    `range_end` (m,) [Pa]; returns whether all readings are finite.
    """
    total = 0.0
    for i in range(len(readings)):
        total += readings[i]
        in_range[i] = RANGE_END < readings[i] - ambient < range_end[i]
    return math.isfinite(total)


@compiled
def smooth_pressures(share: float, pressures: Floats, smooth: Floats) -> None:
    """Move low-passed pressures (n,) [Pa], NaN before the first, by a share [-] of their distance
    to the present ones (n,) [Pa], in place.
    """
    for i in range(len(smooth)):
        if math.isnan(smooth[i]):
            smooth[i] = pressures[i]
        else:
            smooth[i] += share * (pressures[i] - smooth[i])


@compiled
def watch_air(
    dt: float, supply: float, air: Any, surplus: Floats, memory: Any, evidence: Any
) -> bool:
    """Follow the channels (n,) for `dt` [s]; returns whether a channel has lost its air, or lets it
    flow back to the supply.

    Args:
        dt: time since the last look [s].
        supply: gauge pressure of the supply, infinite for a supply that is lost [Pa].
        air: low-passed gauge pressures [Pa], estimated masses [kg], which of them are known, and
            the commanded valves, each (n,).
        surplus: mass above that at rest from which on a channel should be under pressure (n,) [kg].
        memory: times since the outlet was commanded open and since the valve is closed [s], and the
            highest pressure since [Pa], each (n,), changed in place.
        evidence: times for which a channel that should contain air was empty, and for which its
            pressure was above that of the open inlet [s], each (n,), changed in place.
    """
    smooth, mass, mass_known, valves = air
    since_vented, closed_for, highest = memory
    empty_for, backward = evidence
    told = False
    for i in range(len(smooth)):
        if supply < np.inf:
            back = valves[i] > 0 and supply + 0.5 * LEAST_DROP < smooth[i]
            backward[i] = backward[i] + dt if back else 0.0
        since_vented[i] = 0.0 if valves[i] < 0 else since_vented[i] + dt
        closed_for[i] = closed_for[i] + dt if valves[i] == 0 else 0.0
        # an open outlet lowers the pressure without a fault
        apart = since_vented[i] > EFFECT_SETTLING
        highest[i] = max(highest[i], smooth[i]) if apart else -np.inf
        empty = closed_for[i] > EFFECT_SETTLING and highest[i] > 2 * UNMOVED
        empty = empty and abs(smooth[i]) < UNMOVED and mass_known[i] and mass[i] > surplus[i]
        empty_for[i] = empty_for[i] + dt if empty else 0.0
        told |= empty_for[i] > EMPTY_FOR or backward[i] > BACKFLOW_PATIENCE
    return told
