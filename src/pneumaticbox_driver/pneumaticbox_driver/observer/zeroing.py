"""Zeroing of the air-mass estimate: at the start, at ambient, in free posture, on tare."""

import numpy as np

from pneumaticbox_driver.arrays import Flags, Floats, Valves
from pneumaticbox_driver.observer.coefficients import VALVE_DELAY
from pneumaticbox_driver.observer.drift import PostureMass, combine
from pneumaticbox_driver.observer.observer import UNSEEN_DROP, MassObserver
from pneumaticbox_driver.observer.still_pressure import StillPressure
from pneumaticbox_driver.observer.volume_model import VolumeModel
from pneumaticbox_driver.settings import BoxSettings
from softhand_model.gas import GAS_CONSTANT

NEARLY_EMPTY = 2e3  # above it an offset found at ambient hardly changes what flowed out [Pa]
# In an emptied channel: its actuator was held away from rest when it was zeroed [Pa]. Up to there
# the fill at rest is uncertain by 1 %, 0.7 mg in the largest channel of RBO Hand 2.
UNEXPLAINED_PRESSURE = 1e3
LONGEST_START = 1.0  # after which the box no longer waits for pressures to stand still [s]
MISFIT = 3.0  # times the drift bound: more drift means that the calibration does not fit [-]
FAR_PULSES = 5  # after which an estimate far from what the posture tells is drift, and no push
LEAST_MISFIT = 0.5e-6  # drift that is nothing to speak of [kg]
# An actuator is held away from rest that has this much left at ambient pressure, of what it held in
# free posture at its highest pressure; it cannot hold more than it would when bent as far as then.
HELD_SHARE = 0.1
HELD_VOLUME = 1.2
TINY = 1e-9  # of a time that has begun [s]
HELD_PATIENCE = 5.0  # at ambient pressure, after which that is drift all the same [s]


