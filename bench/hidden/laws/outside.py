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


@law("dropped_frames", ("share", 0.01, 0.9), lambda rng: {"seed": _seed(rng)})
def dropped_frames(plant: Plant, share: float, seed: float) -> None:
    """A camera that stands still now and then, for up to this share of a run's tenth."""

    def shown(t: Array, y: Array, p: Array) -> Array:
        rng, out = np.random.default_rng(int(seed)), y.copy()
        tenth = y.shape[1] // 10
        for row in out:
            for start in range(0, y.shape[1] - tenth, tenth):
                ends = start + int(share * tenth * rng.uniform(0.3, 1.0))
                row[start:ends] = row[start]
        return out

    plant.sensors.append(shown)


@law("stuck_encoder", ("width", 0.005, 0.5), lambda rng: {"at": rng.uniform(0.25, 0.45)})
def stuck_encoder(plant: Plant, width: float, at: float) -> None:
    """A reading that stays where it is while the value crosses a gap."""
    plant.sensors.append(lambda t, y, p: sensing.stuck(y, at * y.max(), (at + width) * y.max()))


@law(
    "ringing",
    ("share", 0.01, 1.0),
    lambda rng: {"frequency": rng.uniform(0.5, 0.9), "damping": rng.uniform(0.05, 0.15)},
)
def ringing(plant: Plant, share: float, frequency: float, damping: float) -> None:
    """Part of the finger swings like a mass on a spring."""
    plant.moving = True

    def shown(t: Array, y: Array, p: Array) -> Array:
        swung = sensing.second_order(t, y, damping / (np.pi * frequency), damping)
        return y + share * (swung - y)

    plant.sensors.append(shown)
