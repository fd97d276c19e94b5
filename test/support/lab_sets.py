"""Measurement sets for tests of the lab's forward model; measured columns are zero."""

import numpy as np

from model_lab.measurements.measurement_set import OUTPUTS, MeasurementSet, Run, Specimen

SIZE = {
    "length": 0.09,
    "height": 0.02,
    "width": 0.02,
    "wall": 0.0025,
    "side_wall": 0.0025,
    "shear_modulus": 67e3,
    "mass": 0.035,
}


def specimen(name="d2.5", mount="bending_plane_level", batch="A", **sizes):
    return Specimen(name, {**SIZE, **sizes}, mount, batch)


def run(name, time=None, of="d2.5", temperature=293.15, virgin=False, steady=False, **columns):
    if time is not None:
        columns["time"] = np.asarray(time, float)
    return Run(name, of, name, temperature, columns, virgin, steady)


def measured(experiment, runs, *specimens):
    """The set, with zeros for what its runs would have measured."""
    whole = []
    for one in runs:
        zeros = {name: np.zeros(one.samples) for name in OUTPUTS[experiment]}
        whole.append(
            Run(
                one.name,
                one.specimen,
                one.protocol,
                one.temperature,
                {**zeros, **one.columns},
                one.virgin,
                one.steady,
            )
        )
    specimens = specimens or (specimen(),)
    return MeasurementSet(experiment, "", {one.name: one for one in specimens}, tuple(whole))


def bending(*pressures, time=None, **options):
    """A set of free bending of one specimen, a run for each trace of pressure."""
    runs = [run(f"r{index}", time, pressure=p, **options) for index, p in enumerate(pressures)]
    return measured("free_bending", runs)
