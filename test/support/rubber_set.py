"""Tests of rubber in three modes, from an energy of the principal stretches alone."""

import numpy as np

from model_lab.measurements.measurement_set import MODES, MeasurementSet, Run, Specimen

STATED, TRUE = 300e3, 180e3  # shear modulus [Pa], far beyond 15 %
PEAKS = {"uniaxial": 5.0, "pure_shear": 4.0, "equibiaxial": 3.2}
PRINCIPAL = {
    "uniaxial": lambda lam: np.array([lam, lam**-0.5, lam**-0.5]),
    "pure_shear": lambda lam: np.array([lam, np.ones_like(lam), 1.0 / lam]),
    "equibiaxial": lambda lam: np.array([lam, lam, lam**-2.0]),
}
STEP = 1e-4


def stress_of(energy, stretch, mode):
    """Nominal stress [Pa]: slope of an energy over G, of principal stretches (3, n)."""
    up, down = (energy(PRINCIPAL[mode](stretch + side * STEP)) for side in (1.0, -1.0))
    directions = 2.0 if mode == "equibiaxial" else 1.0
    return TRUE * (up - down) / (2.0 * STEP * directions)


def neo_hooke(stretches):
    return 0.5 * np.sum(stretches**2, axis=0)


def rubber_set(energy=neo_hooke, samples=60, repeats=2, noise=0.005, scatter=0.005, seed=0):
    """Each mode pulled once to its peak and, unless few, compressed a little before."""
    random, runs = np.random.default_rng(seed), []
    clean = {}
    for mode in MODES:
        stretch = np.linspace(0.9 if samples > 40 else 1.02, PEAKS[mode], samples)
        clean[mode] = stretch, stress_of(energy, stretch, mode)
    level = noise * max(np.abs(stress).max() for _, stress in clean.values())
    for repeat in range(repeats):
        for mode, (stretch, stress) in clean.items():
            shown = stress * (1.0 + scatter * random.standard_normal())
            shown = shown + level * random.standard_normal(samples)
            columns = {"stretch": stretch, "stress": shown}
            runs.append(Run(f"{mode}{repeat}", "sheet", mode, 293.15, columns, mode=mode))
    sheet = Specimen("sheet", {"shear_modulus": STATED})
    return MeasurementSet("rubber", "sheet", {"sheet": sheet}, tuple(runs))
