"""The chain that the simulator runs: spring joints whose rest orientation follows the pressure (section 5.1.3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from softhand_model.hands import ChainDescription
from softhand_model.model_file import Model
from softhand_model.response import SegmentResponse, bends
from softhand_model.rest_table import RestTable
from softhand_model.segments import SegmentChain, cut_chain
from softhand_model.spread import spread_angles, volume_gains

__all__ = ["ChainModel", "SegmentChain", "discretise"]

Array = NDArray[np.float64]

ROOM_TEMPERATURE = 293.15  # [K]
BEND = 1  # index of the bending axis (y)


def discretise(description: ChainDescription, segments: int, model: Model) -> ChainModel:
    """Cut a chain into `segments` segments an actuator, under a model.

    Raises ValueError for fewer than one segment or a base other than `pneuflex`.

    >>> from softhand_model.hands import load_hand
    >>> finger = discretise(load_hand("single_finger").chain("finger"), 5, Model())
    >>> finger.rest_rotation([31e3]).sum(axis=0).round(2).tolist()
    [0.0, 2.5, 0.0]
    """
    if segments < 1:
        raise ValueError(f"segments: expected at least 1, got {segments}")
    if model.base != "pneuflex":
        raise ValueError(f"model base: expected pneuflex for a simulated chain, got {model.base}")
    return ChainModel(description, segments, model)


class ChainModel:
    """A discretised chain under a model; pressures are gauge, one for each actuator of the chain in its order.

    segments: the rigid links and joint springs.
    volume_gain (actuators, n) [m3/rad]: change of each chamber's volume with a joint's rotation about y; constant,
        because the volume is linear in the curvature (eq. 3.17).
    """

    def __init__(self, description: ChainDescription, segments: int, model: Model) -> None:
        scale = model.modulus_scale()
        parts = {
            name: actuator.with_modulus(scale) for name, actuator in description.actuators.items()
        }
        self.description, self.model = replace(description, actuators=parts), model
        self.segments = cut_chain(self.description, segments)
        self._shape = self.segments.offset.shape
        self._spread = spread_angles(self.description, self.segments, segments)
        self._tables = [
            RestTable(part, segments, spread)
            for part, spread in zip(parts.values(), self._spread, strict=True)
        ]
        self._responses = (
            [SegmentResponse(part, segments, model) for part in parts.values()]
            if bends(model)
            else []
        )
        self._rest_volume = np.array(
            [part.chamber_volume() + part.supply_volume for part in parts.values()]
        )
        self.volume_gain = volume_gains(self.description, self.segments, segments)

    def rest_rotation(self, pressures: Sequence[float] | Array) -> Array:
        """Rotation vector (n, 3) [rad] in each link's frame that the pressures (actuators,) [Pa] add to its rest.

        The rest orientation of a joint under pressure is `segments.rest` followed by this rotation. No memory, no
        effects: the base model.
        """
        rotation = self._tables[0].value(pressures[0])
        for table, pressure in zip(self._tables[1:], pressures[1:], strict=True):
            rotation = rotation + table.value(pressure)
        return rotation.reshape(self._shape)

    def rest_gain(self, pressures: Sequence[float] | Array) -> Array:
        """Derivative (actuators, n) [rad/Pa] of the rest rotation about y by each pressure [Pa] (base model)."""
        return np.array(
            [
                table.slope(pressure)[BEND::3]
                for table, pressure in zip(self._tables, pressures, strict=True)
            ]
        )

    def volume(self, bend: Array) -> Array:
        """Air volume (actuators,) [m3] of chamber and supply tube at joint rotations about y (n,) [rad] from rest.

        Two parallel arcs are taken to bend alike: what a twist moves between them is left out.
        """
        return self._rest_volume + self.volume_gain @ bend

    def step(
        self,
        dt: float,
        pressures: Sequence[float] | Array,
        bend: Array,
        temperature: float = ROOM_TEMPERATURE,
    ) -> Array:
        """Advance the effects' memory by dt [s] and give the rest rotation (n, 3) [rad] that the springs pull to.

        bend (n,) [rad] is the actual rotation of the joints about y, temperature in [K]. Where an effect scales the
        stiffness by f the returned rest is moved so that the unscaled spring pulls as the scaled one would.
        """
        if not self._responses:
            return self.rest_rotation(pressures)
        angles = [
            response.angles(dt, float(pressure), temperature)
            for response, pressure in zip(self._responses, pressures, strict=True)
        ]
        rotation = sum(
            spread @ angle for spread, angle in zip(self._spread, angles, strict=True)
        ).reshape(self._shape)
        factor = np.mean(
            [
                response.stiffness_factor(bend, rotation[:, BEND], temperature)
                for response in self._responses
            ],
            axis=0,
        )
        rotation[:, BEND] = bend + factor * (rotation[:, BEND] - bend)
        return rotation

    def reset(self) -> None:
        """Forget the effects' memory: at rest at zero pressure."""
        for response in self._responses:
            response.reset()
