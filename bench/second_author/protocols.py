"""Courses of the input over time: ramps, steps, stairs, sines, cycles with rests."""

import numpy as np

KINDS = ("ramp", "steps", "stairs", "sine", "cycles", "rests")


def course(kind: str, peak: float, duration: float, rng: np.random.Generator) -> np.ndarray:
    """Corners of a course from 0 to `peak` and back, shape (corners, 2): time [s], value."""
    if kind == "ramp":
        top = rng.uniform(0.4, 0.6)
        corners = [(0, 0), (top, 1), (top + 0.05, 1), (1, 0)]
    elif kind == "steps":
        corners = _levels([0.5, 1.0, 0.3, 0.8, 0.0], rise=0.02)
    elif kind == "stairs":
        up = list(np.linspace(0.2, 1, int(rng.integers(4, 7))))
        corners = _levels([*up, *up[-2::-1], 0.0], rise=0.02)
    elif kind == "sine":
        t = np.linspace(0, 1, 200)
        corners = list(zip(t, 0.5 - 0.5 * np.cos(2 * np.pi * rng.integers(2, 5) * t), strict=True))
    elif kind == "cycles":
        corners = [(k / 6, k % 2) for k in range(7)]
    else:  # a small cycle, a rest, a large one, a rest
        corners = [(0, 0), (0.15, 0.6), (0.3, 0), (0.5, 0), (0.65, 1), (0.75, 1), (0.9, 0), (1, 0)]
    return np.array(corners, float) * [duration, peak]


def _levels(levels: list[float], rise: float) -> list[tuple[float, float]]:
    """Levels that are held in turn, each reached within `rise` of the whole."""
    corners, before = [(0.0, 0.0), (0.03, 0.0)], 0.0
    for k, level in enumerate(levels):
        start = 0.03 + 0.97 * k / len(levels)
        corners += [(start + rise / 2, before), (start + rise, level)]
        before = level
    return [*corners, (1.0, before)]
