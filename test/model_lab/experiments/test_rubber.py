"""Stress of rubber in three modes, and what a test of it teaches the finger."""

import json
from dataclasses import replace

import numpy as np
import pytest
from lab_sets import bending, measured, run, specimen
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


def yeoh(stretches, c2=0.06):
    """Two terms of Yeoh, over twice the first coefficient."""
    j1 = np.sum(stretches**2, axis=0) - 3.0
    return 0.5 * (j1 + c2 * j1**2)


@pytest.mark.parametrize(("energy", "law"), [(chains, "arruda_boyce"), (yeoh, "yeoh_stiffening")])
def test_a_finer_law_is_named_where_the_plain_one_needs_another_effect(energy, law):
    """With Gent and an offset of the stress nothing is left that asks for a finer law than his."""
    found = diagnose(rubber_set(energy, samples=16, repeats=1), load_model("base")).diagnosis
    assert found.rmse_after < 1.12 * found.noise_floor
    assert [effect.name for effect in found.effects] == [law]
    assert "arruda_boyce" not in found.tied[0]


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


def test_laws_that_one_mode_does_not_part_are_to_be_tried_in_another():
    """Gent's and Yeoh's laws agree in uniaxial tension up to a stretch of 3."""
    pulls = [one for one in rubber_set(chains, scatter=0.01).runs if one.mode == "uniaxial"]
    parts = [one.columns["stretch"] < 3.0 for one in pulls]
    runs = tuple(
        replace(one, columns={name: values[part] for name, values in one.columns.items()})
        for one, part in zip(pulls, parts, strict=True)
    )
    found = diagnose(replace(rubber_set(), runs=runs), load_model("base")).diagnosis
    assert {found.effects[0].name, *found.tied[0]} >= {"gent_stiffening", "yeoh_stiffening"}
    planned = found.next_experiment
    assert planned["mode"] == "equibiaxial"
    assert planned["changes"] == ["stretched in equibiaxial"]


def test_a_law_sealed_in_a_rubber_set_is_found_added_and_revealed(tmp_path, capsys):
    folder, model = str(tmp_path / "set"), str(tmp_path / "model.yaml")
    assert main(["synthesize", "rubber", "--hide", "--seed", "3", "--out", folder]) == 0
    out = tmp_path / "d.json"
    assert main(["diagnose", folder, "--jobs", "1", "--json", str(out)]) == 0
    said = json.loads(out.read_text())
    (named,) = said["effects"]
    assert main(["add", named["name"], "--data", folder, "--out", model]) == 0
    assert main(["compare", folder, "--model", model, "--json", str(tmp_path / "c.json")]) == 0
    error = json.loads((tmp_path / "c.json").read_text())["rmse_heldout"]
    assert error < 1.3 * said["noise_floor"] < 0.3 * said["rmse_before"]
    capsys.readouterr()
    assert main(["reveal", folder]) == 0
    assert named["name"] in capsys.readouterr().out


def test_the_file_of_a_tested_rubber_acts_alike_in_bending_and_simulator(tmp_path):
    folder, file = tmp_path / "set", tmp_path / "rubber.yaml"
    write_set(rubber_set(chains), folder)
    assert main(["add", "gent_stiffening", "--data", str(folder), "--out", str(file)]) == 0
    model, chain = load_model(file), load_hand("single_finger").chain("finger")
    simulated = discretise(chain, 60, model).free_rotation(0.0, [30e3]).sum(axis=0)[1]
    actuator = next(iter(chain.actuators.values()))
    sizes = {name: float(getattr(actuator, name)(0.0)) for name in ("wall", "side_wall")}
    sizes["length"] = actuator.length
    at = np.linspace(0.0, actuator.length, 41)
    for name in ("height", "width"):
        profile = getattr(actuator, name)
        sizes[name] = np.stack([at, [float(profile(x)) for x in at]], axis=1).tolist()
    finger = specimen(shear_modulus=actuator.shear_modulus, **sizes)
    data = made_of(
        measured("free_bending", [run("r", pressure=np.array([0.0, 30e3]))], finger), model
    )
    forward = Forward(data, fixed=model.effects, free_calibration=False)
    assert simulated == pytest.approx(forward.predict(np.zeros((1, 0)))[0, -1], rel=0.02)


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
