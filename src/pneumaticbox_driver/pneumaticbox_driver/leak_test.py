"""Leak test: what a closed channel loses under pressure (section 4.4.4)."""

from collections.abc import Generator

import numpy as np
from numpy.typing import NDArray

from pneumaticbox_driver.channel_calibration import Leak
from pneumaticbox_driver.recording import Rest, Sample, average
from softhand_model.gas import AMBIENT_PRESSURE, ROOM_TEMPERATURE, air_mass

Floats = NDArray[np.float64]
Valves = NDArray[np.int8]
SIGNIFICANT = 3.0  # standard errors
WINDOWS = 12  # of averaged pressure, over which the slope is fitted


def measure_leaks(
    channels: int, volumes: Floats, offsets: Floats, duration: float
) -> Generator[Valves, Sample, list[Leak]]:
    """Watch the closed channels, under pressure, for a while.

    The pressure's slope gives the conductance, `k = -dp/dt V/(R_s T)/p_gauge`.

    Args:
        channels: number of channels.
        volumes: fixed volumes on the channels (n,) [m3].
        offsets: of the sensors (n,) [Pa].
        duration: how long to watch [s].

    Returns:
        The leak of each channel: 0 below three standard errors, and where there is no pressure.
    """
    rests = []
    for _ in range(WINDOWS):
        rests.append((yield from average(channels, duration / WINDOWS)))
    capacity = air_mass(1.0, volumes, ROOM_TEMPERATURE)
    return [_leak(rests, k, float(capacity[k]), float(offsets[k])) for k in range(channels)]


def _leak(rests: list[Rest], channel: int, capacity: float, offset: float) -> Leak:
    time = np.array([rest.time for rest in rests])
    pressure = np.array([rest.mean[channel] for rest in rests])
    variance = np.mean([rest.variance[channel] for rest in rests])
    gauge = pressure.mean() - offset - AMBIENT_PRESSURE
    if gauge < 1e3:
        return Leak()
    centred = time - time.mean()
    per_slope = capacity / gauge
    slope = centred @ pressure / (centred @ centred)
    error = per_slope * float(np.sqrt(variance / (centred @ centred)))
    conductance = -per_slope * float(slope)
    return Leak(conductance if conductance > SIGNIFICANT * error else 0.0, error)
