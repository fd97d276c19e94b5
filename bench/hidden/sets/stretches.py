"""Sets of rubber in three modes with hidden laws: energies, differentiated numerically."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import brentq

from bench.hidden.laws.registry import LAWS, law, log_uniform
from bench.hidden.sets.writing import write_set

Array = np.ndarray
Energy = Callable[[Array], Array]
Entries = list[tuple[str, dict[str, float]]]
MODES = ("uniaxial", "pure_shear", "equibiaxial")
PEAKS = {"uniaxial": (3.5, 6.0), "pure_shear": (3.0, 4.5), "equibiaxial": (2.4, 3.6)}
STATED, MODULUS = 300e3, (120e3, 600e3)  # [Pa]
STEP = 1e-4
BESIDE = {"three_terms": {"low": 0.0}}
"""Parts of a law that are of another family than the law, with the value at which they vanish: the
term with the exponent -2 is Mooney and Rivlin's."""
UNITS = {"stretch": "", "stress": "kPa"}


@dataclass
class Material:
    """Energies over the shear modulus of principal stretches (3, n), which add up by their shares
    of the modulus; what is left of it is neo-Hooke's.
    """

    parts: list[tuple[float, Energy]] = field(default_factory=list)

    def energy(self, stretches: Array) -> Array:
        """All of it."""
        rest = 1.0 - sum(share for share, _ in self.parts)
        found = rest * 0.5 * np.sum(stretches**2, axis=0)
        return found + sum(share * part(stretches) for share, part in self.parts)


def principal(mode: str, stretch: Array) -> Array:
    """Principal stretches (3, n) of rubber that keeps its volume."""
    second = {"uniaxial": stretch**-0.5, "pure_shear": stretch**0.0, "equibiaxial": stretch}[mode]
    return np.array([stretch, second, 1.0 / (stretch * second)])


def stress(material: Material, mode: str, stretch: Array) -> Array:
    """Nominal stress over the shear modulus."""
    up, down = (material.energy(principal(mode, stretch + side * STEP)) for side in (1.0, -1.0))
    return (up - down) / (2.0 * STEP) / (2.0 if mode == "equibiaxial" else 1.0)


def inverse_langevin(share: Array) -> Array:
    """Root b of coth(b) - 1/b = share, exact, by Newton's method."""
    b = 3.0 * share / (1.0 - share**2)
    for _ in range(50):
        slope = 1.0 / b**2 - 1.0 / np.sinh(np.minimum(b, 300.0)) ** 2
        b = b - (1.0 / np.tanh(b) - 1.0 / b - share) / slope
    return b


@law("exact_chains", ("links", 300.0, 12.5))
def exact_chains(material: Material, links: float) -> None:
    """Eight chains with the exact inverse Langevin function."""

    def energy(stretches: Array) -> Array:
        share = np.sqrt(np.sum(stretches**2, axis=0) / (3.0 * links))
        b, rest = inverse_langevin(share), np.sqrt(1.0 / links)
        modulus = inverse_langevin(np.array(rest)) / rest / 3.0
        logarithm = np.log(2.0 * b) - b - np.log1p(-np.exp(-2.0 * b))
        return np.asarray(links * (share * b + logarithm) / modulus)

    material.parts.append((1.0, energy))


@law(
    "three_terms",
    ("share", 1e-4, 0.05),
    lambda rng: {"high": rng.uniform(4.5, 6.5), "low": rng.uniform(0.0, 0.05)},
)
def three_terms(material: Material, share: float, high: float, low: float) -> None:
    """Ogden with three terms: exponents 2, `high` and -2."""
    for part, exponent in ((share, high), (low, -2.0)):
        material.parts.append((part, lambda s, a=exponent: 2.0 / a**2 * np.sum(s**a, axis=0)))


@law("carroll", ("share", 0.03, 0.6), lambda rng: {"quartic": log_uniform(rng, 1e-7, 2e-6)})
def carroll(material: Material, share: float, quartic: float) -> None:
    """Carroll: a root of the second invariant beside a fourth power of the first."""

    def power(s: Array) -> Array:
        return np.sum(s**2, axis=0) ** 4 / 216.0

    def root(s: Array) -> Array:
        return np.sqrt(3.0 * np.sum(s**-2.0, axis=0))

    material.parts += [(share, root), (216.0 * quartic, power)]


@law("logarithm_of_the_second", ("share", 0.03, 0.6))
def logarithm_of_the_second(material: Material, share: float) -> None:
    """Gent and Thomas: a logarithm of the second invariant."""
    material.parts.append((share, lambda s: 1.5 * np.log(np.sum(s**-2.0, axis=0))))


