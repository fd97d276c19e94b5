"""CSV files of the index finger of RBO Hand 2, measured with an effect that is known."""

import numpy as np
from bending_set import bending_set

from model_lab.experiments.forward import Forward
from model_lab.importing.geometry import finger_of_hand
from model_lab.measurements.measurement_set import MeasurementSet, Specimen

HAND, PEAK, DURATION, SAMPLES, NOISE = "rbo_hand_2:index", 70e3, 24.0, 120, 0.2  # Pa, s, -, deg


def finger_csvs(effect, seed=0):
    """Texts of two CSV files by name: a ramp, measured twice."""
    _, entry = finger_of_hand(HAND, ())
    runs = bending_set(samples=SAMPLES, protocols=1, peak=PEAK).runs
    specimens = {run.specimen: Specimen(run.specimen, entry) for run in runs}
    empty = MeasurementSet("free_bending", "finger", specimens, runs)
    forward = Forward(empty, "pneuflex", (), (effect,))
    true = forward.predict(np.ones((1, len(forward.parameters))))[0]
    random = np.random.default_rng(seed)
    texts = {}
    for number, (run, angle) in enumerate(zip(runs, np.split(true, len(runs)), strict=True), 1):
        measured = np.degrees(angle) + NOISE * random.standard_normal(len(angle))
        columns = (run.columns["time"], 1e-3 * run.columns["pressure"], measured)
        rows = [",".join(f"{value:.4f}" for value in row) for row in zip(*columns, strict=True)]
        texts[f"ramp_{number}.csv"] = "\n".join(["time [s],pressure [kPa],angle [deg]", *rows])
    return texts
