"""Zeroing of the air-mass estimate: at the start, at ambient, in free posture, on tare."""

from typing import Any

import numpy as np

from pneumaticbox_driver.arrays import Flags, Floats, Valves, some
from pneumaticbox_driver.observer.coefficients import VALVE_DELAY
from pneumaticbox_driver.observer.drift import PostureMass, combine
from pneumaticbox_driver.observer.observer import UNSEEN_DROP, MassObserver
from pneumaticbox_driver.observer.still_pressure import StillPressure
from pneumaticbox_driver.observer.volume_model import VolumeModel
from pneumaticbox_driver.settings import BoxSettings
from softhand_common.numerics.compiled import compiled
from softhand_model.gas import GAS_CONSTANT

NEARLY_EMPTY = 2e3  # above it, an offset found at ambient pressure hardly affects the outflow [Pa]
# Pressure of an emptied channel whose actuator was held away from rest when it was zeroed [Pa].
# Below it the air mass at rest is uncertain by 1 %, 0.7 mg in the largest channel of RBO Hand 2.
UNEXPLAINED_PRESSURE = 1e3
LONGEST_START = 1.0  # longest wait for constant pressures at the start [s]
DRIFT_MISFIT = 3.0  # times the drift bound; a larger drift means a wrong calibration [-]
FAR_PULSES = 5  # after which a wrong estimate is due to drift and not to a contact
LEAST_MISFIT = 0.5e-6  # negligible drift [kg]
# An actuator is held away from rest if this share of its content in free posture at the highest
# pressure is left at ambient pressure. It cannot contain more than HELD_VOLUME times the content at
# ambient pressure in the posture of that highest pressure.
HELD_SHARE = 0.1
HELD_VOLUME = 1.2
HELD_BEGUN = 1e-9  # marks the start of the time below [s]
HELD_PATIENCE = 5.0  # at ambient pressure, after which the content is taken as drift [s]


