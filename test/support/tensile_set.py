"""Tensile tests of an ideal rubber bar: nominal stress G*(lambda - lambda**-2), and deviations."""

import numpy as np

from model_lab.measurements.measurement_set import MeasurementSet, Run, Specimen

MODULUS = 50e3
SAMPLES = 120


def tensile_set(
    scale=1.0, noise=200.0, scatter=0.0, error=lambda stretch, run: 0.0 * stretch, seed=0,
    protocols=4, repeats=2, specimens=("bar",), samples=SAMPLES,
):  # fmt: skip
    """A set of pulls to different stretches; error: stress [Pa] of (stretch, index of the run)."""
    random = np.random.default_rng(seed)
    runs = []
    for index in range(protocols * repeats):
        time = np.linspace(0.0, 10.0, samples)
        stretch = 1.0 + (0.6 + 0.2 * (index // repeats)) * np.sin(0.1 * np.pi * time)
        stress = scale * MODULUS * (stretch - stretch**-2) * (1 + scatter * random.normal())
        stress = stress + error(stretch, index) + noise * random.standard_normal(samples)
        columns = {"time": time, "stretch": stretch, "stress": stress}
        name = specimens[index % len(specimens)]
        runs.append(Run(f"r{index}", name, f"p{index // repeats}", 293.15, columns))
    known = {name: Specimen(name, {"shear_modulus": MODULUS}, batch="A") for name in specimens}
    return MeasurementSet("uniaxial", "pulls", known, tuple(runs))
