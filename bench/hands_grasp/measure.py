"""A measured set of a hand that grasps: another engine's hand, with noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bench.hands_grasp.cases import GAUGE, GAUGE_READS, Hidden
from bench.hands_motion.measure import MODULUS_SCALES
from model_lab.bench.hand_grasp_set import grasped, hand_grasp_set
from model_lab.experiments.grasp_rollouts import Engine
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.measurements.units import unit_of

NOISE = {"N": 0.02, "N m": 0.002, "Pa": 200.0, "m": 5e-4}  # one sigma of a sample


def measured(
    hidden: Hidden,
    engine: Engine,
    random: np.random.Generator,
    empty: MeasurementSet | None = None,
) -> MeasurementSet:
    """A planned set, that of the lab if None, as a hand of an engine grasps, with noise."""
    empty = empty or hand_grasp_set(random)
    scale = float(random.uniform(*MODULUS_SCALES))
    true = grasped(empty, scale, hidden.effects, engine)
    wrong = empty.pressures[random.integers(len(empty.pressures))]
    runs = []
    for number, run in enumerate(empty.runs):
        columns = dict(run.columns)
        parts = empty.table.of_run(true, number) / empty.output_scales[:, None]
        for name, values in zip(empty.outputs, parts, strict=True):
            gain = GAUGE_READS if hidden.name == GAUGE and name == wrong else 1.0
            noise = NOISE[unit_of(name) or ""] * random.standard_normal(run.samples)
            columns[name] = gain * values + noise
        runs.append(replace(run, columns=columns))
    return replace(empty, title="simulated hand", runs=tuple(runs))
