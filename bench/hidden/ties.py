"""Cases that end in a tie: too few kinds of runs to tell one effect from another."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import Any

from bench.hidden.case import LOW_NOISES, Case, Expected, named
from bench.hidden.laws.registry import Parameters
from bench.hidden.protocols import ONE_RATE_SAMPLES

LOOPS: dict[str, dict[str, float]] = {  # memory too short for the samples to resolve
    "viscoelasticity": {"relaxation_time": 0.3},
    "tube_lag": {},
    "hysteresis": {"stretch_scale": 0.01},
}
# the same as the lag of a tube on a straight ramp
LAGS = frozenset({"angle_sensor_lag", "clock_offset", "growing_chamber_lag"})
RATES = {"drives": "one_rate", "samples": ONE_RATE_SAMPLES}
TIED: tuple[tuple[str, str, str, Parameters, dict[str, Any]], ...] = (
    *(("one_rate", "free_bending", law, given, RATES) for law, given in LOOPS.items()),
    ("above", "free_bending", "pressure_offset", {}, {"drives": "above"}),
    ("above", "free_bending", "dead_zone", {}, {"drives": "above"}),
    ("above", "blocked_tip", "pressure_offset", {}, {"drives": "above"}),
    ("above", "blocked_tip", "dead_zone", {}, {"drives": "above"}),
    ("slow", "free_bending", "thick_wall", {}, {"drives": "slow"}),
    ("slow", "free_bending", "tube_lag", {}, {"drives": "slow"}),
    ("slow", "free_bending", "angle_sensor_lag", {}, {"drives": "slow"}),
)


def one_rate() -> Iterator[Case]:
    """Triangles of one rate: loops of different causes look alike, and so do all lags."""
    expected = Expected("effects_missing", (frozenset(LOOPS),), frozenset(LOOPS), LAGS)
    for law, given in LOOPS.items():
        name, hidden = f"one_rate/free_bending/{law}", ((law, given),)
        yield Case(name, "one rate", "free_bending", hidden, expected, 2.0, RATES, LOW_NOISES)


def tied() -> Iterator[Case]:
    """One effect, seen by too few kinds of runs, so that an experiment has to be proposed."""
    for (word, experiment, law, given, options), ratio in product(TIED, (2.0, 4.0)):
        name, expected = f"plan/{experiment}/{word}/{law}/{ratio:g}", named((law,))
        hidden = ((law, dict(given)),)
        yield Case(name, "plan", experiment, hidden, expected, ratio, options, LOW_NOISES)
