"""Volumes of a hand's channels: of a free hand over the pressure, and of what the simulated box
fills: bottles, or actuators that bend and are loaded.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from softhand_common.numerics.arrays import Array
from softhand_model.chain.chain import ChainModel, discretise
from softhand_model.chain.free_response import HIGHEST_OVER_LIMIT, hermite
from softhand_model.chain.segments import BEND_AXIS
from softhand_model.gas import AMBIENT_PRESSURE, air_mass
from softhand_model.hand.hand import HandDescription
from softhand_model.model_file import Model

VOLUME_SEGMENTS = 5  # per actuator, the simulator's default
VOLUME_INTERVALS = 128


class FreeVolumes:
    """Air volumes of a hand without contact and weight, tabulated over the pressures.

    Each chamber follows the free curvature of its sections (eq. 3.33) by `dV/dkappa = z h**2/2`
    (eq. 3.17), less the rubber of the side walls, plus the tubes. Two parallel arcs bend as one:
    where two channels feed them, each changes the volume of the other. Arrays (n,) have the
    channels in the order of the hand. Suction counts as zero pressure; beyond the table, which ends
    at three times the pressure limit, volumes go on in a straight line. The relative error of five
    segments an actuator, against many, is 2e-4 for a finger and 0.01 for two parallel arcs at very
    different pressures.

    Args:
        hand: the hand with these channels.
    """

    def __init__(self, hand: HandDescription) -> None:
        n = len(hand.channels)
        self.rest: Array = np.asarray(hand.rest_volumes())
        self._step: Array = HIGHEST_OVER_LIMIT * hand.max_pressures() / VOLUME_INTERVALS
        pressures = np.arange(VOLUME_INTERVALS + 1)[:, None] * self._step
        value, slope = np.zeros((2, VOLUME_INTERVALS + 1, n, n))  # pressure, source, volume of
        for chain in hand.chains:
            _add_chain(hand, discretise(chain, VOLUME_SEGMENTS, Model()), pressures, value, slope)
        self._cubic = hermite(value, slope * self._step[:, None])
        self._source = np.arange(n)

    def volumes(self, gauge: ArrayLike) -> Array:
        """Volumes (n,) [m3] of the channels, tubes included, at gauge pressures (n,) [Pa].

        >>> from softhand_model.hand.hand import load_hand
        >>> finger = FreeVolumes(load_hand("single_finger"))
        >>> [round(1e6 * float(finger.volumes([p])[0]), 1) for p in (0.0, 30e3)]
        [18.8, 24.5]
        """
        c, t = self._place(np.asarray(gauge, float))
        parts = c[:, 0] + t * (c[:, 1] + t * (c[:, 2] + t * c[:, 3]))
        return np.asarray(self.rest + parts.sum(axis=0))

    def air_masses(self, gauge: ArrayLike) -> Array:
        """Air masses (n,) [kg] beyond those at rest at ambient pressure, at gauge pressures (n,)
        [Pa].

        >>> from softhand_model.hand.hand import load_hand
        >>> finger = FreeVolumes(load_hand("single_finger"))
        >>> [round(1e6 * float(finger.air_masses([p])[0]), 1) for p in (0.0, 30e3)]
        [0.0, 15.6]
        """
        pressures = np.asarray(gauge, float)
        filled = air_mass(pressures + AMBIENT_PRESSURE, self.volumes(pressures))
        return np.asarray(filled - air_mass(AMBIENT_PRESSURE, self.rest))

    def slopes(self, gauge: ArrayLike) -> Array:
        """Derivatives (n,) [m3/Pa] of the volumes by the pressure in the same channel.

        Args:
            gauge: pressures (n,) [Pa]; the slope under suction is that at zero.
        """
        c, t = self._place(np.asarray(gauge, float))
        parts = (c[:, 1] + t * (2.0 * c[:, 2] + t * 3.0 * c[:, 3])) / self._step[:, None]
        return np.asarray(parts.diagonal())

    def _place(self, gauge: Array) -> tuple[Array, Array]:
        """Cubics (source, 4, volume of) and positions (source, 1) in their intervals."""
        relative = np.maximum(gauge, 0.0) / self._step
        index = np.minimum(relative.astype(np.intp), VOLUME_INTERVALS)
        return self._cubic[index, self._source], (relative - index)[:, None]


def _add_chain(
    hand: HandDescription, chain: ChainModel, pressures: Array, value: Array, slope: Array
) -> None:
    """Add changes of volumes (k, n, n) by the pressures (k, n) [Pa] in a chain's chambers."""
    channels = [hand.channel_of(name) for name in chain.description.actuators]
    for actuator, source in enumerate(channels):
        bend, bend_slope = _bends(chain, actuator, pressures[:, source])
        for gain, channel in zip(chain.volume_gain, channels, strict=True):
            value[:, source, channel] += bend @ gain
            slope[:, source, channel] += bend_slope @ gain


