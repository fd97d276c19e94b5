"""Sensors whose zero or scale is off are named among all effects; the readings are changed here."""

from dataclasses import replace

import pytest

from model_lab.bench.synthesize import synthesize
from model_lab.diagnosis.diagnose import diagnose
from softhand_model.model_file import Model

CHANGES = {
    "angle_gain": ("free_bending", "tip_angle", lambda angle: 0.85 * angle, ("gain", 0.85)),
    "stress_offset": ("uniaxial", "stress", lambda stress: stress + 6e3, ("offset", 6e3)),
    "stretch_offset": ("uniaxial", "stretch", lambda stretch: stretch + 0.04, ("offset", 0.04)),
}


@pytest.mark.parametrize("name", CHANGES)
def test_a_sensor_that_is_off_is_named_with_its_zero_or_scale(name):
    experiment, column, change, (parameter, truth) = CHANGES[name]
    clean = synthesize(experiment, 2, False).data
    assert diagnose(clean, Model("pneuflex")).diagnosis.verdict == "adequate"
    runs = (
        replace(run, columns={**run.columns, column: change(run.columns[column])})
        for run in clean.runs
    )
    found = diagnose(replace(clean, runs=tuple(runs)), Model("pneuflex")).diagnosis
    assert found.verdict == "effects_missing"
    assert [effect.name for effect in found.effects] == [name]
    assert found.effects[0].parameters[parameter].value == pytest.approx(truth, rel=0.1)
