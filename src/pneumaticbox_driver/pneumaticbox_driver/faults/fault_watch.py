"""Fault watch: detects faults of valves, tubes, sensors and supply from the pressures."""

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import betaincinv

from pneumaticbox_driver.arrays import Flags, Floats, Valves, some
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

LEARNING_SAMPLES = 100  # from which the noise of a sensor is learnt
# The reading of a sensor with noise far below the step of its converter may be constant without a
# fault. A sensor has sufficient noise if a fifth of its changes reverse direction and it has four
# different readings: this excludes noise at the edge of one step, and slow drift.
LEAST_REVERSALS = 0.2
LEAST_READINGS = 4
FROZEN_CHANCE = 1e-12  # of a run of equal readings that is still taken for noise
COMMON_NOISE = 0.5  # correlation of sensors' noise from which it is that of one source
# Sensors that stand still together may do so for a moment because a board hands out old readings.
FEWEST_TOGETHER = 10
REPEATS_DOUBT = 1e-3  # that a sensor repeats readings more often than its lesson lets one expect
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


class FrozenReading:
    """Learns the noise of sensors at rest, and marks sensors with a constant reading.

    `frozen` (m,) marks them, `run` (m,) counts the equal readings in a row. Sensors with noise of
    their own that all stand still are marked sooner, as the chances multiply. A sensor without
    visible noise is never marked. `noise` (m,) is one sigma [Pa], infinite until it is learnt.

    Args:
        sensors: number of sensors m.
    """

    def __init__(self, sensors: int) -> None:
        self._longest: Floats = np.full(sensors, np.inf)  # run that noise may bring about
        self._together: Flags = np.zeros(sensors, dtype=bool)  # whose noise shows and is their own
        self._longest_together = np.inf  # run of all those that noise may bring about
        self._last: Floats = np.full(sensors, np.nan)
        self._lesson: list[Floats] = []
        self._learnt = False
        self.run: Floats = np.zeros(sensors)
        self.noise: Floats = np.full(sensors, np.inf)
        # compile or load the kernel before the first sample
        count_repeats(self._last, self._together, self._last.copy(), self.run)

    @property
    def frozen(self) -> Flags:
        """Sensors whose reading stands still (m,)."""
        frozen = self.run > self._longest
        if some(self._together) and self.run[self._together].min() > self._longest_together:
            frozen |= self._together
        return frozen

    def look(self, readings: Floats, in_range: Flags) -> None:
        """Add the unprocessed readings of one sample (m,).

        Sensors that are not `in_range` (m,) may have a constant reading without a fault.
        """
        count_repeats(readings, in_range, self._last, self.run)
        if not self._learnt:
            self._lesson.append(readings.copy())
            if len(self._lesson) == LEARNING_SAMPLES:
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
            repeats = _share_of_repeats(steps[:, sensor], self.noise[sensor])
            self._longest[sensor] = math.log(FROZEN_CHANCE) / math.log(repeats)
        noisy = np.isfinite(self._longest)
        if noisy.any() and _greatest_correlation(steps[:, noisy]) < COMMON_NOISE:
            self._together = noisy
            chance = 1.0 / np.sum(1.0 / self._longest[noisy])  # the logarithms add up
            self._longest_together = max(float(chance), FEWEST_TOGETHER)


@compiled
def count_repeats(readings: Floats, in_range: Flags, last: Floats, run: Floats) -> None:
    """Count equal readings in a row (m,) of sensors `in_range` (m,), and keep the `last` ones, in
    place.
    """
    for i in range(len(run)):
        run[i] = run[i] + 1.0 if in_range[i] and readings[i] == last[i] else 0.0
        last[i] = readings[i]


def _greatest_correlation(steps: Floats) -> float:
    """Greatest correlation between columns of `steps` (n, k)."""
    correlations = np.atleast_2d(np.corrcoef(steps, rowvar=False))
    return float(np.abs(np.triu(correlations, 1)).max())


def _share_of_repeats(steps: Floats, noise: float) -> float:
    """Upper bound of the probability that a reading equals the one before it, wherever between two
    steps of the converter the pressure lies.

    The larger of two bounds: the upper confidence limit (Clopper and Pearson) of the share among
    `steps` (n,) [Pa], the differences of readings, and the share of normal noise of one sigma
    `noise` [Pa] in the step of the converter around its mean. The latter also holds for noise that
    is correlated from sample to sample (AR(1)): `noise` then is at most that of its innovations.
    """
    moved = np.abs(steps[steps != 0])
    equal = len(steps) - len(moved)
    seen = float(betaincinv(equal + 1, len(steps) - equal, 1.0 - REPEATS_DOUBT))
    return max(seen, math.erf(moved.min() / (2.0 * math.sqrt(2.0) * noise)))


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
        settings: of the box.
    """

    def __init__(self, settings: BoxSettings) -> None:
        self._names = settings.channels
        self._settings = settings
        rest = air_mass(settings.ambient, settings.rest_volumes, settings.temperature)
        self._surplus = np.maximum(SURPLUS * rest, LEAST_SURPLUS)
        self._effect = PulseEffect(settings)
        # beyond the pressure limit, which the guard handles, a sensor may saturate
        self._range_end = np.array([*settings.pressure_limits, np.inf])
        self.begin()

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
        if not math.isfinite(sum(readings.tolist())):
            self._lost = ~np.isfinite(readings[:-1])
            return False  # the box vents for this reason
        self._lost[:] = False
        raw = readings - self._settings.ambient
        self._frozen.look(readings, (raw > RANGE_END) & (raw < self._range_end))
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
        return [
            *self._sensor_faults(),
            *self._supply_faults(dt, view),
            *self._pulse_faults(),
            *self._pressure_losses(dt, view),
        ]

    def _follow(self, dt: float, pressures: Floats) -> None:
        """Low-pass the pressures and update their noise, which grows with lost samples."""
        share = dt / (dt + PRESSURE_SMOOTHING)
        fresh = np.isnan(self._smooth)
        self._smooth = np.where(fresh, pressures, self._smooth + share * (pressures - self._smooth))
        self._spread = (1 - share) ** 2 * self._spread + share**2

    def stuck_outlets(self) -> list[str]:
        """Warnings on channels that do not empty, or may not, with the outlet commanded open."""
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

    def _supply_faults(self, dt: float, view: FaultView) -> list[str]:
        self._supply_seen |= view.supply > SUPPLY_SEEN
        inflating = view.valves > 0
        missing = view.supply < NO_SUPPLY and (self._supply_seen or some(inflating))
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

    def _pressure_losses(self, dt: float, view: FaultView) -> list[str]:
        """Channels that should contain air but have lost it with the valve closed."""
        vented = view.valves < 0
        self._since_vented = np.where(vented, 0.0, self._since_vented + dt)
        self._closed_for = np.where(view.valves == 0, self._closed_for + dt, 0.0)
        apart = self._since_vented > EFFECT_SETTLING
        self._highest = np.where(apart, np.maximum(self._highest, self._smooth), -np.inf)
        # an open outlet lowers the pressure without a fault
        empty = (self._closed_for > EFFECT_SETTLING) & (self._highest > 2 * UNMOVED)
        empty &= np.abs(self._smooth) < UNMOVED
        empty &= view.mass_known & (view.mass > self._surplus)
        self._empty_for = np.where(empty, self._empty_for + dt, 0.0)
        return [
            f"channel {self._names[i]}: has lost its pressure with the valve closed: burst, or "
            "outlet stuck open"
            for i in np.flatnonzero(self._empty_for > EMPTY_FOR).tolist()
        ]
