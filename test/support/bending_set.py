"""Small sets of free bending with effects of one's choice, for what comes after the diagnosis."""

from dataclasses import replace

import numpy as np

from model_lab.bench.protocols import PROTOCOLS
from model_lab.experiments.forward import Forward
from model_lab.measurements.measurement_set import MeasurementSet, Run, Specimen

SHAPE = {"length": 0.09, "height": 0.02, "width": 0.02, "side_wall": 0.0025, "shear_modulus": 67e3}


def bending_set(effects=(), samples=60, protocols=4, noise=0.01, seed=0, repeats=2, peak=45e3):
    """Repeats of so many protocols on two walls, with noise over the largest angle."""
    random = np.random.default_rng(seed)
    specimens = {
        name: Specimen(name, {**SHAPE, "wall": wall}, batch="A")
        for name, wall in (("thin", 0.0025), ("thick", 0.004))
    }
    runs = []
    for index in range(repeats * protocols):
        course = PROTOCOLS[index % protocols % len(PROTOCOLS)]
        time, pressure = course.course(24.0, peak, samples)
        columns = {"time": time, "pressure": pressure, "tip_angle": np.zeros(samples)}
        specimen = ("thin", "thick")[index % protocols % 2]
        name = f"p{index % protocols}"
        runs.append(Run(f"r{index}", specimen, name, 293.15, columns))
    empty = MeasurementSet("free_bending", "small & <quick>", specimens, tuple(runs))
    forward = Forward(empty, "pneuflex", (), tuple(effects))
    true = forward.predict(np.ones((1, len(forward.parameters))))[0]
    spread = noise * np.abs(true).max()
    parts = np.split(true, len(runs))
    return replace(
        empty,
        runs=tuple(
            replace(run, columns={**run.columns, "tip_angle": _noisy(part, spread, random)})
            for run, part in zip(runs, parts, strict=True)
        ),
    )


def _noisy(part, spread, random):
    whole = 1.0 + 0.004 * random.standard_normal()
    return part * whole + spread * random.standard_normal(len(part))