class Zeroing:
    """Sets the estimated masses and the offsets of the sensors when they are known; arrays (n,).

    `ready` is whether the sensors have been averaged, `empty` marks channels known to be at ambient
    pressure since their outlet was last open, `offsets` [Pa] are those of the channel sensors,
    `doubted` marks estimates that a fault has invalidated. `drift_correction` combines the
    estimates with those from pressures and free volumes, assuming that nothing holds the actuators.

    With an open outlet a constant pressure is ambient pressure: sensor and mass are then set to
    zero. The channel contains its air mass at rest, unless its actuator is held away from rest. If
    it contains much more air than drift can explain, the estimate is kept; it is set to zero when
    that air has left, or after five seconds.

    Args:
        settings: settings of the box.
        observer: the observer of the air masses.
        model: model of the channels' volumes.
        notes: list for warnings to the user.
    """

    def __init__(
        self,
        settings: BoxSettings,
        observer: MassObserver,
        model: VolumeModel,
        notes: list[str],
    ) -> None:
        n = len(settings.channels)
        self.offsets: Floats = np.zeros(n)
        self.drift_correction = False
        self._settings = settings
        self._observer = observer
        self._posture = PostureMass(settings, model)
        self._notes = notes
        self._still = StillPressure(n)
        self._rest_capacity = np.array(settings.rest_volumes) / (
            GAS_CONSTANT * settings.temperature
        )  # [kg/Pa]
        self._offset_known: Flags = np.zeros(n, dtype=bool)  # found behind an open outlet
        self._variance: Floats = np.zeros(n)  # of the masses when they were last set [kg2]
        self._lifted: Floats = np.zeros(n)  # by `_follow_outlets` since the mass was set [kg]
        self._pressures: Floats = np.zeros(n)  # of the last sample, gauge [Pa]
        self.restart()
        self._follow(0.0, np.full(n, settings.ambient), np.full(n, -1, dtype=np.int8))
        # now the kernels are compiled or loaded, before the first sample

    def restart(self) -> None:
        """Return to the state at the start, in which the sensors are averaged."""
        n = len(self.offsets)
        self.ready = False
        self.empty: Flags = np.zeros(n, dtype=bool)
        self.doubted: Flags = np.zeros(n, dtype=bool)
        self._held_for: Floats = np.zeros(n)  # with more air than at rest, at ambient pressure [s]
        self._far_since = np.full(n, -1)  # pulses at which the estimate was too far off, or -1
        self._peak: Floats = np.zeros(n)  # highest gauge pressure since the last zero [Pa]
        self._inflated: Flags = np.zeros(n, dtype=bool)  # since it was zeroed
        self._high_mass: Floats = np.zeros(n)  # of the outlet's pulse: when it was last above
        self._high_pressure: Floats = np.zeros(n)  # `NEARLY_EMPTY` [kg], and its pressure [Pa]
        self._still.restart()
        self._waited = 0.0

    def doubt(self) -> None:
        """Mark all estimates as invalid after a fault, until each channel is zeroed."""
        self.doubted[:] = True
        self.empty[:] = False

    @property
    def still(self) -> bool:
        """Whether the pressures of all channels are constant."""
        return bool(self._still.still.all())

    @property
    def drift_bound(self) -> Floats:
        """Possible error (n,) [kg] of each estimated mass: two standard deviations, from its last
        zeroing and the pulses since.
        """
        return 2.0 * np.sqrt(self._total_variance())

    def _total_variance(self) -> Floats:
        return np.asarray(self._variance + (0.5 * self._observer.drift_bound) ** 2)

    def steady(self, pressures_abs: Floats) -> Floats:
        """Averages over 0.1 s of the absolute pressures (n,) [Pa] where the valve was closed that
        long, else the given ones.
        """
        return np.where(np.isnan(self._still.mean), pressures_abs, self._still.mean)

    def switched(self, changed: Flags, valves: Valves) -> None:
        """Update the state for valves (n,) that have `changed` with this sample."""
        self.empty &= ~changed | (valves == 0)
        self._inflated |= valves > 0
        self._note_high(changed & (valves < 0), self._observer.mass)
        self._still.restart(changed)

    def _note_high(self, channels: Flags, mass: Floats) -> None:
        self._high_mass = np.where(channels, mass, self._high_mass)
        self._high_pressure = np.where(channels, self._pressures, self._high_pressure)

    def look(self, dt: float, pressures_abs: Floats, valves: Valves) -> None:
        """Set known masses and offsets: at the start, at ambient pressure, in free posture.

        Args:
            dt: time since the last sample [s].
            pressures_abs: absolute pressures without offsets (n,) [Pa]; a new offset is subtracted
                in place.
            valves: valves commanded until now (n,).
        """
        self._waited += dt
        self._follow(dt, pressures_abs, valves)
        if not self._still.add(dt, pressures_abs):
            return
        if self.ready:
            self._set_known(pressures_abs, valves)
        elif self._still.still.all() or self._waited > LONGEST_START:
            self.tare(pressures_abs)
            self.ready = True

    def _follow(self, dt: float, pressures_abs: Floats, valves: Valves) -> None:
        """Note the pressures, and track the channels whose outlet is open until they are nearly
        empty.

        From then on, and always for channels that were not inflated, the estimates are kept above
        the air masses of the rest volumes at the measured pressures.
        """
        observer, ambient = self._observer, self._settings.ambient
        channels = self._pressures, self._peak, self._held_for, self.empty
        follow_pressures(dt, pressures_abs, ambient, *channels)
        if -1 not in valves.tolist():
            return
        short = np.empty_like(pressures_abs)
        air = observer.mass, observer.flow, self._pressures
        high = self._high_mass, self._high_pressure
        if follow_outlets(air, valves, self._inflated, self._rest_capacity, high, short):
            observer.lift(short)
            self._lifted += short

    def _set_known(self, pressures_abs: Floats, valves: Valves) -> None:
        at_ambient = self._still.still & self._within_zero_band()
        for channel in np.flatnonzero((valves < 0) & at_ambient).tolist():
            self._stand_at_ambient(channel, pressures_abs)
        at_ambient &= np.abs(self._pressures) < UNEXPLAINED_PRESSURE
        for channel in np.flatnonzero(self.doubted & (valves == 0) & at_ambient).tolist():
            self._zero(channel, 0.0)
        if some(self._held_for):
            self._wait_for_rest()
        if self.drift_correction:
            self._correct(
                self._still.still & (valves == 0) & ~self.empty, self.steady(pressures_abs)
            )

    def _correct(self, known: Flags, pressures_abs: Floats) -> None:
        """Combine the estimates of channels `known` to be in free posture with measured masses."""
        if not known.any():
            return
        measured, noise = self._posture.at(pressures_abs)
        estimate, variance = self._observer.mass, self._total_variance()
        mass, variance, used, far = combine(estimate, variance, measured, noise)
        pulses = self._observer.pulses
        self._far_since = np.where(far & (self._far_since < 0), pulses, self._far_since)
        self._far_since = np.where(known & ~far, -1, self._far_since)
        for channel in np.flatnonzero(known & used).tolist():
            self._set(channel, float(mass[channel]), float(variance[channel]))
        persistent = known & far & (pulses - self._far_since >= FAR_PULSES)
        for channel in np.flatnonzero(persistent).tolist():
            self._say_misfit(channel, float(estimate[channel] - measured[channel]))
            self._set(channel, float(measured[channel]), float(noise[channel]))

    # at ambient pressure

    def _stand_at_ambient(self, channel: int, pressures_abs: Floats) -> None:
        """Zero a channel of constant pressure with an open outlet, or keep the air held in it."""
        error = self._take_offset(channel, pressures_abs)
        self._offset_known[channel] = True
        self.empty[channel] = True
        left = self._left(channel, error)
        if self.drift_correction or self.doubted[channel]:
            self._zero(channel, left)
        elif self._held_away(channel, left):
            if abs(error) > UNSEEN_DROP:
                self._set(channel, left, float(self._total_variance()[channel]))
            self._held_for[channel] = max(self._held_for[channel], HELD_BEGUN)
        else:
            self._zero(channel, left, HELD_SHARE * self._bent_at_peak(channel)[0])

    def _left(self, channel: int, error: float) -> float:
        """Air mass left in a channel that has reached ambient pressure [kg].

        With an offset `error` [Pa] of the sensor there was an apparent flow. Then the air mass is
        computed from the volume in excess of free posture of the nearly empty channel.
        """
        if abs(error) <= UNSEEN_DROP:
            return float(self._observer.mass[channel] - self._lifted[channel])
        ambient = self._settings.ambient
        pressures_abs = self._high_pressure + ambient - error
        more = self._high_mass - self._posture.at(pressures_abs)[0]
        return float(more[channel] * ambient / pressures_abs[channel])

    def _held_away(self, channel: int, left: float) -> bool:
        """Whether a channel at ambient pressure has more air `left` [kg] than drift explains."""
        held, kept = self._bent_at_peak(channel)
        drift = DRIFT_MISFIT * float(self.drift_bound[channel]) + LEAST_MISFIT
        return drift + HELD_SHARE * held < left < HELD_VOLUME * kept

    def _bent_at_peak(self, channel: int) -> tuple[float, float]:
        """Air masses above rest of a channel in free posture at its highest pressure since the last
        zeroing, and in the same posture at ambient pressure [kg].
        """
        held, kept = self._posture.bent_at(self._peak)
        return float(held[channel]), float(kept[channel])

    def _wait_for_rest(self) -> None:
        """Zero held channels that stay at ambient pressure for HELD_PATIENCE."""
        self._held_for = np.where(self.empty, self._held_for, 0.0)
        for channel in np.flatnonzero(self._held_for > HELD_PATIENCE).tolist():
            name, mass = self._settings.channels[channel], self._observer.mass[channel]
            self._notes.append(
                f"channel {name} kept {1e6 * mass:.1f} mg at ambient pressure for "
                f"{HELD_PATIENCE:.0f} s: zeroed, as if nothing held its actuator"
            )
            self._zero(channel, 0.0)

    def _within_zero_band(self) -> Flags:
        reading = self._still.mean + self.offsets - self._settings.ambient
        return np.abs(reading) < self._settings.zero_band

    def _take_offset(self, channel: int, pressures_abs: Floats) -> float:
        """Set the offset of a channel from its averaged pressure at ambient pressure; returns the
        error of the former offset [Pa].
        """
        error = float(self._still.mean[channel]) - self._settings.ambient
        self.offsets[channel] += error
        pressures_abs[channel] -= error
        self._still.shift(channel, -error)
        return error

    def _zero(self, channel: int, drift: float, posture: float = 0.0) -> None:
        """Set a channel's mass to that at rest, and warn of a `drift` [kg] above its bound.

        `posture` [kg] is the tolerance for an actuator that is not exactly at rest; 0 if the user
        has stated that it is free.
        """
        if self.ready and self._observer.pulses[channel] > 0 and not self.doubted[channel]:
            self._say_misfit(channel, drift, posture)
        self._set(channel, 0.0, 0.0)
        self._held_for[channel] = 0.0
        self._peak[channel] = 0.0
        self._inflated[channel] = False
        self.doubted[channel] = False

    def _say_misfit(self, channel: int, drift: float, posture: float = 0.0) -> None:
        """Warn of a `drift` [kg] that neither calibration nor `posture` [kg] explain."""
        bound = max(DRIFT_MISFIT * float(self.drift_bound[channel]), LEAST_MISFIT) + posture
        if abs(drift) > bound:
            self._notes.append(
                f"calibration does not fit channel {self._settings.channels[channel]}: its air "
                f"mass had drifted by {1e6 * drift:.1f} mg, of {1e6 * bound:.1f} mg at most"
            )

    def _set(self, channel: int, mass: float, variance: float) -> None:
        self._observer.set_mass(channel, mass)
        self._variance[channel] = variance
        self._lifted[channel] = 0.0
        self._far_since[channel] = -1

    # tare

    def tare(self, pressures_abs: Floats) -> list[str]:
        """Set all masses from the averaged pressures; returns the channels not at ambient pressure.

        For these the volume is that of free posture. `pressures_abs` (n,) [Pa] are absolute; a new
        offset is subtracted in place.
        """
        steady = self.steady(pressures_abs)
        off = np.abs(steady - self._settings.ambient)
        at_ambient = self._within_zero_band()
        at_ambient &= ~self._offset_known | (off < UNEXPLAINED_PRESSURE)
        masses, variances = self._posture.at(steady)
        under_pressure = []
        for channel, name in enumerate(self._settings.channels):
            if at_ambient[channel]:
                self._take_offset(channel, pressures_abs)
                held = self._held_for[channel] > 0
                drift = 0.0 if held else self._observer.mass[channel] - self._lifted[channel]
                self._zero(channel, float(drift))
                self.empty[channel] = True
                continue
            self._set(channel, float(masses[channel]), float(variances[channel]))
            self.doubted[channel] = False
            under_pressure.append(name)
        self._still.restart()
        if under_pressure:
            self._notes.append(f"tared under pressure by the free volume: {under_pressure}")
        return under_pressure


