"""A hand in free air from open to closed: its joints at growing pressures."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pneuflex_sim.simulation import Simulation, SimulationConfig
from softhand_model.free_volumes import FreeVolumes
from softhand_model.gas import AMBIENT_PRESSURE, air_mass
from softhand_model.hands import HandDescription

Array = NDArray[np.float64]

STEP = 0.002  # [s]
RAMP, REST = 0.4, 0.8  # [s] between two frames


def air_masses_at(hand: HandDescription, gauge: Array) -> Array:
    """Air (channels,) [kg above rest] in a free hand at gauge pressures (channels,) [Pa]."""
    free = FreeVolumes(hand)
    return np.asarray(
        air_mass(gauge + AMBIENT_PRESSURE, free.volumes(gauge))
        - air_mass(AMBIENT_PRESSURE, free.rest)
    )


def closing_hand(
    hand: HandDescription, gauge: Array, frames: int, segments: int
) -> Iterator[Array]:
    """Joint orientations (n, 4) of a weightless hand at rest, at `frames` pressures in even steps
    up to `gauge` (channels,) [Pa]; the first one without pressure.

    Raises ValueError for fewer than two frames.
    """
    if frames < 2:
        raise ValueError(f"frames: expected 2 or more, got {frames}")
    shares = np.linspace(0.0, 1.0, frames)
    yield from settled_hand(hand, np.outer(shares, gauge), segments)


def settled_hand(hand: HandDescription, gauges: Array, segments: int) -> Iterator[Array]:
    """Joint orientations (n, 4) of a weightless hand at rest, at gauge pressures (k, channels) [Pa]
    that it takes one after the other, from none on.
    """
    simulation = Simulation(
        SimulationConfig(hand=hand, scene="stand", model="base", step=STEP, segments=segments)
    )
    try:
        before = np.zeros(len(hand.channels))
        for gauge in gauges:
            after = air_masses_at(hand, gauge) if gauge.any() else np.zeros_like(before)
            if np.any(after != before):
                _fill(simulation, before, after)
            before = after
            yield simulation.bodies.q.copy()
    finally:
        simulation.close()


def _fill(simulation: Simulation, before: Array, after: Array) -> None:
    """Go from air masses (channels,) [kg] to others, and let the hand come to rest."""
    for k in range(round((RAMP + REST) / STEP)):
        way = min(1.0, (k + 1) * STEP / RAMP)
        simulation.set_air_masses(before + way * (after - before))
        simulation.step()
