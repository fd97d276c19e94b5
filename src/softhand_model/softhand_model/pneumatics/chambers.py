"""What the channels of the pretended bench fill: bottles, or actuators that bend and are pushed."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softhand_model.free_volumes import FreeVolumes
from softhand_model.gas import AMBIENT_PRESSURE
from softhand_model.hands import HandDescription

Floats = NDArray[np.float64]


class Chambers(Protocol):
    """Volumes on the channels, tubes included."""

    def volumes(self, pressures_abs: Floats) -> Floats:
        """Volumes (n,) [m3] in balance with absolute pressures (n,) [Pa]."""


class Bottles:
    """Rigid volumes (n,) [m3], as for calibration.

    >>> Bottles([0.5e-3]).volumes(np.array([3e5])).tolist()
    [0.0005]
    """

    def __init__(self, volumes: ArrayLike) -> None:
        self._volumes = np.array(volumes, dtype=float)

    def volumes(self, pressures_abs: Floats) -> Floats:
        """Volumes (n,) [m3], whatever the pressures."""
        return self._volumes


class FreeActuators:
    """The actuators of a hand in free posture, or bent back by a load.

    The volume follows `FreeVolumes` at the gauge pressure less that of the load. In the balance of
    a section (eq. 3.23) a moment `M` that straightens it counts like a loss of pressure of
    `2 M/(h**2 z)`; a load is given as this pressure, the same along the whole actuator. Pressure
    below the load leaves the actuators straight: the passive layer and what stands behind it do
    not give way.

    Args:
        hand: whose channels are filled.
        ambient: absolute pressure outside [Pa].

    >>> from softhand_model.hands import load_hand
    >>> finger = FreeActuators(load_hand("single_finger"))
    >>> free = finger.volumes(np.array([AMBIENT_PRESSURE + 30e3]))
    >>> finger.set_load([20e3])
    >>> pushed = finger.volumes(np.array([AMBIENT_PRESSURE + 30e3]))
    >>> round(1e6 * float(free[0]), 1), round(1e6 * float(pushed[0]), 1)
    (24.5, 20.2)
    """

    def __init__(self, hand: HandDescription, ambient: float = AMBIENT_PRESSURE) -> None:
        self._free = FreeVolumes(hand)
        self._ambient = ambient
        self._load: Floats = np.zeros(len(hand.channels))

    def set_load(self, pressures: ArrayLike) -> None:
        """Push with loads (n,) [Pa] from now on; 0 lets go.

        Raises:
            ValueError: wrong shape, or a load that is negative or not finite.
        """
        given = np.array(pressures, dtype=float)
        if given.shape != self._load.shape:
            raise ValueError(f"pressures must have shape {self._load.shape}, got {given.shape}")
        if not (np.isfinite(given) & (given >= 0)).all():
            raise ValueError(f"pressures must be finite and at least 0 Pa, got {given.tolist()}")
        self._load = given

    def volumes(self, pressures_abs: Floats) -> Floats:
        """Volumes (n,) [m3] in balance with absolute pressures (n,) [Pa] and the load."""
        return self._free.volumes(pressures_abs - self._ambient - self._load)
