"""What no effect of the catalogue explains: instabilities, and faults of sensors and clamps.

Sizes are shares of the largest output, switching points shares of the largest drive.
"""

from __future__ import annotations

import numpy as np

from bench.hidden import sensing
from bench.hidden.laws.registry import law
from bench.hidden.plant import Plant

Array = np.ndarray


def _seed(rng: np.random.Generator) -> float:
    return float(rng.integers(2**31))


@law(
    "snap_through",
    ("jump", 0.001, 0.6),
    lambda rng: {"up": rng.uniform(0.5, 0.68), "gap": rng.uniform(0.1, 0.2)},
)
def snap_through(plant: Plant, jump: float, up: float, gap: float) -> None:
    """The output jumps at a drive and back at a lower one."""
    plant.moving = True

    def shown(t: Array, y: Array, p: Array) -> Array:
        snapped = np.zeros(len(y))
        out = y.copy()
        for k in range(y.shape[1]):
            part = p[:, k] / p.max()
            snapped = np.where(part > up, 1.0, np.where(part < up - gap, 0.0, snapped))
            out[:, k] += jump * y.max() * snapped
        return out

    plant.sensors.append(shown)


@law("hard_saturation", ("share", 0.995, 0.3))
def hard_saturation(plant: Plant, share: float) -> None:
    """The sensor ends at a share of the largest output."""
    plant.sensors.append(lambda t, y, p: np.minimum(y, share * y.max()))


@law("soft_saturation", ("share", 1.2, 0.3))
def soft_saturation(plant: Plant, share: float) -> None:
    """The sensor nears a limit within a few percent of its range."""

    def shown(t: Array, y: Array, p: Array) -> Array:
        level = share * y.max()
        width = 0.04 * level
        return level - width * np.logaddexp(0, (level - y) / width)

    plant.sensors.append(shown)


@law("clock_drift", ("drift", 3e-4, 0.3), signed=True)
def clock_drift(plant: Plant, drift: float) -> None:
    """The output's clock runs at another speed than the pressure's."""
    plant.moving = True

    def shown(t: Array, y: Array, p: Array) -> Array:
        rows = [np.interp(a * (1 + drift), a, b) for a, b in zip(t, y, strict=True)]
        return np.array(rows)

    plant.sensors.append(shown)


@law("clamp_slip", ("slip", 0.001, 1.0), lambda rng: {"seed": _seed(rng)}, signed=True)
def clamp_slip(plant: Plant, slip: float, seed: float) -> None:
    """In a quarter of the runs the zero steps at some time."""

    def shown(t: Array, y: Array, p: Array) -> Array:
        rng = np.random.default_rng(int(seed))
        some = rng.choice(len(y), max(1, len(y) // 4), replace=False)
        out = y.copy()
        for row in some:
            when = t[row, 0] + rng.uniform(0.2, 0.6) * (t[row, -1] - t[row, 0])
            out[row] += slip * y.max() * rng.uniform(0.7, 1.3) * (t[row] > when)
        return out

    plant.sensors.append(shown)


@law("gain_step", ("step", 0.002, 0.6), lambda rng: {"at": rng.uniform(0.45, 0.68)}, True)
def gain_step(plant: Plant, step: float, at: float) -> None:
    """The gain of the reading steps with the drive, as when a range is switched."""
    plant.sensors.append(lambda t, y, p: y * (1 + step * (p > at * p.max())))


@law(
    "two_leaks",
    ("share", 0.005, 0.6),
    lambda rng: {"fast": rng.uniform(0.7, 1.5), "slow": rng.uniform(6.0, 14.0)},
)
def two_leaks(plant: Plant, share: float, fast: float, slow: float) -> None:
    """The chamber loses part of the gauge's pressure, quickly and slowly."""
    plant.moving = True

    def chamber(t: Array, p: Array) -> Array:
        lost = sensing.first_order(t, p, fast) + sensing.first_order(t, p, slow)
        return p - share / 2 * lost

    plant.chamber.append(chamber)


@law("session_drift", ("size", 0.001, 0.8), lambda rng: {"seed": _seed(rng)})
def session_drift(plant: Plant, size: float, seed: float) -> None:
    """The zero wanders on, run after run: a random walk of unit variance over the session."""

    def shown(t: Array, y: Array, p: Array) -> Array:
        rng = np.random.default_rng(int(seed))
        knots = np.concatenate([[0.0], np.cumsum(rng.standard_normal(40))])
        knots /= np.abs(knots).max()
        spent = np.concatenate([[0.0], np.cumsum(t[:, -1] - t[:, 0])])
        session = (spent[:-1, None] + t - t[:, :1]) / spent[-1]
        return y + size * y.max() * np.interp(session, np.linspace(0, 1, len(knots)), knots)

    plant.sensors.append(shown)


@law("warming_sensor", ("size", 0.001, 0.8), lambda rng: {"time": rng.uniform(6.0, 15.0)}, True)
def warming_sensor(plant: Plant, size: float, time: float) -> None:
    """The zero creeps from the start of every run, whatever the load."""
    plant.sensors.append(lambda t, y, p: y - size * y.max() * np.expm1(-(t - t[:, :1]) / time))


@law("interference", ("size", 0.001, 0.8), lambda rng: {"frequency": rng.uniform(0.5, 1.4)})
def interference(plant: Plant, size: float, frequency: float) -> None:
    """A periodic disturbance that starts with every run."""
    plant.sensors.append(
        lambda t, y, p: y + size * y.max() * np.sin(2 * np.pi * frequency * (t - t[:, :1]))
    )


@law("crosstalk", ("share", 0.005, 0.8), signed=True)
def crosstalk(plant: Plant, share: float) -> None:
    """A torque sensor whose axes answer to one another."""
    plant.mixing.append(np.eye(3) + share * np.array([[0, 1, 0], [0, 0, -1], [1, 0, 0]]))
