"""Valve pulses from many pressures: of a channel whose vessel is set anew before each pulse."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from model_lab.measurement import DEFLATE, INFLATE, MeasurementSet, Run, Specimen
from softhand_model.gas import AMBIENT_PRESSURE, psi

Array = NDArray[np.float64]

PULSES = 200
SUPPLIES = {"supply_150_kPa": 150e3, "supply_250_kPa": 250e3, "supply_350_kPa": 350e3}  # gauge
LENGTHS = {"short": (0.05, 0.3), "long": (0.2, 1.2)}  # [s] inflating, shortest and longest
QUICKER = 6.0  # times shorter deflating
LEAST, MOST = 10e3, 150e3  # [Pa] gauge pressure of the channel
DRIFT = 0.05  # of the pressures within a pulse, falling on the one side and rising on the other
POINTS = 9  # of the integrals over a pulse


def pulse_set(random: np.random.Generator) -> MeasurementSet:
    """Short and long pulses at three supply pressures, inflating and deflating."""
    columns = {
        f"{supply}_{length}": pulse_columns(
            SUPPLIES[supply] + AMBIENT_PRESSURE, LENGTHS[length], random
        )
        | {"mass": np.zeros(PULSES)}
        for supply in SUPPLIES
        for length in LENGTHS
    }
    runs = [
        Run(f"r{order + 1}{repeat}", "channel", protocol, 293.15, columns[protocol])
        for repeat in "ab"
        for order, protocol in enumerate(columns)
    ]
    specimens = {"channel": Specimen("channel", {}, batch="A")}
    return MeasurementSet("valve_pulse", "synthesised valve pulses", specimens, tuple(runs))


def pulse_columns(
    supply: float, length: tuple[float, float], random: np.random.Generator
) -> dict[str, Array]:
    """Inputs (pulses,) for an absolute supply pressure [Pa] and lengths between two [s]."""
    inflating = random.uniform(size=PULSES) < 0.5
    shortest, longest = length
    duration = shortest * (longest / shortest) ** random.uniform(size=PULSES)
    duration = np.where(inflating, duration, duration / QUICKER)
    channel = AMBIENT_PRESSURE + random.uniform(LEAST, min(MOST, 0.9 * supply - 101e3), PULSES)
    sagging = supply * random.uniform(0.94, 1.0, PULSES)  # other channels draw from it as well
    p_in = np.where(inflating, sagging, channel)
    p_out = np.where(inflating, channel, AMBIENT_PRESSURE)
    friction, injector = _integrals(inflating, p_in, p_out)
    return {
        "direction": np.where(inflating, INFLATE, DEFLATE),
        "duration": duration,
        "p_in": p_in,
        "p_out": p_out,
        "friction_integral": friction * duration,
        "injector_integral": injector * duration,
    }


def _integrals(inflating: NDArray[np.bool_], p_in: Array, p_out: Array) -> tuple[Array, Array]:
    """Means (pulses,) [Pa] of p_in - p_out and of p_in*Psi while the channel's pressure moves."""
    along = DRIFT * np.linspace(0.0, 1.0, POINTS)[:, None]
    into = np.where(inflating, p_in, p_in * (1.0 - along))
    out = np.where(inflating, p_out * (1.0 + along), p_out)
    return np.mean(into - out, axis=0), np.mean(into * psi(out / into), axis=0)
