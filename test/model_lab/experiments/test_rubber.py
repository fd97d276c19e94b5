"""Stress of rubber in three modes, and what a test of it teaches the finger."""

from dataclasses import replace

import numpy as np
import pytest
from lab_sets import bending, measured, run
from rubber_set import STATED, TRUE, neo_hooke, rubber_set, stress_of

from model_lab.cli.main import main
from model_lab.comparison.add import add_effect
from model_lab.comparison.compare import compare
from model_lab.diagnosis.diagnose import diagnose
from model_lab.experiments.forward import Forward, not_searched
from model_lab.fitting.smoothing import short_spline_rest
from model_lab.localisation.axes import axes_of
from model_lab.measurements.load import load_measurements
from model_lab.measurements.measurement_set import MODES
from model_lab.measurements.save import write_set
from model_lab.measurements.specimens import made_of
from softhand_model.chain.chain import discretise
from softhand_model.effects import effect_classes
from softhand_model.hand.hand import load_hand
from softhand_model.model_file import Model, load_model

EFFECTS = effect_classes()
POWERS = {"uniaxial": -2.0, "pure_shear": -3.0, "equibiaxial": -5.0}


def inverse_langevin(x):
    """By Newton on coth(b) - 1/b, to machine precision."""
    b = 3.0 * x / (1.0 - x**2)
    for _ in range(60):
        slope = 1.0 / b**2 - 1.0 / np.sinh(np.minimum(b, 300.0)) ** 2
        b = b - (1.0 / np.tanh(b) - 1.0 / b - x) / slope
    return b


def chains(stretches, links=13.0):
    """Eight chains with the exact inverse Langevin function: another form than the lab's laws."""
    share = np.sqrt(np.sum(stretches**2, axis=0) / (3.0 * links))
    b, rest = inverse_langevin(share), np.sqrt(1.0 / links)
    modulus = inverse_langevin(np.array(rest)) / rest / 3.0
    return links * (share * b + np.log(2.0 * b) - b - np.log1p(-np.exp(-2.0 * b))) / modulus


def entangled(stretches):
    """Neo-Hooke beside a logarithm of the second invariant (Gent, Thomas), a quarter of G."""
    second = np.sum(stretches**-2.0, axis=0)
    return 0.75 * neo_hooke(stretches) + 0.25 * 1.5 * np.log(second)


def test_every_mode_has_its_own_stress_and_one_modulus():
    data = rubber_set(noise=0.0, scatter=0.0)
    forward = Forward(data)
    assert forward.predict([[TRUE / STATED]])[0] == pytest.approx(data.table.value, abs=2.0)
    found = forward.predict([[1.0]])[0]
    for index, one in enumerate(data.runs):
        stretch = one.columns["stretch"]
        expected = STATED * (stretch - stretch ** POWERS[one.mode])
        assert data.table.of_run(found, index)[0] == pytest.approx(expected)


def test_modes_are_an_axis_and_none_repeats_another():
    data = rubber_set()
    assert {axis.name for axis in axes_of(data)} >= {"pressure", "mode"}
    assert [sorted(data.runs[i].mode for i in group) for group in data.groups()] == [
        [mode, mode] for mode in MODES
    ]


def test_modes_are_held_out_where_protocols_do_not_differ():
    data = rubber_set(repeats=1)
    data = replace(data, runs=tuple(replace(one, protocol="pull") for one in data.runs))
    assert (data.table.holdout, data.table.folds) == ("modes", MODES)


def test_the_modulus_is_found_far_from_what_is_stated():
    found = diagnose(rubber_set(), load_model("base")).diagnosis
    assert found.verdict == "adequate"
    low, high = found.modulus["all"].interval
    assert low < TRUE < high and high - low < 0.1 * TRUE


@pytest.mark.parametrize(
    ("energy", "family"),
    [
        (chains, {"gent_stiffening", "arruda_boyce", "yeoh_stiffening"}),
        (entangled, {"mooney_rivlin", "second_invariant"}),
    ],
    ids=["limit of the chains", "second invariant"],
)
def test_the_family_of_a_law_of_another_form_is_named(energy, family):
    found = diagnose(rubber_set(energy, scatter=0.02), load_model("base")).diagnosis
    assert found.verdict == "effects_missing"
    assert {found.effects[0].name, *found.tied[0]} & family
    assert found.rmse_after < 0.5 * found.rmse_before


def test_a_few_readings_without_repeats_are_judged_too():
    found = diagnose(rubber_set(chains, samples=16, repeats=1), load_model("base")).diagnosis
    assert found.noise_floor_source == "spline"
    assert found.verdict == "effects_missing"
    assert found.effects[0].name in {"gent_stiffening", "arruda_boyce", "yeoh_stiffening"}


