"""The registry of what can be hidden: how it acts, its strength, what else is drawn.

`LAWS[name]` holds a function that builds the law into a `Plant`, the parameter that sets its
strength with the range in which it is sought, and a draw of the other parameters. The names of the
catalogue have the catalogue's equations; all others are other functional forms or faults.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from bench.hidden.plant import Plant

Parameters = Mapping[str, float]


@dataclass(frozen=True)
class Law:
    """One thing that can be hidden.

    knob: (parameter, weakest, strongest), sought on a logarithmic scale, or None when nothing can
    be set; signed: the knob's sign is drawn. draw: the other parameters.
    """

    act: Callable[..., None]
    knob: tuple[str, float, float] | None
    draw: Callable[[np.random.Generator], dict[str, float]] = lambda rng: {}
    signed: bool = False
    told: Callable[[dict[str, float]], dict[str, float]] = dict

    def complete(self, given: Parameters, rng: np.random.Generator) -> dict[str, float]:
        """Given parameters and drawn ones; the knob, unless given, at its strongest end."""
        values = self.draw(rng) | dict(given)
        if self.knob is not None and self.knob[0] not in given:
            sign = rng.choice([-1.0, 1.0]) if self.signed else 1.0
            values[self.knob[0]] = sign * self.knob[2]
        return values


LAWS: dict[str, Law] = {}


def law(
    name: str,
    knob: tuple[str, float, float] | None,
    draw: Callable[[np.random.Generator], dict[str, float]] = lambda rng: {},
    signed: bool = False,
    told: Callable[[dict[str, float]], dict[str, float]] = dict,
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Register a function `act(plant, **parameters)` under a name."""

    def register(act: Callable[..., None]) -> Callable[..., None]:
        LAWS[name] = Law(act, knob, draw, signed, told)
        return act

    return register


def build(hidden: list[tuple[str, Parameters]], scale: float, mode: str = "planar") -> Plant:
    """A plant with laws built in, in their order, and a modulus scale."""
    plant = Plant(scale=scale, mode=mode)
    for name, parameters in hidden:
        LAWS[name].act(plant, **parameters)
    return plant


def log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    """A number between low and high, uniform in its logarithm."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))
