"""Live prediction of a hand's free tip angles from its pressures, sample by sample.

Simulator and lab use the same kernel: the free rotation of the chains under the model's effects.
The memory of effects is stepped from one angle sample to the next, with the pressure at its time
stamp.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from model_lab.aliases import Array, Mask
from softhand_common.documents.quoted import listed
from softhand_model.chain.chain import BEND_AXIS, discretise
from softhand_model.effects.pipeline import StagedEffects
from softhand_model.effects.stages import InputEffect, OutputEffect
from softhand_model.gas import ROOM_TEMPERATURE
from softhand_model.hand.hand import ChainDescription, HandDescription
from softhand_model.model_file import Model

PRESSURE_HISTORY = (
    5 * 10**9
)  # time [ns] for which pressures are kept; angles that come later find none
PRESSURE_GAP = 250_000_000  # [ns]; chosen by hand: 50 samples of a driver at 200 Hz
CHAIN_SEGMENTS = 5  # of an actuator; the free tip angle of a straight one does not depend on it
MOST_WAITING_ANGLES = 500  # angle samples that wait for their pressure; older ones are dropped
SECOND = 1e9  # [ns]


class PressureTrack:
    """Pressures (channels,) [Pa] at rising time stamps [ns], interpolated linearly."""

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Forget all pressures."""
        self._stamps: list[int] = []
        self._values: list[Array] = []

    @property
    def newest(self) -> int | None:
        """Stamp [ns] of the newest pressures; None without any."""
        return self._stamps[-1] if self._stamps else None

    def add(self, stamp: int, values: Array) -> None:
        """Add pressures (channels,) [Pa], whose stamp [ns] is later than all before."""
        self._stamps.append(stamp)
        self._values.append(values)
        if stamp - self._stamps[0] > 2 * PRESSURE_HISTORY:  # seldom, as it moves the whole list
            self._forget(bisect_left(self._stamps, stamp - PRESSURE_HISTORY))

    def covers(self, stamp: int) -> bool:
        """Whether a stamp [ns] lies between kept pressures that are PRESSURE_GAP apart or less: in
        a longer gap, as where messages were lost, a change may have been missed.
        """
        if not self._stamps or not self._stamps[0] <= stamp <= self._stamps[-1]:
            return False
        after = bisect_left(self._stamps, stamp)
        first = self._stamps[max(after - 1, 0)]
        return self._stamps[after] == stamp or self._stamps[after] - first <= PRESSURE_GAP

    def at(self, stamp: int) -> Array:
        """Pressures (channels,) [Pa] at a stamp [ns] for which `covers` is true.

        >>> track = PressureTrack()
        >>> track.add(0, np.array([0.0])), track.add(10, np.array([5.0]))
        (None, None)
        >>> track.at(4).tolist()
        [2.0]
        """
        after = bisect_left(self._stamps, stamp)
        if self._stamps[after] == stamp:
            return self._values[after]
        first, last = self._stamps[after - 1], self._stamps[after]
        share = (stamp - first) / (last - first)
        return (1.0 - share) * self._values[after - 1] + share * self._values[after]

    def stood(self, stamp: int, duration: int, band: float) -> Mask:
        """Whether each pressure (channels,) has stayed within a band [Pa] for a duration [ns] up to
        a stamp [ns] for which `covers` is true; False if the duration reaches back before the first
        pressures.
        """
        first = bisect_left(self._stamps, stamp - duration)
        known = self._values[first : bisect_right(self._stamps, stamp)]
        values = np.array([*known, self.at(stamp)])
        since = self._stamps[0] <= stamp - duration
        return (np.ptp(values, axis=0) <= band) & since

    def _forget(self, count: int) -> None:
        del self._stamps[:count], self._values[:count]


@dataclass(frozen=True)
class Comparison:
    """Measured and predicted tip angles (n,) [rad] of n actuators at one stamp [ns].

    settled (n,): whether the pressures of an actuator have been constant for a while, so that its
    inertia, which the model leaves out, has no influence.
    """

    stamp: int
    names: tuple[str, ...]
    measured: Array
    predicted: Array
    settled: Mask

    @property
    def residual(self) -> Array:
        """Measured less predicted angles (n,) [rad]."""
        return self.measured - self.predicted


