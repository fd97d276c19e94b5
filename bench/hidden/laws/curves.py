"""What `learn` has to find: laws outside the catalogue that act at a known stage against a known
axis, none in the form of the lab's curves.

Sizes are shares of the largest output, pressures and stretches shares of their ranges.
"""

from __future__ import annotations

import numpy as np

from bench.hidden.laws.registry import law
from bench.hidden.plant import Body, Plant

Array = np.ndarray
ROOM = 293.15


def _rate(time: Array, value: Array) -> Array:
    return np.gradient(value, axis=1) / np.gradient(time, axis=1)


def _since(time: Array, drive: Array) -> Array:
    """Time [s] since the drive last moved; that it is about to move, nothing knows."""
    moved = np.abs(np.diff(drive, axis=1, prepend=drive[:, :1]))
    moving = moved > 0.02 * drive.max() * np.diff(time, axis=1, prepend=time[:, :1])
    last = np.maximum.accumulate(np.where(moving, time, time[:, :1]), axis=1)
    return time - last


@law("camera_gain", ("gain", 0.003, 0.8), signed=True)
def camera_gain(plant: Plant, gain: float) -> None:
    """A camera that sees large angles too large, or too small."""
    plant.sensors.append(lambda t, y, p: y * (1 + gain * (np.abs(y) / np.abs(y).max()) ** 1.5))


@law("arctan_saturation", ("share", 0.05, 3.0))
def arctan_saturation(plant: Plant, share: float) -> None:
    """A sensor that saturates slowly; calibrated at half of its range."""

    def shown(t: Array, y: Array, p: Array) -> Array:
        full = np.abs(y).max()
        return np.arctan(share * y / full) / np.arctan(share * 0.5) * 0.5 * full

    plant.sensors.append(shown)


@law("rounded_band", ("width", 100.0, 15e3), lambda rng: {"sharp": rng.uniform(2.0, 4.0)})
def rounded_band(plant: Plant, width: float, sharp: float) -> None:
    """The first pressure hardly acts: p - width*(1 - exp(-(p/width)**sharp))**(1/sharp)."""

    def chamber(t: Array, p: Array) -> Array:
        share = -np.expm1(-((np.maximum(p, 0.0) / width) ** sharp))
        return p - width * share ** (1.0 / sharp)

    plant.chamber.append(chamber)


@law("fading_gain", ("loss", 0.005, 0.6), lambda rng: {"runs": rng.uniform(2.0, 5.0)}, True)
def fading_gain(plant: Plant, loss: float, runs: float) -> None:
    """The gain of the sensor fades from run to run, fast at first."""

    def shown(t: Array, y: Array, p: Array) -> Array:
        order = np.arange(len(y))[:, None]
        return y * (1 + loss * np.expm1(-order / runs))

    plant.sensors.append(shown)


@law("square_warmth", ("size", 0.01, 0.8), signed=True)
def square_warmth(plant: Plant, size: float) -> None:
    """A modulus that goes with the square of the distance from a temperature."""
    plant.modulus.append(lambda warm: 1 + size * ((warm - ROOM) / 20.0) ** 2)


@law("two_slopes", ("steep", 0.05, 20.0), lambda rng: {"at": rng.uniform(0.4, 0.6)})
def two_slopes(plant: Plant, steep: float, at: float) -> None:
    """From a stretch on the rubber is stiffer: another slope, with a rounded corner."""

    def factor(stretch: Array, body: Body) -> Array:
        knee, width = 1.0 + 0.6 * at, 0.02
        more = width * np.logaddexp(0.0, (stretch - knee) / width)
        return 1 + steep * more / np.maximum(stretch - stretch**-3.0, 0.05)

    plant.factors.append(factor)


@law("tethered", ("strength", 0.01, 5.0))
def tethered(plant: Plant, strength: float) -> None:
    """A moment that grows with the third power of the bending, as of a tether over the back."""

    def factor(stretch: Array, body: Body) -> Array:
        bend = np.maximum(stretch - 1.0, 0.0)
        return 1 + strength * 8.0 * bend**3 / np.maximum(stretch - stretch**-3.0, 1e-3)

    plant.factors.append(factor)


@law("throttle", ("loss", 50.0, 2e4), lambda rng: {"scale": rng.uniform(0.3, 0.6)})
def throttle(plant: Plant, loss: float, scale: float) -> None:
    """The chamber has less pressure than the gauge while it fills, more while it empties."""
    plant.moving = True

    def chamber(t: Array, p: Array) -> Array:
        part = _rate(t, p) / (scale * p.max())
        return p - loss * np.tanh(part)

    plant.chamber.append(chamber)


@law("creeping_reading", ("share", 0.005, 0.6), lambda rng: {"time": rng.uniform(0.3, 0.8)}, True)
def creeping_reading(plant: Plant, share: float, time: float) -> None:
    """The reading creeps with the logarithm of the time since the last step."""
    plant.moving = True
    plant.sensors.append(lambda t, y, p: y * (1 + share * np.log1p(_since(t, p) / time)))