@law("knowles", ("b", 0.003, 0.1), lambda rng: {"n": rng.uniform(1.5, 2.5)})
def knowles(material: Material, b: float, n: float) -> None:
    """Knowles: a power of the first invariant, which stiffens."""

    def energy(s: Array) -> Array:
        return ((1.0 + b / n * (np.sum(s**2, axis=0) - 3.0)) ** n) / (2.0 * b)

    material.parts.append((1.0, energy))


@dataclass
class Bench:
    """Stretches of each mode, and noise and scatter over the largest stress."""

    stretches: dict[str, Array]
    noise: float
    scatter: float

    def clean(self, entries: Entries) -> dict[str, Array]:
        """Stress over the shear modulus by mode."""
        material = Material()
        for name, values in entries:
            LAWS[name].act(material, **values)
        return {mode: stress(material, mode, lam) for mode, lam in self.stretches.items()}

    def floor(self, clean: dict[str, Array]) -> float:
        """Noise floor over the shear modulus."""
        joined = np.concatenate(list(clean.values()))
        return float(
            np.hypot(self.noise * joined.max(), self.scatter * np.sqrt(np.mean(joined**2)))
        )

    def ratio(self, entries: Entries) -> float:
        """Error of neo-Hooke with the best modulus over the floor."""
        clean, base = self.clean(entries), self.clean([])
        x, y = (np.concatenate(list(parts.values())) for parts in (base, clean))
        left = y - x * (x @ y) / (x @ x)
        floor = self.floor(clean)
        return float(np.hypot(np.sqrt(np.mean(left**2)), floor) / floor)

    def tuned(self, name: str, values: dict[str, float], ratio: float) -> dict[str, float]:
        """Values with the knob set for a ratio, or at its strongest."""
        knob, weak, strong = LAWS[name].knob or ("", 1.0, 1.0)

        def surplus(logarithm: float) -> float:
            return self.ratio([(name, {**values, knob: float(np.exp(logarithm))})]) - ratio

        ends = np.log([weak, strong])
        for end, beyond in zip(ends, (np.greater_equal, np.less_equal), strict=True):
            if beyond(surplus(end), 0.0):
                return {**values, knob: float(np.exp(end))}
        return {**values, knob: float(np.exp(brentq(surplus, *sorted(ends), xtol=0.01)))}


def make_rubber_set(
    folder: Path,
    hidden: Entries,
    *,
    seed: int,
    noise: float,
    scatter: float,
    ratio: float | None,
    samples: int,
    repeats: int,
    with_noise: bool,
    **_unused: Any,
) -> dict[str, Any]:
    """Write a set of three modes; arguments and truth as those of `make_set`."""
    rng = np.random.default_rng(seed)
    stretches = {
        mode: np.linspace(1.0, rng.uniform(*PEAKS[mode]), samples + 1)[1:] for mode in MODES
    }
    bench = Bench(stretches, noise, scatter)
    entries: Entries = []
    for name, given in hidden:
        values = LAWS[name].complete(given, rng)
        tuned = ratio is not None and LAWS[name].knob is not None
        entries.append((name, bench.tuned(name, values, ratio) if tuned and ratio else values))
    clean, modulus = bench.clean(entries), log_uniform(rng, *MODULUS)
    sigma = noise * max(float(one.max()) for one in clean.values())
    runs = {}
    for repeat in range(repeats):
        for mode, course in clean.items():
            shown = course * (1 + scatter * rng.standard_normal())
            shown = modulus * (shown + sigma * rng.standard_normal(len(course)))
            entry = {"specimen": "sheet", "temperature": 293.15, "protocol": mode, "mode": mode}
            columns = {"stretch": stretches[mode], "stress": shown}
            runs[f"{mode}_{repeat + 1}"] = (entry, columns)
    head = {
        "experiment": "rubber",
        "title": "sheets of a rubber in three modes",
        "specimens": {"sheet": {"shear_modulus": STATED}},
    }
    write_set(folder, head, UNITS, {"stress": modulus * sigma} if with_noise else None, runs)
    reached = bench.ratio(entries)
    return {
        "experiment": "rubber",
        "hidden": [{"name": name, "parameters": values} for name, values in entries],
        "modulus": modulus,
        "noise": modulus * sigma,
        "floor": modulus * bench.floor(clean),
        "ratio": reached,
        "ratios": [
            bench.ratio([(name, values | BESIDE.get(name, {}))]) for name, values in entries
        ],
    }
