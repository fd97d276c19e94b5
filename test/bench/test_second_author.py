"""The second author's physics against check values and closed forms, its sets against the lab."""

import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from bench.lab.reliability import calibration_error
from bench.second_author import generator, physics, pulses, rig, score, series_faults, slip_sets
from bench.second_author.physics import Finger
from bench.second_author.truth import Truth
from model_lab.cli.main import main

P10 = Finger(0.09, 0.02, 0.02, 0.02, 0.002, 0.002, 73.7e3)
TIME = np.linspace(0, 10, 2001)


def at_end(finger, pressure, **effects):
    return float(physics.tip_angle(finger, effects, TIME, pressure * TIME / 10)[0][-1])


@pytest.mark.parametrize(("modulus", "degrees"), [(73.7e3, 122.2), (67e3, 141.2)])
def test_tip_angle_of_the_thesis_finger(modulus, degrees):
    angle = at_end(replace(P10, modulus=modulus), 31e3)
    assert np.rad2deg(angle) == pytest.approx(degrees, abs=0.1)


def test_ratio_at_a_tenth_of_the_height():
    assert P10.ratio(np.array(0.02)) == pytest.approx(1.105, abs=5e-4)


def test_small_loads_of_a_blocked_tip_do_not_depend_on_the_modulus():
    pressure = 100 * TIME / 10
    for modulus in (50e3, 100e3):
        force = physics.tip_force(replace(P10, modulus=modulus), {}, TIME, pressure)[-1]
        assert force == pytest.approx(0.75 * 100 * 0.02**3 / 0.09, rel=1e-3)


def test_rubber_after_a_step_relaxes_as_the_standard_linear_solid():
    g, tau = 0.4, 1.5
    effects = {"viscoelasticity": {"relative_modulus": g, "relaxation_time": tau}}
    step = np.r_[0.0, np.ones(len(TIME) - 1)][:, None]
    elastic = physics.relaxed(effects, TIME, step)[1:, 0]
    expected = 1 - g / (1 + g) * np.exp(-TIME[1:] / (tau * (1 + g)))
    np.testing.assert_allclose(elastic, expected, atol=2e-3)


def test_friction_takes_its_whole_load_after_a_long_way():
    friction = {"relative_pressure": 0.2, "stretch_scale": 0.02}
    stretch = physics.STRETCHES
    law = stretch - stretch**-3
    lam = physics.with_friction(friction, law, np.linspace(0, 1.5, 500))[-1]
    assert lam - lam**-3 == pytest.approx(1.3, abs=2e-3)


def test_friction_of_the_tip_keeps_its_side_while_the_force_holds():
    force = np.array([0, 1, 1 + 1e-12, 1 - 1e-12, 0.5, 0.5])
    np.testing.assert_array_equal(physics.last_direction(force), [0, 1, 1, 1, -1, -1])


def test_softened_rubber_keeps_the_virgin_curve_and_returns_below_it():
    effects = {"mullins_softening": {"softening": 0.3, "stretch_scale": 0.2}}
    stretch = physics.STRETCHES
    law = stretch - stretch**-3
    load = np.r_[np.linspace(0, 1, 50), np.linspace(1, 0, 50)]
    lam, largest = physics.softened(effects, law, load, 1.0)
    np.testing.assert_allclose(lam[:50] - lam[:50] ** -3, load[:50], atol=1e-5)
    assert largest == lam[49]
    back = (lam - lam**-3) * (1 - 0.3 * (1 - np.exp(-(largest - lam) / 0.2)))
    np.testing.assert_allclose(back[50:], load[50:], atol=1e-5)


def test_weight_straightens_a_hanging_finger_and_bends_a_standing_one():
    hanging = at_end(replace(P10, mount="base_up"), 20e3, gravity={"mass_scale": 1.0})
    standing = at_end(replace(P10, mount="base_down"), 20e3, gravity={"mass_scale": 1.0})
    assert hanging < at_end(P10, 20e3) < standing


def test_weight_at_the_base_is_that_of_a_straight_bar_across():
    # the finger bent by 90 deg at once at its base, then straight: m*g*L/2 at the base
    count = 400
    kappa = np.zeros((1, count))
    kappa[0, 0] = np.pi / 2 * count / P10.length
    hanging = replace(P10, mount="base_up")
    moment = physics.weight_moment(hanging, {"mass_scale": 1.0}, kappa)[0, 0]
    assert moment == pytest.approx(P10.mass * 9.81 * P10.length / 2, rel=0.01)


