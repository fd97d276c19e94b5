"""What a diagnosis says of a series in which something happened, and what of the rest."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bench import rig_faults as rig
from bench.second_author import series_faults
from model_lab.bench.synthesize import synthesize
from model_lab.comparison.compare import compare
from model_lab.diagnosis.diagnose import diagnose
from model_lab.experiments.forward import Forward
from model_lab.measurements.load import load_measurements
from model_lab.measurements.measurement_set import MeasurementSet, Run, Specimen
from model_lab.report.sentences import verdict_sentence
from softhand_model.effects import effect_classes
from softhand_model.model_file import Model

EXAMPLE = Path(__file__).parents[3] / "examples" / "measurements" / "finger"
SEVENTH = 6  # index of the first run of the second half
SECTION = {
    name: effect_classes()[name]
    for name in ("ageing", "section_rounding", "thick_wall", "gent_stiffening", "dead_zone")
}
SOFTENING = {"mullins_softening": effect_classes()["mullins_softening"]}
FEW = ("mullins_softening", "ageing", "gent_stiffening", "viscoelasticity")


@pytest.fixture(scope="module")
def classes():
    return {name: effect for name, effect in effect_classes().items() if name in FEW}


@pytest.fixture(scope="module")
def clean():
    return synthesize("uniaxial", 2, False).data


def test_a_slipped_winding_is_not_noise(clean, classes):
    data = rig.slipped_winding(clean, SEVENTH, 0.09)
    found = diagnose(data, Model("pneuflex"), classes).diagnosis
    assert (found.verdict, found.verdict_mended) == ("unexplained", "adequate")
    assert [(event["kind"], event["run"]) for event in found.events] == [("step", "r1b")]
    assert found.noise_floor < 1.5 * clean.noise["stress"]
    assert "Repeats before and after run r1b do not agree" in verdict_sentence(found)


def test_an_odd_run_is_told_with_the_unit_in_which_it_fits(classes):
    clean = synthesize("free_bending", 2, False).data
    data = rig.run_in_other_unit(clean, 4, 1.0 / 6.894757, "pressure")
    found = diagnose(data, Model("pneuflex"), classes).diagnosis
    assert (found.verdict, found.verdict_mended) == ("slip", "adequate")
    (slip,) = found.slips
    assert (slip.name, slip.column, slip.fits) == ("odd_run", data.runs[4].name, "pressure in psi")
    assert slip.rmse_after < 0.1 * slip.rmse_before


def test_repeats_that_differ_as_readings_do_are_no_noise():
    """Two protocols, twice each, and one run in radians: too few to name it, but not adequate."""
    every = load_measurements(EXAMPLE)
    thin = replace(every, runs=every.runs[:4], noise={})
    assert len({run.specimen for run in thin.runs}) == 1
    assert diagnose(thin, Model("pneuflex")).diagnosis.verdict == "adequate"
    odd = thin.runs[1]
    told = {**odd.columns, "tip_angle": np.radians(odd.columns["tip_angle"])}
    runs = (thin.runs[0], replace(odd, columns=told), *thin.runs[2:])
    found = diagnose(replace(thin, runs=runs), Model("pneuflex")).diagnosis
    assert found.rmse_before < 1.2 * found.noise_floor
    assert (found.verdict, found.unexplained.against[0]) == ("unexplained", "run_order")
    assert found.guess


def test_exchanged_outputs_are_named_and_the_rest_is_diagnosed(clean, classes):
    data = rig.exchanged_plugs(clean, 1, 2)
    found = diagnose(data, Model("pneuflex"), classes).diagnosis
    (event,) = found.events
    assert (found.verdict, event["kind"]) == ("slip", "exchanged")
    assert {event["run"], event["other"]} == {data.runs[1].name, data.runs[2].name}
    assert found.verdict_mended == "adequate"


def test_an_effect_with_memory_wins_over_an_event(classes):
    """The first run of a strip that softens is unlike its repeat."""
    made = synthesize("uniaxial", 2, True, SOFTENING)
    assert [effect["name"] for effect in made.truth["effects"]] == ["mullins_softening"]
    found = diagnose(made.data, Model("pneuflex"), classes).diagnosis
    assert found.verdict == "effects_missing"
    assert [effect.name for effect in found.effects] == ["mullins_softening"]
    assert found.events == ()


def test_a_changed_sensor_is_no_drift_that_fits_less_well(tmp_path):
    truth = series_faults.make(60016, tmp_path)
    found = diagnose(load_measurements(tmp_path), Model("pneuflex")).diagnosis
    assert found.verdict == "unexplained" and "sensor_drift" in effect_classes()
    assert {event["run"] for event in found.events} == set(truth.runs)


def test_a_gentle_drift_within_the_floor_is_not_adequate(classes):
    """Five percent over twelve runs: not sure enough to be told, and the repeats hold it."""
    made = synthesize("free_bending", 402, False)
    assert diagnose(made.data, Model("pneuflex"), classes).diagnosis.verdict == "adequate"
    found = diagnose(rig.drifting_gain(made.data, 0.05), Model("pneuflex"), classes).diagnosis
    assert (found.verdict, found.events) == ("unexplained", ())
    assert found.unexplained.against == ("run_order",)


def tiring(data, grown: float):
    """Rubber whose modulus falls with a power of the number of runs, as the base model bends it."""
    softer = 1.0 + grown * (1.0 - np.arange(1.0, len(data.runs) + 1.0) ** -0.8)
    loaded = tuple(
        replace(run, columns={**run.columns, "pressure": run.columns["pressure"] * factor})
        for run, factor in zip(data.runs, softer, strict=True)
    )
    made = Forward(replace(data, runs=loaded), "pneuflex").predict(np.ones((1, 1)))[0]
    scatter = 0.003 * made.max() * np.random.default_rng(0).standard_normal(len(made))
    runs = tuple(
        replace(run, columns={**run.columns, "tip_angle": data.table.of_run(made + scatter, k)[0]})
        for k, run in enumerate(data.runs)
    )
    return replace(data, runs=runs)


@pytest.mark.parametrize("grown", [0.15, 0.4])
def test_rubber_that_tires_is_not_told_as_an_effect_of_the_section(grown):
    """Outputs are not in proportion to pressures: their scale does not take softer rubber out."""
    data = tiring(synthesize("free_bending", 2, False).data, grown)
    found = diagnose(data, Model("pneuflex"), SECTION).diagnosis
    named = {effect.name for effect in found.effects}
    assert named <= {"ageing"} and (named or found.events) and found.verdict != "adequate"


def test_an_effect_is_named_beside_an_event(classes):
    made = synthesize("uniaxial", 2, True, SOFTENING)
    data = rig.slipped_winding(made.data, SEVENTH, 0.09)
    found = diagnose(data, Model("pneuflex"), classes).diagnosis
    assert found.verdict == "effects_missing"
    assert [effect.name for effect in found.effects] == ["mullins_softening"]
    assert [(event["kind"], event["run"]) for event in found.events] == [("step", "r1b")]


@pytest.mark.parametrize(("scatter", "sure"), [(0.01, True), (0.1, False)])
def test_no_number_says_how_sure_a_verdict_is_where_repeats_lie_far_apart(
    clean, classes, scatter, sure
):
    """Random gains of the runs: far more than the noise within each may hide anything."""
    gains = 1.0 + scatter * np.random.default_rng(3).standard_normal(len(clean.runs))
    runs = tuple(
        replace(run, columns={**run.columns, "stress": gain * run.columns["stress"]})
        for run, gain in zip(clean.runs, gains, strict=True)
    )
    found = diagnose(replace(clean, runs=runs), Model("pneuflex"), classes).diagnosis
    assert found.verdict == "adequate" and (found.confidence is not None) == sure
    assert ("see which runs differ" in verdict_sentence(found)) != sure


@pytest.mark.parametrize("experiment", ["uniaxial", "free_bending"])
def test_a_step_shows_beside_an_effect_that_is_far_larger(experiment, classes):
    """Taking it out may raise the error of a model that fails anyway."""
    gent = {"gent_stiffening": effect_classes()["gent_stiffening"]}
    made = synthesize(experiment, 5, True, gent)
    data = rig.slipped_winding(made.data, SEVENTH, -0.08)
    found = diagnose(data, Model("pneuflex"), classes).diagnosis
    assert [effect.name for effect in found.effects] == ["gent_stiffening"]
    assert [(one["kind"], one["run"]) for one in found.events] == [("step", "r1b")]


def test_two_odd_runs_are_not_taken_for_a_drift_that_would_make_the_error_larger(classes):
    """Both later repeats of one finger read 8 deg too much, as a drift over its runs would do to
    the differences between repeats."""
    data = load_measurements(EXAMPLE)
    jumped = ("thick_2", "thick_half_2")
    runs = tuple(
        replace(r, columns={**r.columns, "tip_angle": r.columns["tip_angle"] + np.radians(8.0)})
        if r.name in jumped
        else r
        for r in data.runs
    )
    found = diagnose(replace(data, runs=runs), Model("pneuflex"), classes).diagnosis
    told = [event["run"] for event in found.events if event["kind"] in ("step", "drift")]
    assert not told
    assert found.verdict != "adequate"
    as_stated = compare(replace(data, runs=runs), Model("pneuflex")).errors.held_out.rmse
    assert found.rmse_before <= 1.01 * as_stated


def test_a_zero_that_moved_is_no_slip_beside_ageing():
    """From the fifth run of eight on, all pressures read 2.5 kPa more: half the height and width,
    and ageing, would about explain the same.
    """
    random, time = np.random.default_rng(4), np.arange(0.0, 20.0, 0.1)
    sizes = {"length": 0.09, "height": 0.02, "width": 0.02, "wall": 0.0025, "side_wall": 0.0025}
    specimen = Specimen("s", {**sizes, "shear_modulus": 67e3, "mass": 0.035})
    runs = []
    for index in range(8):
        peak = 34e3 if index % 2 else 20e3
        pressure = peak * (1.0 - np.abs(time / 10.0 - 1.0))
        columns = {"time": time, "pressure": pressure, "tip_angle": 0.0 * time}
        runs.append(Run(f"r{index}", "s", f"p{index % 2}", 293.15, columns))
    data = MeasurementSet("free_bending", "", {"s": specimen}, tuple(runs))
    angles = np.split(Forward(data).predict(np.ones((1, 1)))[0], len(runs))
    moved = []
    for index, (run, angle) in enumerate(zip(runs, angles, strict=True)):
        pressure = run.columns["pressure"] + (2500.0 if index > 3 else 0.0)
        noisy = angle * (1.0 + 0.003 * random.standard_normal())
        noisy = noisy + 3.5e-3 * random.standard_normal(len(time))
        columns = {"time": time, "pressure": pressure, "tip_angle": noisy}
        moved.append(replace(run, columns=columns))
    found = diagnose(replace(data, runs=tuple(moved)), Model("pneuflex")).diagnosis
    assert (found.verdict_mended, found.slips) == ("adequate", ())
    assert {event["run"] for event in found.events} == {"r4"}
