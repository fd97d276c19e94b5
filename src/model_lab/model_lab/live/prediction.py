"""Live prediction of a hand's free tip angles from its pressures, sample by sample.

The kernel is that of simulator and lab: the chains' free rotation under the model's effects, whose
memory is stepped from one angle sample to the next, with the pressure of its stamp.
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
CHAIN_SEGMENTS = 5  # of an actuator; the free tip angle of a straight one does not depend on it
MOST_WAITING_ANGLES = 500  # angle samples that wait for their pressure; older ones are dropped
SECOND = 1e9  # [ns]


class PressureTrack:
    """Pressures (channels,) [Pa] by rising stamps [ns], straight lines between."""

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Forget all."""
        self._stamps: list[int] = []
        self._values: list[Array] = []

    @property
    def newest(self) -> int | None:
        """Stamp [ns] of the newest pressures."""
        return self._stamps[-1] if self._stamps else None

    def add(self, stamp: int, values: Array) -> None:
        """Take pressures that are newer than all before."""
        self._stamps.append(stamp)
        self._values.append(values)
        if stamp - self._stamps[0] > 2 * PRESSURE_HISTORY:  # seldom, as it moves the whole list
            self._forget(bisect_left(self._stamps, stamp - PRESSURE_HISTORY))

    def covers(self, stamp: int) -> bool:
        """Whether the stamp [ns] lies between pressures that are kept."""
        return bool(self._stamps) and self._stamps[0] <= stamp <= self._stamps[-1]

    def at(self, stamp: int) -> Array:
        """Pressures (channels,) [Pa] at a stamp [ns] that is covered.

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
        """Whether each pressure has kept within a band [Pa] for a duration [ns] up to a stamp that
        is covered; False where that reaches back before the first.
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
    """Measured and predicted tip angles (n,) [rad] of some actuators at one stamp [ns].

    settled (n,): whether the pressures of an actuator have stood still for a while, so that its
    inertia, which the model leaves out, plays no part.
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
    """A finger counts as settled when its pressure has kept within a band [Pa] for a time [s]; a
    time of 0 counts every sample.
    """

    time: float = 0.1
    band: float = 1000.0


class ChainPrediction:
    """The free tip angle of one chain under a model, with its memory.

    Raises ValueError for a model that has no chains: another base, or several batches.
    """

    def __init__(self, description: ChainDescription, hand: HandDescription, model: Model) -> None:
        self._chain = discretise(description, CHAIN_SEGMENTS, model)
        self.channels = [hand.channel_of(actuator) for actuator in description.actuators]
        self._first = 0 if description.strut is None else 1
        self._sensor = StagedEffects(e for e in model.effects if isinstance(e, OutputEffect))

    def reset(self) -> None:
        """Forget everything: at rest at zero pressure."""
        self._chain.reset()
        self._sensor.reset()

    def tip_angle(self, dt: float, pressures: Array, temperature: float) -> float:
        """Reading [rad] of the tip angle after a step of dt [s] at the channels' gauge pressures
        (channels,) [Pa] and a temperature [K].

        Raises RuntimeError where the effects leave no equilibrium.
        """
        rotation = self._chain.free_rotation(dt, pressures[self.channels], temperature)
        angle = np.asarray(np.sum(rotation[self._first :, BEND_AXIS]))
        return float(self._sensor.reading("tip_angle", angle, dt))


class LivePrediction:
    """Pressures and angles in, in the order in which they come; comparisons out.

    An angle is compared as soon as pressures from before and after it are there; under
    `clock_offset` these are the pressures of that time ago. A stamp that lies
    before the last one of its kind means that the clock was set back: all is forgotten, the memory
    of the effects too.

    Args:
        hand: which actuators, on which channels.
        model: of the actuators.
        settling: when a sample counts as settled.
        temperature: of the rubber [K].

    Raises:
        ValueError: a model that cannot be used for hands.
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
        """Forget everything: at rest at zero pressure, no samples."""
        for chain in self._chains:
            chain.reset()
        self._pressures.clear()
        self._waiting: deque[tuple[int, Mapping[str, float]]] = deque(maxlen=MOST_WAITING_ANGLES)
        self._newest_angle: int | None = None
        self._last: int | None = None

    def add_pressures(self, stamp: int, pressures: Array) -> list[Comparison]:
        """Take gauge pressures (channels,) [Pa] at a stamp [ns]; what can be compared now."""
        if self._is_new(stamp, self._pressures.newest):
            self._pressures.add(stamp, pressures)
        return self._due()

    def add_angles(self, stamp: int, angles: Mapping[str, float]) -> list[Comparison]:
        """Take tip angles [rad] by actuator at a stamp [ns]; what can be compared now."""
        if self._is_new(stamp, self._newest_angle):
            self._newest_angle = stamp
            self._waiting.append((stamp, angles))
        return self._due()

    def pressures_at(self, stamp: int) -> tuple[Array, bool] | None:
        """Gauge pressures (channels,) [Pa] at a stamp [ns], and whether all have stood; None where
        none are kept from before and after it.
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
    """Gauge pressures (channels,) [Pa] out of a state of the driver, which may have more channels.

    Raises ValueError naming the field, expected and got.

    >>> pressures_of(["a", "b"], [1.0, 2.0], ["b"]).tolist()
    [2.0]
    """
    missing = [channel for channel in channels if channel not in names]
    if missing:
        raise ValueError(f"name: expected {', '.join(channels)}, got {listed(names)}")
    values = _finite("effort", names, effort)
    return np.array([values[channel] for channel in channels])


def angles_of(
    names: Sequence[str], position: Sequence[float], actuators: Sequence[str]
) -> dict[str, float]:
    """Tip angles [rad] by actuator out of a message; not every actuator needs to have a sensor.

    Raises ValueError naming the field, expected and got.
    """
    unknown = [name for name in names if name not in actuators]
    if unknown or not names:
        raise ValueError(f"name: expected some of {', '.join(actuators)}, got {listed(names)}")
    return _finite("position", names, position)


def _finite(field: str, names: Sequence[str], values: Sequence[float]) -> dict[str, float]:
    if len(values) != len(names):
        raise ValueError(f"{field}: expected {len(names)} values, got {len(values)}")
    bad = next((v for v in values if not math.isfinite(v)), None)
    if bad is not None:
        raise ValueError(f"{field}: expected finite numbers, got {bad}")
    return dict(zip(names, values, strict=True))