def test_flow_function_is_choked_at_0484():
    assert pulses.flow_function(np.array(0.3)) == pytest.approx(0.484, abs=5e-4)


@pytest.mark.parametrize("experiment", ["free_bending", "blocked_tip", "uniaxial"])
def test_the_error_of_a_set_with_nothing_hidden_is_its_noise(tmp_path, experiment):
    rng = np.random.default_rng(0)
    clean = rig.new_rig(rng, experiment, specimens=1, protocols=2, repeats=3)
    rig.record(clean, rng)
    rig.write(clean, tmp_path / "set")
    assert main(["compare", str(tmp_path / "set"), "--json", str(tmp_path / "c.json")]) == 0
    found = json.loads((tmp_path / "c.json").read_text())
    assert found["rmse"] == pytest.approx(rig.floor(clean), rel=0.25)


def test_pulses_with_nothing_hidden_fit_the_naive_flow(tmp_path):
    pulses.make(np.random.default_rng(0), tmp_path / "set", hidden=False)
    assert main(["compare", str(tmp_path / "set"), "--json", str(tmp_path / "c.json")]) == 0
    found = json.loads((tmp_path / "c.json").read_text())
    assert found["fit_percent"] > 98


def test_a_hidden_effect_shows(tmp_path):
    rng = np.random.default_rng(1)
    hidden, truth = generator.with_hidden(
        rng, "free_bending", "effect", specimens=1, protocols=2, repeats=2
    )
    rig.record(hidden, rng)
    rig.write(hidden, tmp_path / "set")
    assert main(["compare", str(tmp_path / "set"), "--json", str(tmp_path / "c.json")]) == 0
    found = json.loads((tmp_path / "c.json").read_text())
    assert found["rmse"] > 2.5 * rig.floor(hidden)
    assert truth.values.keys() == hidden.effects.keys()


def test_a_seed_gives_the_same_set(tmp_path):
    for folder in ("a", "b"):
        slip_sets.make(1, tmp_path / folder)
    names = sorted(path.name for path in (tmp_path / "a").iterdir())
    for name in names:
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


def test_eighty_seeds_of_a_series_hold_sixty_faults():
    faults = [series_faults.fault_of(seed) for seed in range(100, 180)]
    assert faults.count("none") == 20
    assert {faults.count(fault) for fault in series_faults.FAULTS} == {12}


def test_forty_five_seeds_of_slips_hold_each_with_and_without_an_effect():
    plans = [slip_sets.slip_of(seed) for seed in range(90, 135)]
    assert sum(not name for name, _ in plans) == 15
    for name in slip_sets.SLIPS:
        assert sorted(effect for slip, effect in plans if slip == name) == [False, True]


def test_what_is_wrapped_jumps(tmp_path):
    """Also where the hidden effect keeps angles small: such a set has nothing to wrap."""
    assert slip_sets.slip_of(940) == ("wrapped", True)
    slip_sets.make(940, tmp_path)
    angle = pd.read_csv(tmp_path / "run01.csv")["tip_angle"]  # [deg]
    assert angle.diff().abs().max() > 180.0


def columns(experiment, slip, column):
    """A column of every run before and after a slip, and the truth of it."""
    rng = np.random.default_rng(2)
    clean = rig.new_rig(rng, experiment, specimens=1, protocols=2, repeats=3)
    rig.record(clean, rng)
    before = [run.data[column].to_numpy() for run in clean.runs]
    truth = slip(rng, clean)
    return before, [run.data[column].to_numpy() for run in clean.runs], truth, clean


def test_a_slip_rewrites_its_column_of_every_run():
    before, after, _, _ = columns("uniaxial", slip_sets.SLIPS["strain"][1], "stretch")
    for one, other in zip(before, after, strict=True):
        np.testing.assert_allclose(other, one - 1)


def test_a_slip_of_the_modulus_changes_what_the_file_says_alone():
    before, after, _, made = columns("uniaxial", slip_sets.youngs_modulus, "stress")
    np.testing.assert_array_equal(np.concatenate(after), np.concatenate(before))
    (stated,) = made.stated.values()
    assert 2.6 < stated["shear_modulus"] / made.true["s0"].modulus < 3.4