@compiled
def follow_pressures(
    dt: float,
    pressures_abs: Floats,
    ambient: float,
    pressures: Floats,
    peak: Floats,
    held_for: Floats,
    empty: Flags,
) -> None:
    """Bring the state of the channels (n,) to absolute pressures (n,) [Pa] `dt` [s] later, in
    place: gauge `pressures` and their `peak` [Pa], how long air was held [s], and which are empty.
    """
    for i in range(len(pressures)):
        pressures[i] = pressures_abs[i] - ambient
        peak[i] = max(peak[i], pressures[i])
        if held_for[i] > 0:
            held_for[i] += dt
        empty[i] &= abs(pressures[i]) < UNEXPLAINED_PRESSURE


@compiled
def follow_outlets(
    air: Any, valves: Valves, inflated: Flags, rest_capacity: Floats, high: Any, short: Floats
) -> bool:
    """Track the channels (n,) whose outlet is open, in place; returns whether an estimate is too
    low.

    Args:
        air: estimated mass [kg] and flow [kg/s], and gauge pressure [Pa], each (n,).
        valves: valves commanded until now (n,).
        inflated: channels that were inflated since they were zeroed (n,).
        rest_capacity: air that a rest volume takes per pressure (n,) [kg/Pa].
        high: mass [kg] when the pressure was last above `NEARLY_EMPTY`, and that pressure [Pa],
            each (n,), changed in place.
        short: result, by how much the mass is below that of the rest volume (n,) [kg].
    """
    mass, flow, pressures = air
    high_mass, high_pressure = high
    some_short = False
    for i in range(len(valves)):
        short[i] = 0.0
        if valves[i] >= 0:
            continue
        above = pressures[i] > NEARLY_EMPTY
        if above:
            # the estimate is ahead by the air that flows while the valve closes
            high_mass[i] = mass[i] - VALVE_DELAY * min(flow[i], 0.0)
            high_pressure[i] = pressures[i]
        if not (above and inflated[i]):
            least = rest_capacity[i] * (pressures[i] - UNSEEN_DROP)
            short[i] = max(least - mass[i], 0.0)
            some_short |= short[i] > 0.0
    return some_short
