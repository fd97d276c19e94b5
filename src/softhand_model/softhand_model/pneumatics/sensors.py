"""Pressure sensors with class error, low-pass, noise and a 12-bit converter (Table 4.1)."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from softhand_common.numerics.arrays import Array
from softhand_common.numerics.compiled import compiled
from softhand_model.pneumatics.parameters import Sensor

OFFSET_SHARE = (
    0.7  # of the accuracy class; the rest is the gain error, so that the sum is within the class
)


@dataclass
class PressureSensors:
    """One sensor per channel and one of the supply, last. Arrays have shape (channels + 1,).

    `gain` [-] and `offset` [Pa] are the errors of this box, `noise` [Pa] is a standard deviation,
    `resolution` [Pa] the converter's step and `full_scale` [Pa] its gauge range.
    """

    ambient: float
    gain: Array
    offset: Array
    noise: Array
    resolution: Array
    full_scale: Array
    time_constant: Array

    def __post_init__(self) -> None:
        self.reset()
        self.follow(0.0, self.filtered.copy())  # compile or load the kernels before the first step
        readings = np.zeros_like(self.filtered)
        convert(self.filtered, self.ambient, self._errors, self._converter, readings)

    def reset(self) -> None:
        """Let the low-pass settle at ambient pressure."""
        self.filtered: Array = np.full(len(self.gain), self.ambient)
        self._errors = self.gain, self.offset, self.noise
        self._converter = self.resolution, self.full_scale

    def follow(self, dt: float, pressures_abs: Array) -> None:
        """Let the low-pass follow true absolute pressures [Pa] for `dt` [s]."""
        follow_low_pass(dt, self.time_constant, pressures_abs, self.filtered)

    def read(self, noise: np.random.Generator) -> Array:
        """Return converted absolute pressures [Pa], ambient taken as exactly known."""
        readings = noise.standard_normal(len(self.filtered))
        convert(self.filtered, self.ambient, self._errors, self._converter, readings)
        return readings


@compiled
def follow_low_pass(dt: float, time_constant: Array, pressures_abs: Array, filtered: Array) -> None:
    """Let the filtered absolute pressures (m,) [Pa] follow the true ones (m,) [Pa] for `dt` [s],
    with time constants (m,) [s], in place.
    """
    for i in range(len(filtered)):
        share = dt / (dt + time_constant[i])
        filtered[i] += share * (pressures_abs[i] - filtered[i])


@compiled
def convert(filtered: Array, ambient: float, errors: Any, converter: Any, readings: Array) -> None:
    """Write the readings (m,) [Pa] of filtered absolute pressures (m,) [Pa] into `readings`, which
    holds standard normal numbers for the noise before. errors: gain, offset and noise. converter:
    resolution and full scale.
    """
    gain, offset, noise = errors
    resolution, full_scale = converter
    for i in range(len(filtered)):
        analog = gain[i] * (filtered[i] - ambient) + offset[i] + noise[i] * readings[i]
        in_range = min(max(analog, -0.02 * full_scale[i]), full_scale[i])
        readings[i] = np.rint(in_range / resolution[i]) * resolution[i] + ambient


def build_sensors(
    channel: Sensor,
    supply: Sensor,
    ambient: float,
    tolerances: np.random.Generator,
    channels: int,
    slots: int,
) -> PressureSensors:
    """Draw the errors of the sensors of one box with `slots` channels, `channels` in use.

    Args:
        channel: data of a channel's sensor.
        supply: data of the supply's sensor.
        ambient: absolute ambient pressure [Pa].
        tolerances: generator of the box.
        channels: number of channels in use.
        slots: number of channels that the box has.

    Returns:
        Sensors of the channels, then the supply.
    """
    kinds = [channel] * channels + [supply]
    used = [*range(channels), slots]
    drawn = tolerances.uniform(-1, 1, (2, slots + 1))[:, used]
    accuracy = np.array([kind.accuracy for kind in kinds])
    full_scale = np.array([kind.range for kind in kinds])
    return PressureSensors(
        ambient=ambient,
        gain=1 + (1 - OFFSET_SHARE) * accuracy * drawn[0],
        offset=OFFSET_SHARE * accuracy * full_scale * drawn[1],
        noise=np.array([kind.noise for kind in kinds]),
        resolution=full_scale / np.array([2**kind.bits for kind in kinds]),
        full_scale=full_scale,
        time_constant=np.array([kind.time_constant for kind in kinds]),
    )