def test_an_event_changes_the_angles_from_its_run_on():
    def day(make):
        rng = np.random.default_rng(5)
        made = rig.new_rig(rng, "free_bending", specimens=1, protocols=1, repeats=9)
        made.noise = rig.Noise(0, 0, 0, 0, 0, 0)
        return make(rng, made), [float(run.data["tip_angle"].max()) for run in made.runs]

    truth, peaks = day(series_faults.event)
    _, undisturbed = day(series_faults.recorded)
    growth = np.array(peaks) / undisturbed
    first = int(truth.runs[0].removeprefix("run")) - 1
    np.testing.assert_allclose(growth[:first], 1)
    assert (growth[first:] > 1.04).all()


GENT = Truth("gent_stiffening", (frozenset({"gent_stiffening"}),), {"gent_stiffening": {"jm": 5.0}})


def answer(verdict, *effects, **more):
    named = [{"name": name, "parameters": {"jm": {"interval": [4.0, 6.0]}}} for name in effects]
    return {"verdict": verdict, "effects": named, "guess": False, "confidence": 0.9, **more}


@pytest.mark.parametrize(
    ("truth", "given", "outcome"),
    [
        (GENT, answer("effects_missing", "gent_stiffening"), "right"),
        (GENT, answer("effects_missing", "tube_lag", tied=[["gent_stiffening"]]), "right"),
        (GENT, answer("effects_missing", "tube_lag", "gent_stiffening"), "sure"),
        (GENT, answer("effects_missing", "tube_lag", guess=True), "guess"),
        (GENT, answer("adequate"), "sure"),
        (GENT, answer("unexplained"), "refused"),
        (Truth("nothing"), answer("adequate"), "right"),
        (Truth("nothing"), answer("adequate", slips=[{"name": "sign"}]), "sure"),
        (Truth("kink", outside=True), answer("unexplained"), "right"),
        (Truth("", event="event", runs=("r3",)), answer("adequate", events=[]), "sure"),
        (
            Truth("", event="event", runs=("r3",)),
            answer("unexplained", events=[{"kind": "event", "run": "r3"}]),
            "right",
        ),
        (
            Truth("", event="odd_run", runs=("r3",)),
            answer("slip", slips=[{"name": "odd_run", "column": "r4"}]),
            "sure",
        ),
        (
            Truth("", slip="exchanged", event="exchanged", runs=("r1", "r3")),
            answer("slip", slips=[{"name": "exchanged", "column": "specimen of r1 and r3"}]),
            "right",
        ),
        (
            Truth("", slip="exchanged", event="exchanged", runs=("r1", "r3")),
            answer("slip", slips=[{"name": "exchanged", "column": "specimen of r1 and r2"}]),
            "sure",
        ),
        (
            Truth("", slip="odd_run", event="odd_run", runs=("r3",)),
            answer("slip", slips=[{"name": "odd_run", "column": "r3"}]),
            "right",
        ),
        (
            Truth("", slip="odd_run", event="odd_run", runs=("r3",)),
            answer("slip", slips=[{"name": "odd_run", "column": "r4"}]),
            "sure",
        ),
        (
            Truth("", slip="unit", factor=6.895),
            answer("slip", slips=[{"name": "unit", "said": "kPa", "fits": "psi"}]),
            "right",
        ),
        (
            Truth("", slip="unit", factor=6.895),
            answer("slip", slips=[{"name": "unit", "said": "kPa", "fits": "bar"}]),
            "sure",
        ),
    ],
)
def test_scores(truth, given, outcome):
    assert score.score(truth, given).outcome == outcome


def test_an_interval_that_misses_the_truth_does_not_hold_it():
    given = answer("effects_missing", "gent_stiffening")
    assert score.score(GENT, given).held == (True,)
    far = replace(GENT, values={"gent_stiffening": {"jm": 9.0}})
    assert score.score(far, given).held == (False,)


def test_stated_confidences_stand_beside_what_is_right():
    right = score.score(GENT, answer("effects_missing", "gent_stiffening", confidence=0.6))
    wrong = score.score(GENT, answer("adequate", confidence=0.7))
    none = score.score(GENT, answer("adequate", confidence=None))
    said, fine = score.stated([right, wrong, none])
    assert said.tolist() == [0.6, 0.7] and fine.tolist() == [True, False]
    assert calibration_error([0.6] * 10, [True] * 9 + [False], score.BINS) == pytest.approx(0.3)
