"""Volumes of the channels as functions of the pressures, for a hand without contact."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from pneumaticbox_driver.arrays import Floats
from softhand_model.chain.volumes import FreeVolumes
from softhand_model.hand.hand import load_hand

VOLUME_NEWTON_STEPS = 4  # the volume of a free actuator is nearly linear in its pressure
LEAST_SLOPE = 1e-13  # below it a volume is fixed [m3/Pa]


class VolumeModel(Protocol):
    """Volumes (n,) [m3] and their derivatives (n,) [m3/Pa] at gauge pressures (n,) [Pa]."""

    def volumes(self, pressures: Floats) -> Floats:
        """Volumes in free posture, tubes included (n,) [m3]."""
        ...

    def slopes(self, pressures: Floats) -> Floats:
        """Derivatives by the gauge pressure [Pa] in the same channel (n,) [m3/Pa]."""
        ...


class FixedVolumes:
    """Bottles: constant volumes (n,) [m3]."""

    def __init__(self, volumes: Sequence[float]) -> None:
        self._volumes: Floats = np.array(volumes, dtype=float)

    def volumes(self, pressures: Floats) -> Floats:
        """Volumes (n,) [m3], independent of the pressures [Pa]."""
        return self._volumes

    def slopes(self, pressures: Floats) -> Floats:
        """Zeros (n,) [m3/Pa], independent of the pressures [Pa]."""
        return np.zeros_like(self._volumes)


class HandVolumes:
    """The channels of a hand in free posture; rest volumes may include longer tubes.

    Args:
        hand: name or file of the hand.
        rest_volumes: volumes of the channels at rest, with their tubes (n,) [m3].

    Raises:
        ValueError: no such hand, or another number of channels.
    """

    def __init__(self, hand: str, rest_volumes: Sequence[float]) -> None:
        self._free = FreeVolumes(load_hand(hand))
        n = len(self._free.rest)
        if n != len(rest_volumes):
            raise ValueError(
                f"volume_model: expected a hand of {len(rest_volumes)} channels, "
                f"got {hand}, which has {n}"
            )
        self._more: Floats = np.array(rest_volumes) - self._free.rest

    def volumes(self, pressures: Floats) -> Floats:
        """Volumes in free posture (n,) [m3] at gauge pressures (n,) [Pa]."""
        return self._more + self._free.volumes(pressures)

    def slopes(self, pressures: Floats) -> Floats:
        """Derivatives by the gauge pressure [Pa] in the same channel (n,) [m3/Pa]."""
        return self._free.slopes(pressures)


def make_volume_model(kind: str, hand: str, rest_volumes: Sequence[float]) -> VolumeModel:
    """Make a volume model of kind "hand" or "fixed"; raises ValueError as `HandVolumes` does."""
    return HandVolumes(hand, rest_volumes) if kind == "hand" else FixedVolumes(rest_volumes)


def pressure_after(model: VolumeModel, pressures: Floats, growth: Floats) -> Floats:
    """Find the gauge pressures (n,) [Pa] at which the model's volumes have grown by `growth`.

    The pressure of a constant volume is unchanged; negative pressures are replaced by 0.

    Args:
        model: model of the volumes.
        pressures: gauge pressures to start from (n,) [Pa].
        growth: growth of the volumes (n,) [m3].

    >>> class Linear(FixedVolumes):
    ...     def volumes(self, pressures): return 1e-5 + 1e-10 * pressures
    ...     def slopes(self, pressures): return np.full_like(pressures, 1e-10)
    >>> pressure_after(Linear([1e-5]), np.array([1e4]), np.array([1e-6])).round(6).tolist()
    [20000.0]
    """
    target = model.volumes(pressures) + growth
    found = pressures
    for _ in range(VOLUME_NEWTON_STEPS):
        slopes = model.slopes(found)
        step = (target - model.volumes(found)) / np.maximum(slopes, LEAST_SLOPE)
        found = np.maximum(found + np.where(slopes > LEAST_SLOPE, step, 0.0), 0.0)
    return np.asarray(found)
