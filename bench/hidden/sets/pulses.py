"""Making one measurement set of valve pulses with hidden laws."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import brentq

from bench.hidden.flow import SUPPLIES, Commands, Valve, drive, joined, planned
from bench.hidden.laws import flow as _laws  # noqa: F401  (registers its laws)
from bench.hidden.laws.registry import LAWS
from bench.hidden.sets.writing import write_set

Array = np.ndarray
Entries = list[tuple[str, dict[str, float]]]
UNITS = {
    "direction": "",
    "duration": "ms",
    "p_in": "kPa",
    "p_out": "kPa",
    "friction_integral": "Pa*s",
    "injector_integral": "Pa*s",
    "mass": "mg",
}


def make_pulse_set(
    folder: Path,
    hidden: Entries,
    *,
    seed: int,
    noise: float,
    scatter: float,
    ratio: float | None,
    runs: int,
    samples: int,
    repeats: int,
    with_noise: bool,
    adjacent: bool,
) -> dict[str, Any]:
    """Write a set of pulses on a bottle; arguments and truth as those of `make_set`."""
    rng = np.random.default_rng(seed)
    names = list(SUPPLIES)[: max(1, runs // repeats)]
    conductances = rng.uniform(1.2e-10, 1.8e-10), rng.uniform(5e-10, 7e-10)
    commands = planned(rng, names, samples, Valve(*conductances))
    order = sorted(names * repeats) if adjacent else names * repeats
    setup = Setup(joined([commands[name] for name in order]), conductances, noise, scatter)
    entries, ratios = [], []
    for name, given in hidden:
        values, reached = setup.tuned(name, LAWS[name].complete(given, rng), given, ratio)
        entries.append((name, values))
        ratios += reached
    columns = setup.columns(entries)
    floor, sigma = setup.floor(columns), noise * float(columns["mass"].max())
    together = float(np.hypot(misfit(columns), floor) / floor)
    gains = 1 + scatter * rng.standard_normal((len(order), 1))
    clean = columns["mass"]
    columns["mass"] = clean * gains + sigma * rng.standard_normal(clean.shape)
    _write(Path(folder), order, columns, sigma if with_noise else None)
    told = [{"name": name, "parameters": LAWS[name].told(values)} for name, values in entries]
    return {
        "experiment": "valve_pulse",
        "hidden": told,
        "calibration": dict(zip(("inflate", "deflate"), conductances, strict=True)),
        "noise": sigma,
        "floor": floor,
        "ratio": together,
        "ratios": ratios,
    }


class Setup:
    """The runs of a set, and what laws make of them."""

    def __init__(
        self,
        commands: Commands,
        conductances: tuple[float, float],
        noise: float,
        scatter: float,
    ) -> None:
        self.commands, self.conductances = commands, conductances
        self.noise, self.scatter = noise, scatter

    def columns(self, entries: Entries) -> dict[str, Array]:
        """Columns (runs, pulses) without noise."""
        valve = Valve(*self.conductances)
        for name, values in entries:
            LAWS[name].act(valve, **values)
        return drive(valve, self.commands)

    def floor(self, columns: dict[str, Array]) -> float:
        """Noise floor [kg]."""
        mass = columns["mass"]
        return float(np.hypot(self.noise * mass.max(), self.scatter * np.sqrt((mass**2).mean())))

    def ratio(self, name: str, values: dict[str, float]) -> float:
        """Error before over floor with one law."""
        columns = self.columns([(name, values)])
        floor = self.floor(columns)
        return float(np.hypot(misfit(columns), floor) / floor)

    def tuned(
        self, name: str, values: dict[str, float], given: dict[str, float], ratio: float | None
    ) -> tuple[dict[str, float], list[float]]:
        """Values with the knob set for the ratio, and the ratio reached."""
        knob = LAWS[name].knob
        if ratio is None or knob is None or knob[0] in given:
            return values, [] if ratio is None else [self.ratio(name, values)]
        sign = np.sign(values[knob[0]])

        def surplus(logarithm: float) -> float:
            found = self.ratio(name, {**values, knob[0]: float(sign * np.exp(logarithm))})
            return float(np.log((found**2 - 1 + 1e-9) / (ratio**2 - 1)))

        ends = np.log(knob[1:])
        if surplus(ends[1]) <= 0:
            return values, [self.ratio(name, values)]
        value = float(sign * np.exp(brentq(surplus, *sorted(ends), xtol=0.01)))
        values = {**values, knob[0]: value}
        return values, [self.ratio(name, values)]


def misfit(columns: dict[str, Array]) -> float:
    """Root mean square of what the naive model leaves, one conductance a direction."""
    product, left = columns["p_in"] * columns["duration"], columns["mass"].copy()
    for rows in (columns["direction"], ~columns["direction"]):
        x, y = product[rows], columns["mass"][rows]
        left[rows] = y - x * (x @ y) / (x @ x)
    return float(np.sqrt((left**2).mean()))


def _write(folder: Path, order: list[str], columns: dict[str, Array], sigma: float | None) -> None:
    runs = {}
    for k, protocol in enumerate(order):
        own = {name: values[k] for name, values in columns.items()}
        own["direction"] = np.where(own["direction"], "inflate", "deflate")
        entry = {"specimen": "channel", "temperature": 293.15, "protocol": protocol}
        runs[f"r{k + 1:02d}"] = (entry, own)
    head = {
        "experiment": "valve_pulse",
        "title": "pulses of one channel on a bottle",
        "specimens": {"channel": {"volume": 0.5e-3}},
    }
    write_set(folder, head, UNITS, None if sigma is None else {"mass": sigma}, runs)
