"""Readings of an odd run."""

from dataclasses import replace

import numpy as np
from rubber_set import rubber_set

from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.measurements.rows import require_possible
from model_lab.series.events import ODD_RUN, Event
from model_lab.series.odd_run import odd_run_slips


def uniaxial_with(factor):
    """Three repeats of one pull; the stress of the last is `factor` times as large."""
    whole = rubber_set(samples=20, repeats=3, noise=1e-4, scatter=1e-4)
    runs = [run for run in whole.runs if run.mode == "uniaxial"]
    columns = {**runs[2].columns, "stress": factor * runs[2].columns["stress"]}
    runs[2] = replace(runs[2], columns=columns)
    return MeasurementSet("rubber", "sheet", whole.specimens, tuple(runs))


def slips_of(data):
    """Slips of the last run, for a model that is right for the others."""
    tried = []

    def residual(read):
        require_possible(read)  # as every model of rubber does
        tried.append(read)
        first = data.runs[0].columns["stress"]
        return np.concatenate([run.columns["stress"] - first for run in read.runs])

    event = Event(ODD_RUN, data.runs[2].name, data.runs[1].name, "scale", 0.0, 1e-6, np.zeros(3))
    _, slips = odd_run_slips(data, (event,), residual, 500.0)
    return slips, tried


def test_a_run_in_another_unit_is_read_so_and_impossible_stretches_are_not_tried():
    [slip], tried = slips_of(uniaxial_with(1e-3))
    assert (slip.said, slip.fits) == ("stress in kPa", "stress in MPa")
    assert len(tried) > 2


def test_a_run_that_nothing_explains_is_left_out():
    [slip], _ = slips_of(uniaxial_with(1.37))
    assert "leave out" in slip.mend