@dataclass(frozen=True)
class Settling:
    """A sample counts as settled if the pressures of the finger have stayed within `band` [Pa] for
    `time` [s]; a time of 0 counts every sample.
    """

    time: float = 0.1
    band: float = 1000.0


class ChainPrediction:
    """Predicts the free tip angle of one chain under a model, step by step.

    Raises ValueError for a model that does not fit a chain: another base model, or several batches.
    """

    def __init__(self, description: ChainDescription, hand: HandDescription, model: Model) -> None:
        self._chain = discretise(description, CHAIN_SEGMENTS, model)
        self.channels = [hand.channel_of(actuator) for actuator in description.actuators]
        self._first = 0 if description.strut is None else 1
        self._sensor = StagedEffects(e for e in model.effects if isinstance(e, OutputEffect))

    def reset(self) -> None:
        """Forget the past: the chain is at rest at zero pressure."""
        self._chain.reset()
        self._sensor.reset()

    def tip_angle(self, dt: float, pressures: Array, temperature: float) -> float:
        """Tip angle [rad] that the sensor reads after a step of dt [s], at gauge pressures
        (channels,) [Pa] of the hand and a temperature [K].

        Raises RuntimeError if the finger has no equilibrium under the effects.
        """
        rotation = self._chain.free_rotation(dt, pressures[self.channels], temperature)
        angle = np.asarray(np.sum(rotation[self._first :, BEND_AXIS]))
        return float(self._sensor.reading("tip_angle", angle, dt))


class LivePrediction:
    """Takes pressures and angles in the order in which they come, and returns comparisons.

    An angle is compared as soon as pressures from before and after its time are there; the effect
    `clock_offset` shifts that time. A stamp before the last one of its kind means that the clock
    was set back: all samples and the memory of the effects are then forgotten.

    Args:
        hand: the hand, with its actuators and channels.
        model: the model of the actuators.
        settling: when a sample counts as settled; None: `Settling()`.
        temperature: temperature of the rubber [K].

    Raises:
        ValueError: the model cannot be used for hands.
    """

    def __init__(
        self,
        hand: HandDescription,
        model: Model,
        settling: Settling | None = None,
        temperature: float = ROOM_TEMPERATURE,
    ) -> None:
        self.hand, self.model = hand, model
        self._settling = settling or Settling()
        self._delay = _delay(model)
        self._temperature = temperature
        self._chains = [ChainPrediction(chain, hand, model) for chain in hand.chains]
        self._chain_of = {
            actuator: index
            for index, chain in enumerate(hand.chains)
            for actuator in chain.actuators
        }
        self._pressures = PressureTrack()
        self.set_back = 0  # how often the clock was
        self.reset()

    def reset(self) -> None:
        """Forget the past: all chains are at rest at zero pressure, and no samples are kept."""
        for chain in self._chains:
            chain.reset()
        self._pressures.clear()
        self._waiting: deque[tuple[int, Mapping[str, float]]] = deque(maxlen=MOST_WAITING_ANGLES)
        self._newest_angle: int | None = None
        self._last: int | None = None

    def add_pressures(self, stamp: int, pressures: Array) -> list[Comparison]:
        """Take gauge pressures (channels,) [Pa] at a stamp [ns], and return the comparisons that
        have become possible.
        """
        if self._is_new(stamp, self._pressures.newest):
            self._pressures.add(stamp, pressures)
        return self._due()

    def add_angles(self, stamp: int, angles: Mapping[str, float]) -> list[Comparison]:
        """Take tip angles [rad], by actuator, at a stamp [ns], and return the comparisons that have
        become possible.
        """
        if self._is_new(stamp, self._newest_angle):
            self._newest_angle = stamp
            self._waiting.append((stamp, angles))
        return self._due()

    def pressures_at(self, stamp: int) -> tuple[Array, bool] | None:
        """(gauge pressures (channels,) [Pa] at a stamp [ns], whether all have settled); None
        without pressures from before and after it.
        """
        if not self._pressures.covers(stamp):
            return None
        return self._pressures.at(stamp), bool(np.all(self._stood(stamp)))

    def _is_new(self, stamp: int, newest: int | None) -> bool:
        """False for a sample that is there already; forgets all when the clock was set back."""
        if newest is not None and stamp < newest:
            self.reset()
            self.set_back += 1
            return True
        return stamp != newest

    def _due(self) -> list[Comparison]:
        found = []
        newest = self._pressures.newest
        while newest is not None and self._waiting and self._waiting[0][0] - self._delay <= newest:
            stamp, angles = self._waiting.popleft()
            if self._pressures.covers(stamp - self._delay):  # else it is of before the first one
                found.append(self._compare(stamp, angles))
        return found

    def _compare(self, stamp: int, angles: Mapping[str, float]) -> Comparison:
        dt = 0.0 if self._last is None else (stamp - self._last) / SECOND
        self._last = stamp
        pressures = self._pressures.at(stamp - self._delay)
        predicted = [chain.tip_angle(dt, pressures, self._temperature) for chain in self._chains]
        stood = self._stood(stamp - self._delay)
        settled = [bool(np.all(stood[chain.channels])) for chain in self._chains]
        places = [self._chain_of[name] for name in angles]
        return Comparison(
            stamp,
            tuple(angles),
            np.array(list(angles.values())),
            np.array([predicted[place] for place in places]),
            np.array([settled[place] for place in places]),
        )

    def _stood(self, stamp: int) -> Mask:
        if self._settling.time <= 0.0:
            return np.ones(len(self.hand.channels), bool)
        duration = round(self._settling.time * SECOND)
        return self._pressures.stood(stamp, duration, self._settling.band)


