"""Laws of valve pulses: the catalogue's, their relatives, and faults. They act on a `Valve`."""

from __future__ import annotations

import numpy as np

from bench.hidden.flow import AMBIENT, Pulse, Valve, simpson
from bench.hidden.laws.registry import law

Array = np.ndarray
Values = dict[str, float]


def _channel(pulse: Pulse) -> Array:
    return np.where(pulse.inflating, pulse.p_out, pulse.p_in)


def _directions(name: str) -> object:
    """Parameters of both directions under the catalogue's names, from one and their ratio."""

    def told(values: Values) -> Values:
        one = values[f"{name}_inflate"]
        return {f"{name}_inflate": one, f"{name}_deflate": one * values["deflate_over"]}

    return told


def _drawn(low: float, high: float) -> object:
    return lambda rng: {"deflate_over": rng.uniform(low, high)}


@law(
    "injector_flow",
    None,
    lambda rng: {"c2_inflate": rng.uniform(1.5e-10, 2.5e-10), "deflate_over": rng.uniform(4, 8)},
    told=_directions("c2"),
)
def injector_flow(valve: Valve, c2_inflate: float, deflate_over: float) -> None:
    """Flow through a choke instead of the naive term."""
    valve.replaced = True
    valve.terms.append(lambda p: c2_inflate * np.where(p.inflating, 1.0, deflate_over) * p.injector)


@law("line_friction", ("c1_inflate", 1e-13, 3e-10), _drawn(2, 5), told=_directions("c1"))
def line_friction(valve: Valve, c1_inflate: float, deflate_over: float) -> None:
    """Flow against viscous friction."""
    valve.terms.append(lambda p: c1_inflate * np.where(p.inflating, 1.0, deflate_over) * p.friction)


def _switching_told(values: Values) -> Values:
    one = values["c3_inflate"]
    return {
        "c3_inflate": one,
        "c3_deflate": one * values["deflate_over"],
        "c4_inflate": -one * values["held_back"],
    }


@law(
    "switching_volume",
    ("c3_inflate", 1e-14, 1e-10),
    lambda rng: {"deflate_over": rng.uniform(0.7, 1.6), "held_back": rng.uniform(0.5, 1.2)},
    told=_switching_told,
)
def switching_volume(
    valve: Valve, c3_inflate: float, deflate_over: float, held_back: float
) -> None:
    """What switching moves, whatever the duration."""

    def term(p: Pulse) -> Array:
        inflate = p.p_in - held_back * p.p_out
        return c3_inflate * np.where(p.inflating, inflate, deflate_over * p.p_in)

    valve.terms.append(term)


@law("pulse_bias", ("c0_inflate", 1e-9, 2e-5), _drawn(0.5, 2), True, _directions("c0"))
def pulse_bias(valve: Valve, c0_inflate: float, deflate_over: float) -> None:
    """A mass that every pulse moves."""
    valve.terms.append(lambda p: c0_inflate * np.where(p.inflating, 1.0, deflate_over))


@law("valve_delay", ("delay", 1e-4, 0.03))
def valve_delay(valve: Valve, delay: float) -> None:
    """The valve is open for less than its command."""
    valve.opening.append(lambda p: p.duration - delay)


@law("leakage", ("conductance", 1e-13, 1e-9))
def leakage(valve: Valve, conductance: float) -> None:
    """The channel leaks during a pulse."""
    valve.terms.append(lambda p: -conductance * (_channel(p) - AMBIENT) * p.duration)


@law(
    "iso_choke",
    None,
    lambda rng: {
        "c2": rng.uniform(0.8e-10, 1.3e-10),
        "deflate_over": rng.uniform(4, 8),
        "critical": rng.uniform(0.4, 0.5),
    },
)
def iso_choke(valve: Valve, c2: float, deflate_over: float, critical: float) -> None:
    """A choke as ISO 6358 has it: an ellipse above its own critical ratio."""
    valve.replaced = True

    def term(p: Pulse) -> Array:
        past = np.maximum(p.along_out / p.along_in - critical, 0.0) / (1 - critical)
        flow = p.along_in * np.sqrt(np.maximum(1 - past**2, 0.0))
        return c2 * np.where(p.inflating, 1.0, deflate_over) * simpson(flow, p.duration)

    valve.terms.append(term)


@law("compressible_line", ("c1", 1e-13, 3e-10), _drawn(2, 5))
def compressible_line(valve: Valve, c1: float, deflate_over: float) -> None:
    """Viscous flow of a gas that thins out along the line."""

    def term(p: Pulse) -> Array:
        flow = (p.along_in**2 - p.along_out**2) / 500e3
        return c1 * np.where(p.inflating, 1.0, deflate_over) * simpson(flow, p.duration)

    valve.terms.append(term)


@law("orifice_leak", ("conductance", 1e-13, 1e-9))
def orifice_leak(valve: Valve, conductance: float) -> None:
    """A leak that throttles with the square of its flow."""

    def term(p: Pulse) -> Array:
        over = np.maximum(_channel(p) - AMBIENT, 0.0)
        return -conductance * over**0.8 * 60e3**0.2 * p.duration

    valve.terms.append(term)


@law("pressed_valve", ("delay", 1e-4, 0.03), lambda rng: {"power": rng.uniform(0.15, 0.35)})
def pressed_valve(valve: Valve, delay: float, power: float) -> None:
    """A delay that grows a little with the pressure on the valve."""
    valve.opening.append(lambda p: p.duration - delay * (p.p_in / 300e3) ** power)


@law(
    "warm_dead_volume",
    ("c3", 1e-14, 1e-10),
    lambda rng: {"power": rng.uniform(0.8, 0.92), "held_back": rng.uniform(0.5, 1.2)},
)
def warm_dead_volume(valve: Valve, c3: float, power: float, held_back: float) -> None:
    """A dead volume whose filling falls short at high pressure."""

    def term(p: Pulse) -> Array:
        filled = p.p_in**power * 300e3 ** (1 - power)
        return c3 * (filled - held_back * np.where(p.inflating, p.p_out, 0.0))

    valve.terms.append(term)


@law("sticky_valve", ("share", 0.002, 0.9))
def sticky_valve(valve: Valve, share: float) -> None:
    """The first pulse after a change of direction moves less."""
    valve.reading.append(lambda p, mass: mass * (1 - share * p.turned))


@law("saturated_meter", ("limit", 60e-6, 1e-6))
def saturated_meter(valve: Valve, limit: float) -> None:
    """The meter ends at a mass."""
    valve.reading.append(lambda p, mass: np.minimum(mass, limit))


@law("stepping_gain", ("step", 0.002, 0.6), lambda rng: {"at": rng.uniform(140e3, 180e3)}, True)
def stepping_gain(valve: Valve, step: float, at: float) -> None:
    """The pressure sensor of the channel changes its gain at a pressure."""
    valve.reading.append(lambda p, mass: mass * (1 + step * (_channel(p) > at)))


@law("wearing_choke", ("size", 0.004, 0.9))
def wearing_choke(valve: Valve, size: float) -> None:
    """A choke that clogs from run to run."""
    valve.reading.append(lambda p, mass: mass * (1 - size * np.linspace(0, 1, len(mass))))