def _bends(chain: ChainModel, actuator: int, pressures: Array) -> tuple[Array, Array]:
    """Rotations (k, joints) [rad] by one chamber's pressures (k,) [Pa], and derivatives."""
    table = chain.rest_tables[actuator]
    value = [table.value(pressure)[BEND_AXIS::3] for pressure in pressures]
    slope = [table.slope(pressure)[BEND_AXIS::3] for pressure in pressures]
    return np.array(value), np.array(slope)


class Chambers(Protocol):
    """The volumes that the channels of the box fill, tubes included."""

    def volumes(self, pressures_abs: Array) -> Array:
        """Volumes (n,) [m3] in equilibrium with absolute pressures (n,) [Pa]."""


class Bottles:
    """Rigid bottles with volumes (n,) [m3], as used for calibration.

    >>> Bottles([0.5e-3]).volumes(np.array([3e5])).tolist()
    [0.0005]
    """

    def __init__(self, volumes: ArrayLike) -> None:
        self._volumes = np.array(volumes, dtype=float)

    def volumes(self, pressures_abs: Array) -> Array:
        """Volumes (n,) [m3], independent of the absolute pressures (n,) [Pa]."""
        return self._volumes


class FreeActuators:
    """The actuators of a hand without contact, or bent back by a load.

    The volume follows `FreeVolumes` at the gauge pressure less that of the load. In the balance of
    a section (eq. 3.23) a moment `M` that straightens it counts like a loss of pressure of `2
    M/(h**2 z)`; a load is stated as this pressure, equal along the whole actuator. With a pressure
    below the load the actuators stay straight, as passive layer and support do not yield.

    Args:
        hand: the hand whose channels are filled, in surroundings at AMBIENT_PRESSURE.

    >>> from softhand_model.hand.hand import load_hand
    >>> finger = FreeActuators(load_hand("single_finger"))
    >>> free = finger.volumes(np.array([AMBIENT_PRESSURE + 30e3]))
    >>> finger.set_load([20e3])
    >>> pushed = finger.volumes(np.array([AMBIENT_PRESSURE + 30e3]))
    >>> round(1e6 * float(free[0]), 1), round(1e6 * float(pushed[0]), 1)
    (24.5, 20.2)
    """

    def __init__(self, hand: HandDescription) -> None:
        self._free = FreeVolumes(hand)
        self._load: Array = np.zeros(len(hand.channels))

    def set_load(self, pressures: ArrayLike) -> None:
        """Set external loads (n,) [Pa]; 0 for none.

        Raises:
            ValueError: wrong shape, or a load that is negative or not finite.
        """
        given = np.array(pressures, dtype=float)
        if given.shape != self._load.shape:
            raise ValueError(f"pressures must have shape {self._load.shape}, got {given.shape}")
        if not (np.isfinite(given) & (given >= 0)).all():
            raise ValueError(f"pressures must be finite and at least 0 Pa, got {given.tolist()}")
        self._load = given

    def volumes(self, pressures_abs: Array) -> Array:
        """Volumes (n,) [m3] in equilibrium with absolute pressures (n,) [Pa] and the load."""
        return self._free.volumes(pressures_abs - AMBIENT_PRESSURE - self._load)
