"""What is told of a set before the search."""

from __future__ import annotations

import numpy as np
import pytest

from bench.hidden import make_set
from model_lab.diagnosis.diagnose import diagnose
from model_lab.measurements.load import load_measurements
from model_lab.measurements.units import Display
from model_lab.report.first_look_text import FIRST_LOOK, first_look_line
from softhand_model.effects import effect_classes
from softhand_model.model_file import load_model

TRIED = ("tube_lag", "pressure_offset", "gent_stiffening", "ageing", "gravity")


def looked(folder, hidden, **options):
    """The first looks that are told while a set is diagnosed, and the diagnosis."""
    make_set(folder, "free_bending", hidden, seed=5, noise=0.006, **options)
    told, classes = [], effect_classes()
    outcome = diagnose(
        load_measurements(folder),
        load_model("base"),
        {name: classes[name] for name in TRIED},
        tell_first=told.append,
    )
    return told, outcome.diagnosis


@pytest.mark.parametrize("law", ["tube_lag", "pressure_offset"])
def test_the_first_look_has_what_is_hidden_among_the_likeliest(law, tmp_path):
    told, diagnosis = looked(tmp_path, [(law, {})], ratio=6.0)
    (first,) = told
    assert law in [name for name, _ in first.likeliest]
    assert first.rmse == pytest.approx(diagnosis.rmse_before, rel=0.3)
    assert not first.is_noise
    line = first_look_line(first, Display("deg", 180.0 / np.pi))
    assert line.startswith(FIRST_LOOK)
    assert law in line


def test_of_noise_nothing_stands_out(tmp_path):
    told, diagnosis = looked(tmp_path, [])
    assert diagnosis.verdict == "adequate"
    assert told[0].is_noise
    assert "nothing stands out" in first_look_line(told[0], Display("rad"))