def _delay(model: Model) -> int:
    """Time [ns] by which angles come later than their pressures; a stream does not tell when the
    run began, so clocks that drift apart count as they were then.

    Raises ValueError for more than the time for which pressures are kept.
    """
    staged = StagedEffects(e for e in model.effects if isinstance(e, InputEffect))
    delay = round(float(staged.delay(np.asarray(0.0))) * SECOND)
    if abs(delay) > PRESSURE_HISTORY:
        raise ValueError(
            "effects: expected a delay between pressure and angle of "
            f"{PRESSURE_HISTORY / SECOND:g} s at most, got {delay / SECOND:g} s"
        )
    return delay


def pressures_of(names: Sequence[str], effort: Sequence[float], channels: Sequence[str]) -> Array:
    """Gauge pressures (channels,) [Pa] from a state message of the driver, which may have more
    channels: its fields `name` and `effort`.

    Raises ValueError for a message that lacks a channel or has values that are not finite.

    >>> pressures_of(["a", "b"], [1.0, 2.0], ["b"]).tolist()
    [2.0]
    """
    missing = [channel for channel in channels if channel not in names]
    if missing:
        raise ValueError(f"name: expected the channels {', '.join(channels)}, got {listed(names)}")
    values = _finite("effort", names, effort)
    return np.array([values[channel] for channel in channels])


def angles_of(
    names: Sequence[str], position: Sequence[float], actuators: Sequence[str]
) -> dict[str, float]:
    """Tip angles [rad] by actuator from a message, from its fields `name` and `position`. Not every
    actuator needs a sensor.

    Raises ValueError for a name that is no actuator, and for values that are not finite.
    """
    unknown = [name for name in names if name not in actuators]
    if unknown or not names:
        raise ValueError(
            f"name: expected some of the actuators {', '.join(actuators)}, got {listed(names)}"
        )
    return _finite("position", names, position)


def _finite(field: str, names: Sequence[str], values: Sequence[float]) -> dict[str, float]:
    if len(values) != len(names):
        raise ValueError(f"{field}: expected {len(names)} values, got {len(values)}")
    bad = next((v for v in values if not math.isfinite(v)), None)
    if bad is not None:
        raise ValueError(f"{field}: expected finite numbers, got {bad}")
    return dict(zip(names, values, strict=True))
