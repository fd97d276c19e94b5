"""Pressure (or stretch) over time: six protocols, each a function of time with seeded details.

A protocol maps t [s] to a drive between 0 and 1, starts at rest at zero, and has its own duration.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

Array = np.ndarray
EDGE = 0.6  # [s] that a regulator takes for a step, without corners


@dataclass(frozen=True)
class Protocol:
    """A drive over time: name, duration [s], peak (share of the set's peak)."""

    name: str
    duration: float
    drive: Callable[[Array], Array]
    peak: float = 1.0

    def __call__(self, time: Array) -> Array:
        """Share (n,) of the set's peak at times (n,) [s]."""
        return self.peak * self.drive(np.asarray(time, float))


def through(times: list[float], values: list[float]) -> Callable[[Array], Array]:
    """Straight lines through points."""
    return lambda time: np.interp(time, times, values)


def ramp(rise: float, hold: float, rest: float = 1.0) -> tuple[float, Callable[[Array], Array]]:
    """Up in `rise`, hold, down as fast, rest."""
    times = [0.0, rise, rise + hold, 2 * rise + hold, 2 * rise + hold + rest]
    return times[-1], through(times, [0, 1, 1, 0, 0])


def steps(levels: list[float], hold: list[float]) -> tuple[float, Callable[[Array], Array]]:
    """Levels, each reached within EDGE and held."""
    starts = np.concatenate([[0.0], np.cumsum(np.asarray(hold) + EDGE)])
    changes = np.diff(levels, prepend=0.0)

    def drive(time: Array) -> Array:
        done = np.clip((time[..., None] - starts[:-1]) / EDGE, 0.0, 1.0)
        return (changes * (0.5 - 0.5 * np.cos(np.pi * done))).sum(axis=-1)

    return float(starts[-1]), drive


def triangles(peaks: list[float], rate: float) -> tuple[float, Callable[[Array], Array]]:
    """Up to each peak and back to zero at one rate [1/s]."""
    times, values = [0.0], [0.0]
    for peak in peaks:
        times += [times[-1] + peak / rate, times[-1] + 2 * peak / rate]
        values += [peak, 0.0]
    return times[-1], through(times, values)


def sines(slow: float, fast: float) -> tuple[float, Callable[[Array], Array]]:
    """Two periods of the slow and then four of the fast sine, frequencies [Hz]."""
    change = 2.0 / slow

    def drive(time: Array) -> Array:
        phase = np.where(time < change, slow * time, 2.0 + fast * (time - change))
        return 0.5 - 0.5 * np.cos(2 * np.pi * phase)

    return change + 4.0 / fast, drive


def standard(rng: np.random.Generator) -> list[Protocol]:
    """The six protocols of the default design, with peaks between 0.85 and 1."""

    def peak() -> float:
        return float(rng.uniform(0.85, 1.0))

    up = [0.2, 0.4, 0.6, 0.8, 1.0]
    levels = list(rng.uniform(0.1, 1.0, 9)) + [0.0]
    holds = list(rng.uniform(1.2, 3.5, 10))
    shapes = {
        "slow_ramp": ramp(float(rng.uniform(14, 18)), 3.0),
        "fast_ramp": ramp(float(rng.uniform(1.8, 2.6)), 4.0, 3.0),
        "staircase": steps([*up, *up[-2::-1], 0.0], [2.5] * 10),
        "growing_triangles": triangles([0.3, 0.55, 0.8, 1.0], float(rng.uniform(0.14, 0.2))),
        "sines": sines(float(rng.uniform(0.10, 0.14)), float(rng.uniform(0.35, 0.5))),
        "random_steps": steps(levels, holds),
    }
    return [Protocol(name, length, drive, peak()) for name, (length, drive) in shapes.items()]


ONE_RATE_SAMPLES = 121  # a run: every turn falls on a sample


def one_rate(rng: np.random.Generator) -> list[Protocol]:
    """Triangles of a single slow rate and one amplitude, more or fewer a run, sampled too coarsely
    to tell how a loop closes after a turn.
    """
    rate = float(rng.uniform(0.05, 0.07))
    made = [(number, triangles([1.0] * number, rate)) for number in (4, 5, 6, 10, 12, 15)]
    return [Protocol(f"triangles_{n}", length, drive) for n, (length, drive) in made]


LEAST = 0.3  # of the peak, below which `above` never goes


def above(rng: np.random.Generator) -> list[Protocol]:
    """The standard protocols between 0.3 and 1, as of an actuator that is never emptied."""

    def lifted(drive: Callable[[Array], Array]) -> Callable[[Array], Array]:
        return lambda time: LEAST + (1.0 - LEAST) * drive(time)

    return [
        Protocol(f"{one.name}_above", one.duration, lifted(one.drive), one.peak)
        for one in standard(rng)
    ]


def slow(rng: np.random.Generator) -> list[Protocol]:
    """One slow ramp to each of six peaks, so that no loop and no lag shows its own course."""
    made = []
    for share in (0.5, 0.6, 0.7, 0.8, 0.9, 1.0):
        length, drive = ramp(float(rng.uniform(14, 18)) * share, 0.0, 0.0)
        made.append(Protocol(f"ramp_to_{100 * share:.0f}", length, drive, share))
    return made