class Zeroing:
    """Sets the estimated masses and the offsets of the sensors where they are known; arrays (n,).

    `ready` says that the sensors have been averaged, `empty` marks channels known to be at ambient
    pressure since their outlet was last open, `offsets` [Pa] are those of the channel sensors,
    `doubted` marks estimates that a fault has made worthless. `drift_correction` weighs the
    estimates against what pressures and free volumes tell; it says that nothing holds the
    actuators.

    Behind an open outlet a pressure that stands still is that of the surroundings: as long as it
    does, sensor and mass stay zeroed. A channel holds its fill at rest there, unless something
    holds its actuator away from rest. If there is much more air in it than drift can explain, the
    estimate stays; it is set to zero when the rest comes out, or after five seconds.

    Args:
        settings: of the box.
        observer: whose estimates are set.
        model: of the channels' volumes.
        notes: takes sentences for the user.
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

    def restart(self) -> None:
        """Begin anew: the sensors are averaged first."""
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
        """Take the estimates for worthless, after a fault, until each channel is zeroed."""
        self.doubted[:] = True
        self.empty[:] = False

    @property
    def still(self) -> bool:
        """Whether the pressures of all channels stand still."""
        return bool(self._still.still.all())

    @property
    def drift_bound(self) -> Floats:
        """How far the estimates may be off, two standard deviations (n,) [kg]."""
        return 2.0 * np.sqrt(self._total_variance())

    def _total_variance(self) -> Floats:
        return np.asarray(self._variance + (0.5 * self._observer.drift_bound) ** 2)

    def steady(self, pressures_abs: Floats) -> Floats:
        """Pressures, absolute (n,) [Pa], averaged over 0.1 s where the valve has rested as long."""
        return np.where(np.isnan(self._still.mean), pressures_abs, self._still.mean)

    def switched(self, changed: Flags, valves: Valves) -> None:
        """Take note of the valves (n,) that have `changed` with this sample."""
        self.empty &= ~changed | (valves == 0)
        self._inflated |= valves > 0
        self._note_high(changed & (valves < 0), self._observer.mass)
        self._still.restart(changed)

    def _note_high(self, channels: Flags, mass: Floats) -> None:
        self._high_mass = np.where(channels, mass, self._high_mass)
        self._high_pressure = np.where(channels, self._pressures, self._high_pressure)

    def look(self, dt: float, pressures_abs: Floats, valves: Valves) -> None:
        """Set what is known by now: at the start, at ambient pressure, in free posture.

        Args:
            dt: since the last sample [s].
            pressures_abs: absolute, offsets taken off (n,) [Pa]; a found one is taken off in place.
            valves: commanded until now (n,).
        """
        self._waited += dt
        self._pressures = pressures_abs - self._settings.ambient
        self._peak = np.maximum(self._peak, self._pressures)
        self._held_for += dt * (self._held_for > 0)
        self.empty &= np.abs(self._pressures) < UNEXPLAINED_PRESSURE
        vented = valves < 0
        if vented.any():
            self._follow_outlets(vented)
        if not self._still.add(dt, pressures_abs):
            return
        if self.ready:
            self._set_known(pressures_abs, valves)
        elif self._still.still.all() or self._waited > LONGEST_START:
            self.tare(pressures_abs)
            self.ready = True

    def _follow_outlets(self, vented: Flags) -> None:
        """Follow the channels whose outlet is open (n,) until they are nearly empty.

        From there on, and all the way where the pressure has come by itself, the estimates are kept
        above what the rest volumes hold at the pressures.
        """
        observer = self._observer
        mass, flow = observer.mass, observer.flow
        high = vented & (self._pressures > NEARLY_EMPTY)
        # the estimate runs ahead by what flows while the valve closes
        self._note_high(high, mass - VALVE_DELAY * np.minimum(flow, 0.0))
        least = self._rest_capacity * (self._pressures - UNSEEN_DROP)
        bounded = vented & ~(high & self._inflated)
        short = np.where(bounded, np.maximum(least - mass, 0.0), 0.0)
        if short.any():
            observer.lift(short)
            self._lifted += short

    def _set_known(self, pressures_abs: Floats, valves: Valves) -> None:
        at_ambient = self._still.still & self._within_zero_band()
        for channel in np.flatnonzero((valves < 0) & at_ambient).tolist():
            self._stand_at_ambient(channel, pressures_abs)
        at_ambient &= np.abs(self._pressures) < UNEXPLAINED_PRESSURE
        for channel in np.flatnonzero(self.doubted & (valves == 0) & at_ambient).tolist():
            self._zero(channel, 0.0)
        if self._held_for.any():
            self._wait_for_rest()
        if self.drift_correction:
            self._correct(
                self._still.still & (valves == 0) & ~self.empty, self.steady(pressures_abs)
            )

    def _correct(self, known: Flags, pressures_abs: Floats) -> None:
        """Weigh the estimates of the channels `known` to be in free posture."""
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
        """Zero a channel that stands still behind its open outlet, or keep what is held in it."""
        error = self._take_offset(channel, pressures_abs)
        self._offset_known[channel] = True
        self.empty[channel] = True
        left = self._left(channel, error)
        if self.drift_correction or self.doubted[channel]:
            self._zero(channel, left)
        elif self._held_away(channel, left):
            if abs(error) > UNSEEN_DROP:
                self._set(channel, left, float(self._total_variance()[channel]))
            self._held_for[channel] = max(self._held_for[channel], TINY)
        else:
            self._zero(channel, left, HELD_SHARE * self._bent_at_peak(channel)[0])

    def _left(self, channel: int, error: float) -> float:
        """What is left in a channel that has come to ambient pressure [kg].

        Where the sensor was off by an `error` [Pa], air seemed to flow when none did. Then it is
        told by how much more volume the channel had than in free posture when it was nearly empty.
        """
        if abs(error) <= UNSEEN_DROP:
            return float(self._observer.mass[channel] - self._lifted[channel])
        ambient = self._settings.ambient
        pressures_abs = self._high_pressure + ambient - error
        more = self._high_mass - self._posture.at(pressures_abs)[0]
        return float(more[channel] * ambient / pressures_abs[channel])

    def _held_away(self, channel: int, left: float) -> bool:
        """Whether more is `left` [kg] in a channel at ambient pressure than drift explains."""
        held, kept = self._bent_at_peak(channel)
        drift = MISFIT * float(self.drift_bound[channel]) + LEAST_MISFIT
        return drift + HELD_SHARE * held < left < HELD_VOLUME * kept

    def _bent_at_peak(self, channel: int) -> tuple[float, float]:
        """What a channel held in free posture at its highest pressure since the last zero, and what
        of it would be left at ambient pressure if it were still bent as far [kg].
        """
        held, kept = self._posture.bent_at(self._peak)
        return float(held[channel]), float(kept[channel])

    def _wait_for_rest(self) -> None:
        """Take held channels to be at rest after all, if they stay at ambient pressure."""
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
        """Take the channel's averaged pressure as ambient; returns how far it was off [Pa]."""
        error = float(self._still.mean[channel]) - self._settings.ambient
        self.offsets[channel] += error
        pressures_abs[channel] -= error
        self._still.shift(channel, -error)
        return error

    def _zero(self, channel: int, drift: float, posture: float = 0.0) -> None:
        """Take the channel's mass as that at rest, and say when its `drift` [kg] is more than it
        may be.

        `posture` [kg] is what an actuator that is held a little away from rest may hold more or
        less than at rest: nothing, where the user says that it is free.
        """
        if self.ready and self._observer.pulses[channel] > 0 and not self.doubted[channel]:
            self._say_misfit(channel, drift, posture)
        self._set(channel, 0.0, 0.0)
        self._held_for[channel] = 0.0
        self._peak[channel] = 0.0
        self._inflated[channel] = False
        self.doubted[channel] = False

    def _say_misfit(self, channel: int, drift: float, posture: float = 0.0) -> None:
        """Tell the user of a `drift` [kg] that neither calibration nor `posture` [kg] explain."""
        bound = max(MISFIT * float(self.drift_bound[channel]), LEAST_MISFIT) + posture
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
        """Set all masses from the averaged pressures; returns the channels not at ambient.

        Those have the volume of their free posture. `pressures_abs` (n,) [Pa] are absolute; a found
        offset is taken off in place.
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
