"""Fingers of one batch that differ: what a diagnosis says of them."""

from dataclasses import replace

import numpy as np
import pytest
import yaml

from model_lab.bench.synthesize import synthesize
from model_lab.diagnosis.diagnose import diagnose
from model_lab.experiments.forward import Forward
from model_lab.report.sentences import verdict_sentence
from softhand_model.effects import effect_classes
from softhand_model.model_file import Model

FEW = ("gent_stiffening", "thick_wall", "angle_offset", "sensor_drift")
STIFFER = 1.06  # the thick finger than stated


@pytest.fixture(scope="module")
def classes():
    return {name: effect_classes()[name] for name in FEW}


@pytest.fixture(scope="module")
def clean():
    """A set of a thin and a thick finger of one batch, each mounted in two ways; nothing hidden."""
    return synthesize("free_bending", 2, False).data


def readings(data, change):
    """The set with tip angles that `change` makes of each run and its angles."""
    runs = tuple(
        replace(run, columns={**run.columns, "tip_angle": change(run, run.columns["tip_angle"])})
        for run in data.runs
    )
    return replace(data, runs=runs)


def stiffened(data, factor, *effects, key="shear_modulus"):
    """The set of thick fingers that are stiffer by a factor than stated, or have another entry,
    with effects besides; the noise is that of the set.
    """
    thick = {name: one for name, one in data.specimens.items() if name.startswith("thick")}
    other = {
        name: replace(one, values={**one.values, key: factor * one.values[key]})
        for name, one in thick.items()
    }
    true = replace(data, specimens={**data.specimens, **other})
    more = predicted(true, effects) - predicted(data, ())
    starts = np.cumsum([run.samples for run in data.runs])[:-1]
    of_runs = dict(zip((run.name for run in data.runs), np.split(more, starts), strict=True))
    return readings(data, lambda run, angle: angle + of_runs[run.name])


def predicted(data, effects):
    forward = Forward(data, "pneuflex", (), effects, {})
    return forward.predict(forward.start()[None])[0]


def test_fingers_of_a_batch_that_differ_are_told_with_their_moduli(clean, classes):
    found = diagnose(stiffened(clean, STIFFER), Model("pneuflex"), classes).diagnosis
    assert (found.verdict, found.verdict_mended) == ("slip", "adequate")
    (slip,) = found.slips
    assert slip.name == "batch"
    scales = found.calibration["modulus_scale"]
    assert set(scales) == {"thin", "thick_base_up"}  # the first of each that has runs
    assert scales["thick_base_up"] / scales["thin"] == pytest.approx(STIFFER, abs=0.02)
    assert "thick: {batch: thick_base_up}" in slip.mend
    assert slip.rmse_after < 0.6 * slip.rmse_before
    assert verdict_sentence(found).startswith("The specimens of a batch differ: the data fit if")


def test_castings_that_hardly_differ_are_a_remark_where_no_batch_is_stated(clean, classes):
    data = stiffened(clean, 1.03)
    unstated = {name: replace(one, batch="all") for name, one in data.specimens.items()}
    found = diagnose(replace(data, specimens=unstated), Model("pneuflex"), classes).diagnosis
    assert (found.verdict, found.slips) == ("adequate", ())
    (notice,) = [one for one in found.notices if one["kind"] == "castings"]
    scales = found.calibration["modulus_scale"]
    assert notice["value"] == pytest.approx(scales["thick_base_up"] / scales["thin"] - 1.0)
    assert "castings differ, as usual: their moduli are thin" in notice["text"]


def test_fingers_that_differ_by_more_than_usual_are_told_with_a_free_modulus(clean, classes):
    data = stiffened(clean, 1.4)
    found = diagnose(data, Model("pneuflex"), classes).diagnosis
    assert (found.verdict, found.slips) == ("unexplained", ())
    assert "--free-modulus tries one for each" in verdict_sentence(found)
    free = diagnose(replace(data, free_modulus=True), Model("pneuflex"), classes).diagnosis
    assert (free.verdict, free.verdict_mended) == ("slip", "adequate")
    assert "--free-modulus" not in verdict_sentence(free)


def test_a_finger_that_is_longer_than_stated_is_told_with_its_length(clean, classes):
    stated = clean.specimens["thick"].values["length"]
    found = diagnose(stiffened(clean, 1.3, key="length"), Model("pneuflex"), classes).diagnosis
    assert (found.verdict, found.verdict_mended) == ("slip", "adequate")
    (slip,) = found.slips
    assert slip.name == "size" and slip.column.startswith("the length of thick")
    mend = yaml.safe_load(slip.mend)["specimens"]
    assert {name.split("_")[0] for name in mend} == {"thick"}
    assert mend["thick"]["length"] == pytest.approx(1.3 * stated, rel=0.03)
    assert slip.rmse_after < 0.3 * slip.rmse_before


def test_an_effect_is_named_beside_fingers_that_differ(clean, classes):
    data = stiffened(clean, 1.12, classes["gent_stiffening"](jm=4.0))
    found = diagnose(data, Model("pneuflex"), classes).diagnosis
    assert (found.verdict, found.verdict_mended) == ("slip", "effects_missing")
    assert [slip.name for slip in found.slips] == ["batch"]
    assert [effect.name for effect in found.effects] == ["gent_stiffening"]


def test_a_finger_with_another_curve_stays_unexplained(clean, classes):
    def bent(run, angle):
        return angle + 0.15 * np.sin(6.0 * angle) * run.specimen.startswith("thick")

    found = diagnose(readings(clean, bent), Model("pneuflex"), classes).diagnosis
    assert (found.verdict, found.slips) == ("unexplained", ())


def test_fingers_alike_are_not_parted(clean, classes):
    found = diagnose(clean, Model("pneuflex"), classes).diagnosis
    assert (found.verdict, found.slips) == ("adequate", ())
