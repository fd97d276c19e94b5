"""Some runs of the shipped example in another unit than their repeats."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from model_lab.diagnosis.diagnose import diagnose
from model_lab.diagnosis.result import ADEQUATE, SLIP
from model_lab.measurements.load import load_measurements
from model_lab.slips.units_of_runs import units_of_runs
from softhand_model.model_file import load_model

EXAMPLE = Path(__file__).parents[3] / "examples" / "measurements" / "finger"
SECOND = (1, 3, 5, 7)  # indices of the second repeats
AIR = 101.3e3  # [Pa]


@pytest.fixture
def finger():
    return load_measurements(EXAMPLE)


def changed(data, column, change, runs=SECOND):
    """The set with a column of some runs, given by index, as `change` makes it."""
    every = list(data.runs)
    for index in runs:
        run = every[index]
        parts = [
            {**part, column: change(part[column])} if column in part else part
            for part in (run.columns, run.lead)
        ]
        every[index] = replace(run, columns=parts[0], lead=parts[1])
    return replace(data, runs=tuple(every))


@pytest.mark.parametrize(
    ("column", "change", "kind", "fits"),
    [
        ("pressure", lambda p: p / 100.0, "unit", "bar"),
        ("pressure", lambda p: p / 6.895, "unit", "psi"),
        ("pressure", lambda p: p + AIR, "absolute", "absolute pressure"),
        ("tip_angle", lambda angle: np.deg2rad(angle), "unit", "rad"),
        ("tip_angle", lambda angle: -angle, "sign", "minus tip_angle"),
    ],
)
def test_repeats_show_what_was_changed_between_them(finger, column, change, kind, fits):
    (found,) = units_of_runs(changed(finger, column, change))
    assert (found.name, found.fits) == (kind, fits)
    assert found.column.startswith(f"{column} of thin_2")
    for mended, right in zip(found.mended.runs, finger.runs, strict=True):
        np.testing.assert_allclose(
            mended.columns[column], right.columns[column], rtol=1e-3, atol=0.01 * AIR
        )


@pytest.mark.parametrize("runs", [(), (1,), range(8), (0, 1)])
def test_a_whole_set_one_run_and_one_protocol_show_nothing(finger, runs):
    """One run alone is an odd one, and runs without other repeats may be what they seem."""
    assert not list(units_of_runs(changed(finger, "tip_angle", np.deg2rad, runs)))


def test_the_rest_is_diagnosed_without_it(finger):
    data = changed(finger, "pressure", lambda p: p / 100.0)
    found = diagnose(data, load_model("base")).diagnosis
    assert found.verdict == SLIP and found.slips[0].fits == "bar"
    assert found.verdict_mended == ADEQUATE