def test_what_a_test_of_rubber_has_taught_acts_in_the_finger():
    """The pure-shear stress of the finger's wall is that of the law, with the law's modulus."""
    data = rubber_set(chains)
    model = add_effect("arruda_boyce", data, load_model("base"), EFFECTS).model
    assert model.shear_modulus(67e3) == pytest.approx(TRUE, rel=0.02)
    finger = made_of(bending(np.array([0.0, 60e3])), model)
    angle = Forward(finger, fixed=model.effects, free_calibration=False).predict(np.zeros((1, 0)))[
        0, -1
    ]
    specimen = finger.specimens["d2.5"].values
    stretch = 1.0 + angle / specimen["length"] * specimen["height"]
    ratio = 2.0 / (1.0 + 0.0175**2 / 0.02**2)
    load = 60e3 * ratio * 0.02 / (4.0 * 0.0025)
    assert stress_of(chains, np.array([stretch]), "pure_shear")[0] == pytest.approx(load, rel=0.02)


def test_the_simulator_takes_the_modulus_of_the_model_file():
    chain = load_hand("single_finger").chain("finger")
    stated = next(iter(chain.actuators.values())).shear_modulus
    bends = [
        discretise(chain, 5, Model(calibration=given)).rest_rotation([20e3]).sum()
        for given in ({"modulus": 2.0 * stated}, {"modulus_scale": 2.0}, {})
    ]
    assert bends[0] == pytest.approx(bends[1])
    assert bends[0] < 0.7 * bends[2]


def test_a_second_effect_starts_from_the_first_as_it_was_fitted(tmp_path):
    data = rubber_set(chains)
    once = add_effect("gent_stiffening", data, load_model("base"), EFFECTS).model
    twice = add_effect("second_invariant", data, once, EFFECTS)
    assert twice.after.fit.deviance <= twice.before.fit.deviance
    assert compare(data, once).errors.calibrated is False


def test_a_law_that_data_do_not_ask_for_is_added_at_its_bound():
    """Of a rubber without second and third terms: c3 is at its lower bound."""
    model = replace(load_model("base"), free_modulus=True)
    added = add_effect("yeoh_third_order", rubber_set(entangled), model, EFFECTS).model
    (third,) = added.effects
    assert third.values["c3"] == pytest.approx(third.parameters[0].low)


def test_a_tensile_test_may_free_its_modulus(tmp_path):
    whole = rubber_set(repeats=1, noise=0.002)
    bare = tuple(replace(one, mode="") for one in whole.runs if one.mode == "uniaxial")
    data = replace(whole, experiment="uniaxial", title="bar", runs=bare)
    folder = tmp_path / "set"
    write_set(data, folder)
    again = load_measurements(folder)
    assert again.free_modulus
    assert diagnose(again, load_model("base")).diagnosis.verdict == "adequate"
    text = (folder / "experiment.yaml").read_text()
    (folder / "experiment.yaml").write_text(text.replace("calibration:\n  modulus: free\n", ""))
    assert not load_measurements(folder).free_modulus
    out = tmp_path / "out.json"
    given = ["compare", str(folder), "--free-modulus", "--model", "base", "--json", str(out)]
    assert main(given) == 0
    freed = tmp_path / "free.yaml"
    freed.write_text("format: softhand-model/1\nbase: pneuflex\ncalibration: {modulus: free}\n")
    assert load_model(freed).free_modulus


def test_a_set_is_written_and_read_back_with_its_modes(tmp_path):
    write_set(rubber_set(repeats=1), tmp_path / "set")
    assert [run.mode for run in load_measurements(tmp_path / "set").runs] == list(MODES)


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ("", "expected the key mode (uniaxial, pure_shear, equibiaxial)"),
        (
            "mode: planar",
            "r1.mode: expected one of uniaxial, pure_shear, equibiaxial, got 'planar'",
        ),
    ],
)
def test_a_mode_that_is_missing_or_unknown_is_told(tmp_path, capsys, given, expected):
    (tmp_path / "r1.csv").write_text("stretch,stress\n1,0\n2,1\n")
    (tmp_path / "experiment.yaml").write_text(
        "format: softhand-measurement/1\nexperiment: rubber\n"
        "specimens: {s: {shear_modulus: 1.0e+5}}\n"
        "columns: {stretch: {unit: ''}, stress: {unit: MPa}}\n"
        f"runs: {{r1: {{specimen: s, {given + ',' if given else ''} file: r1.csv}}}}\n"
    )
    assert main(["compare", str(tmp_path)]) == 2
    told = capsys.readouterr().err
    assert expected in told and told.count("\n") == 1


def test_short_splines_find_the_noise_of_uneven_readings():
    random = np.random.default_rng(3)
    squares, freedom = 0.0, 0.0
    for _ in range(40):
        place = np.sort(random.uniform(1.0, 5.0, 15) ** 1.3)
        part = short_spline_rest(place, np.exp(0.4 * place) + 0.1 * random.standard_normal(15))
        squares, freedom = squares + part[0], freedom + part[1]
    assert np.sqrt(squares / freedom) == pytest.approx(0.1, rel=0.15)


@pytest.mark.parametrize(("back", "searched"), [(False, False), (True, True)])
def test_memory_is_not_sought_in_a_stretch_that_goes_one_way(back, searched):
    way = np.linspace(0.0, 1.0, 100)
    course = 1.0 + 2.0 * (np.minimum(way, 1.0 - way) if back else way)
    data = measured("uniaxial", [run("r", 30.0 * way, of="d2.5", stretch=course)])
    reason = not_searched(EFFECTS["viscoelasticity"], data, "pneuflex")
    assert (reason is None) == searched
