"""Valve pulses on a bottle: what each moves, and what the pressures do meanwhile."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

Array = np.ndarray
AMBIENT = 101.3e3
GAS_CONSTANT, ROOM = 287.05, 293.15
BOTTLE = 0.5e-3  # [m3]
NODES = 9  # of Simpson's rule over a pulse
LEAST = 2e3  # [Pa] of the bottle above the ambient
PASSES = 4  # pulse's mass and the pressure it leaves


@dataclass(frozen=True)
class Pulse:
    """One pulse of every run, arrays (runs,): pressures at switch-on [Pa], what they become."""

    inflating: Array
    duration: Array
    p_in: Array
    p_out: Array
    friction: Array  # integral of p_in - p_out
    injector: Array  # integral of p_in*Psi
    along_in: Array  # (NODES, runs)
    along_out: Array
    turned: Array  # the direction differs from the pulse before


@dataclass
class Valve:
    """The true valve: naive conductances, and laws that change a pulse or its mass."""

    inflate: float
    deflate: float
    replaced: bool = False
    opening: list[Callable[[Pulse], Array]] = field(default_factory=list)  # open time [s]
    terms: list[Callable[[Pulse], Array]] = field(default_factory=list)  # added mass [kg]
    reading: list[Callable[[Pulse, Array], Array]] = field(default_factory=list)

    def mass(self, pulse: Pulse) -> Array:
        """Mass (runs,) that a pulse moves."""
        for change in self.opening:
            lasting = np.maximum(change(pulse), 0.0)
            share = lasting / pulse.duration
            pulse = replace(
                pulse,
                duration=lasting,
                friction=share * pulse.friction,
                injector=share * pulse.injector,
            )
        conductance = np.where(pulse.inflating, self.inflate, self.deflate)
        moved = 0.0 if self.replaced else conductance * pulse.p_in * pulse.duration
        for term in self.terms:
            moved = moved + term(pulse)
        return moved


def psi(ratio: Array) -> Array:
    """Flow function of an ideal nozzle, kappa = 1.4."""
    r = np.maximum(ratio, 0.5283)
    return np.sqrt(np.maximum(3.5 * (r ** (2 / 1.4) - r ** (2.4 / 1.4)), 0.0))


def simpson(values: Array, duration: Array) -> Array:
    """Integral over a pulse of values (NODES, runs)."""
    weights = np.ones(NODES)
    weights[1:-1:2], weights[2:-1:2] = 4.0, 2.0
    return (weights[:, None] * values).sum(axis=0) * duration / (3 * (NODES - 1))


@dataclass(frozen=True)
class Commands:
    """What the runs command: inflating and duration (runs, pulses), gauge supply (runs,) [Pa]."""

    inflating: Array
    duration: Array
    supply: Array


def drive(valve: Valve, commands: Commands) -> dict[str, Array]:
    """Columns (runs, pulses) of a bottle that is driven through all pulses.

    Between pulses it is brought back to where a supply and a vent can take it, if a strong law has
    led out of there.
    """
    runs, pulses = commands.duration.shape
    bottle = np.full(runs, AMBIENT + 20e3)
    supply = commands.supply + AMBIENT
    before = commands.inflating[:, 0]
    columns: dict[str, list[Array]] = {}
    for k in range(pulses):
        inflating = commands.inflating[:, k]
        pulse, mass = _settled(
            valve, inflating, commands.duration[:, k], supply, bottle, inflating != before
        )
        before = inflating
        bottle = bottle + _rise(np.where(inflating, mass, -mass))
        bottle = np.clip(bottle, AMBIENT + LEAST, supply)
        for reading in valve.reading:
            mass = reading(pulse, mass)
        for name, values in _columns(pulse, mass).items():
            columns.setdefault(name, []).append(values)
    return {name: np.array(values).T for name, values in columns.items()}


def _rise(mass: Array) -> Array:
    return mass * GAS_CONSTANT * ROOM / BOTTLE


def _settled(
    valve: Valve, inflating: Array, duration: Array, supply: Array, bottle: Array, turned: Array
) -> tuple[Pulse, Array]:
    """The pulse whose mass and whose change of the bottle's pressure agree."""
    place = np.linspace(0, 1, NODES)[:, None]
    mass = np.zeros_like(bottle)
    for _ in range(PASSES):
        path = bottle + place * _rise(np.where(inflating, mass, -mass))
        p_in = np.where(inflating, supply, path)
        p_out = np.where(inflating, path, AMBIENT)
        friction = simpson(p_in - p_out, duration)
        injector = simpson(p_in * psi(p_out / p_in), duration)
        pulse = Pulse(
            inflating, duration, p_in[0], p_out[0], friction, injector, p_in, p_out, turned
        )
        mass = valve.mass(pulse)
    return pulse, mass


def _columns(pulse: Pulse, mass: Array) -> dict[str, Array]:
    return {
        "direction": pulse.inflating,
        "duration": pulse.duration,
        "p_in": pulse.p_in,
        "p_out": pulse.p_out,
        "friction_integral": pulse.friction,
        "injector_integral": pulse.injector,
        "mass": mass,
    }


SUPPLIES = {  # protocol: gauge supply [Pa], shortest and longest pulse while inflating [s]
    "low_short": (120e3, 0.04, 0.25),
    "low_long": (120e3, 0.10, 0.90),
    "middle_short": (210e3, 0.04, 0.25),
    "middle_long": (210e3, 0.10, 0.90),
    "high_short": (310e3, 0.04, 0.25),
    "high_long": (310e3, 0.10, 0.90),
}


def planned(
    rng: np.random.Generator, names: list[str], pulses: int, valve: Valve
) -> dict[str, Commands]:
    """Commands of each protocol, one row: up and down between two pressures (Algorithm 1)."""
    return {name: _planned(rng, *SUPPLIES[name], pulses, valve) for name in names}


def _planned(
    rng: np.random.Generator, supply: float, low: float, high: float, pulses: int, valve: Valve
) -> Commands:
    bottle, upwards = AMBIENT + 20e3, True
    top = AMBIENT + min(0.85 * supply, 200e3)
    inflating, durations = np.zeros(pulses, bool), np.zeros(pulses)
    for k in range(pulses):
        length = float(np.clip(rng.exponential((low + high) / 3), low, high))
        upwards = (upwards and bottle < top) or bottle < AMBIENT + 15e3
        inflating[k] = rng.random() < (0.8 if upwards else 0.2)
        if not inflating[k] and bottle < AMBIENT + 12e3:
            inflating[k] = True
        conductance = valve.inflate if inflating[k] else valve.deflate
        durations[k] = length if inflating[k] else max(0.02, length / 4)
        pressure = supply + AMBIENT if inflating[k] else bottle
        moved = conductance * pressure * durations[k] * (1 if inflating[k] else -1)
        bottle = max(bottle + float(_rise(np.array(moved))), AMBIENT + LEAST)
    return Commands(inflating[None], durations[None], np.array([supply]))


def joined(rows: list[Commands]) -> Commands:
    """Commands of many runs."""
    parts = zip(*((row.inflating, row.duration, row.supply) for row in rows), strict=True)
    return Commands(*(np.concatenate(part) for part in parts))
