"""A grasping hand in the lab: what is replayed, and what is predicted of it."""

from dataclasses import replace

import numpy as np
import pytest

from model_lab.bench.hand_grasp_set import grasped, hand_grasp_set
from model_lab.comparison.add import add_effect, write_model
from model_lab.comparison.compare import errors_of
from model_lab.diagnosis.diagnose import diagnose
from model_lab.diagnosis.forward_selection import closer
from model_lab.diagnosis.search import score_base, score_with
from model_lab.diagnosis.selection import select
from model_lab.experiments import grasp_rollouts, hand_grasp
from model_lab.experiments.forward import Forward
from model_lab.experiments.grasp_rollouts import USUAL_ENGINE, Engine
from model_lab.experiments.hand_grasp import (
    HandGrasp,
    held,
    simulated,
    simulated_values,
    weighted,
)
from model_lab.fitting import problem
from model_lab.fitting.noise_floor import STATED, make_spectrum, noise_floor
from model_lab.fitting.problem import pose_problem
from model_lab.measurements.hands import GRASP
from model_lab.measurements.load import load_measurements
from model_lab.measurements.save import write_set
from model_lab.rules import RULES
from softhand_model.effects import effect_classes
from softhand_model.effects.hand_parts import Friction, ObjectMass, StrutStiffness
from softhand_model.effects.load import STANDARD_GRAVITY, Gravity
from softhand_model.model_file import load_model

WEIGHT = Gravity(mass_scale=1.0)
CYLINDER = 0.106  # [kg], table 8.1 of the thesis
FAST = Engine(step=0.0025, name="mujoco")


def planned(*protocols, repeats="ab"):
    data = hand_grasp_set(np.random.default_rng(3), repeats=repeats)
    return replace(data, runs=tuple(run for run in data.runs if run.protocol in protocols))


def test_from_a_set_on_disk_to_a_model_file(tmp_path, monkeypatch):
    empty = planned("usual", "near", repeats="a")
    true = grasped(empty, 1.0, (ObjectMass(factor=1.9),))  # with other segments and steps
    random, runs = np.random.default_rng(1), []
    for number, run in enumerate(empty.runs):
        parts = empty.table.of_run(true, number)
        noisy = (parts + 0.02 * random.standard_normal(parts.shape)).T / empty.output_scales
        runs.append(
            replace(run, columns={**run.columns, **dict(zip(empty.outputs, noisy.T, strict=True))})
        )
    write_set(replace(empty, runs=tuple(runs)), tmp_path / "set")
    data, seen = load_measurements(tmp_path / "set"), ("object_mass", "wrench_gain")
    classes = {name: kind for name, kind in effect_classes().items() if name in seen}

    answer = diagnose(data, load_model("gravity"), classes).diagnosis.as_json()
    assert answer["verdict"] == "effects_missing"
    (named,) = answer["effects"]
    assert named["name"] == "object_mass"
    assert named["parameters"]["factor"]["value"] == pytest.approx(1.9, rel=0.05)

    addition = add_effect("object_mass", data, load_model("gravity"), classes)
    write_model(tmp_path / "mended.yaml", addition.model)
    # how sure predictions are only weights the fits from here on, and takes a dozen grasps
    monkeypatch.setitem(problem.OWN_ERRORS, GRASP, lambda data, model: 0.0)
    before, after = (
        errors_of(data, load_model(name)).as_is.rmse
        for name in ("gravity", tmp_path / "mended.yaml")
    )
    assert after < 0.5 * before


def test_a_held_object_pulls_at_the_wrist_with_its_weight():
    data = planned("usual", repeats="a")
    seen = simulated(data, [WEIGHT, ObjectMass(factor=1.5)], 1.0, FAST)
    force = data.table.of_run(seen, 0)[data.outputs.index("wrench.fz"), -1]
    assert force == pytest.approx(-1.5 * CYLINDER * STANDARD_GRAVITY, rel=0.03)
    assert held(data, seen) == [True]


def analytic(time, wrist, masses, start, scene, model, modulus_scale, **config):
    """A simulator in which everything is a sum of what the parameters do alone, and all is held."""
    factors = [
        np.log(e.friction_factor() * e.object_mass_factor() ** 2) for e in model.effects[:-1]
    ]
    level = 5.0 + sum(factors) + 3.0 * (modulus_scale - 1.0) + 10.0 * start[0]
    return np.outer(time, np.arange(13.0 + masses.shape[1])) * level


def noisy(empty, true):
    """The set with these outputs [N] and noise of 0.01 N."""
    random, runs = np.random.default_rng(1), []
    for number, run in enumerate(empty.runs):
        parts = empty.table.of_run(true, number)
        read = (parts + 0.01 * random.standard_normal(parts.shape)) / empty.output_scales[:, None]
        columns = {**run.columns, **dict(zip(empty.outputs, read, strict=True))}
        runs.append(replace(run, columns=columns))
    return replace(empty, runs=tuple(runs))


@pytest.fixture
def by_analytic(monkeypatch):
    monkeypatch.setattr(grasp_rollouts, "_replay", lambda: analytic)
    monkeypatch.setattr(grasp_rollouts, "_KEPT", {})


@pytest.mark.usefixtures("by_analytic")
def test_what_is_sought_is_the_sum_of_simulated_changes():
    data = planned("usual", "turned")
    kinds = [Friction, ObjectMass]
    forward = Forward(data, effects=kinds, fixed=[WEIGHT])
    assert forward.parameters[0].name == "modulus_scale[A]"
    value = simulated_values(Friction.parameters[0])[0]
    lanes = np.array([[1.0, 1.0, 1.0], [1.15, value, 1.0], [0.85, 1.0, 1.3]])
    found = forward.predict(lanes)
    for lane, (scale, friction, mass) in zip(found[:2], lanes[:2], strict=True):
        effects = [Friction(factor=friction), ObjectMass(factor=mass), WEIGHT]
        direct = HandGrasp(data).predict({"modulus_scale[A]": np.array([scale])}, effects)[0]
        assert lane == pytest.approx(direct, abs=1e-9)
    assert not np.allclose(found[2], found[0])


@pytest.mark.usefixtures("by_analytic")
def test_what_is_proportional_to_a_mass_is_exact_between_simulated_masses(monkeypatch):
    def weighing(time, wrist, masses, *_, model, **config):
        (factor,) = [
            e.object_mass_factor() for e in model.effects if isinstance(e, ObjectMass)
        ] or [1]
        return np.outer(time, np.ones(13 + masses.shape[1])) * factor

    monkeypatch.setattr(grasp_rollouts, "_replay", lambda: weighing)
    data = planned("usual")
    one, more = Forward(data, effects=[ObjectMass], fixed=[WEIGHT]).predict(
        [[1.0, 1.0], [1.0, 1.6]]
    )
    assert more == pytest.approx(1.6 * one)


@pytest.mark.usefixtures("by_analytic")
def test_a_value_between_simulated_ones_is_found_by_simulating_it(monkeypatch):
    def yielding(time, wrist, masses, *_, model, modulus_scale, **config):
        strut = np.prod([e.strut_factor() for e in model.effects[:-1]])
        parts = np.arange(13.0 + masses.shape[1])
        return np.outer(time, parts / strut) + 0.1 * np.outer(time**2, parts * modulus_scale)

    monkeypatch.setattr(grasp_rollouts, "_replay", lambda: yielding)
    empty, truth = planned("usual", "turned", "near"), 0.4
    true = simulated(empty, [StrutStiffness(factor=truth), WEIGHT], 1.05, USUAL_ENGINE)
    data = noisy(empty, true)
    posed, _ = pose_problem(data, load_model("gravity"), {"strut_stiffness": StrutStiffness})
    between = score_with(posed, score_base(posed), "strut_stiffness")
    exact = closer(posed, between)
    assert between.fit.values[1] > 1.15 * truth  # interpolated, as the change is like 1/factor
    assert exact.fit.values == pytest.approx([1.05, truth], rel=0.02)
    assert exact.held_out.rmse == pytest.approx(0.01, rel=0.1)


@pytest.mark.usefixtures("by_analytic")
def test_an_effect_whose_interpolated_predictions_err_is_simulated_before_it_is_rejected(
    monkeypatch,
):
    def sliding(time, wrist, masses, *_, model, modulus_scale, **config):
        """What friction changes depends on the modulus, which a sum of changes leaves out."""
        friction = np.prod([e.friction_factor() for e in model.effects[:-1]])
        felt = time**2 + 40.0 * (modulus_scale - 1.0) * np.sin(6.0 * time)
        level = 5.0 * time * modulus_scale + np.log(friction) * felt
        return 1e-3 * np.outer(level, np.arange(13.0 + masses.shape[1]))

    monkeypatch.setattr(grasp_rollouts, "_replay", lambda: sliding)
    empty, truth = planned("usual", "turned", "near"), 0.6
    data = noisy(empty, simulated(empty, [Friction(factor=truth), WEIGHT], 1.05, USUAL_ENGINE))
    posed, _ = pose_problem(data, load_model("gravity"), {"friction": Friction})

    def found(rules):
        return select(replace(posed, rules=rules), ["friction"], [], seed=0, jobs=1).final

    assert found(replace(RULES, simulated_singles=0)).effects == ()
    assert found(RULES).fit.values == pytest.approx([1.05, truth], rel=0.02)


@pytest.mark.usefixtures("by_analytic")
def test_a_run_is_simulated_once_for_each_model():
    data = planned("usual", "turned")
    forward = Forward(data, effects=[Friction], fixed=[WEIGHT])
    forward.predict(np.array([[1.0, 0.8]]))
    first = grasp_rollouts.rollouts_done()
    # all runs, of each protocol two moduli and two factors, and of one a factor between two
    assert first == 4 + 2 * (2 + 2) + 2
    forward.predict(np.random.default_rng(0).uniform(0.9, 1.1, (20, 2)))
    assert grasp_rollouts.rollouts_done() == first


def exact(data, *lost):
    """The set as the analytic simulator has it, but in some runs the object falls in the end."""
    predicted, runs = HandGrasp(data).predict({}, [WEIGHT])[0], []
    for number, run in enumerate(data.runs):
        parts = data.table.of_run(predicted, number) / data.output_scales[:, None]
        columns = {**run.columns, **dict(zip(data.outputs, parts, strict=True))}
        if number in lost:
            columns["object.z"] = columns["object.z"] * (run.columns["time"] < 3.0)
        runs.append(replace(run, columns=columns))
    return replace(data, runs=tuple(runs))


@pytest.mark.usefixtures("by_analytic")
def test_few_grasps_that_end_otherwise_are_left_out_and_many_are_not(monkeypatch):
    def rising(time, wrist, masses, *_, **config):
        return np.outer(0.1 * time, np.ones(13 + masses.shape[1]))

    monkeypatch.setattr(grasp_rollouts, "_replay", lambda: rising)
    data = planned("usual", "turned", "near")

    def told(*lost):
        model = HandGrasp(exact(data, *lost))
        model.predict({}, [WEIGHT])
        return model.unsettled

    assert told() == told(0, 1, 2) == {}
    assert told(1, 4) == dict.fromkeys((1, 4), "the object was lost, and not as predicted")
    problem, _ = pose_problem(exact(data, 1), load_model("gravity"), {})
    assert problem.data.left_out == {data.runs[1].name: "the object was lost, and not as predicted"}
    assert len(problem.data.runs) == len(data.runs) - 1


@pytest.mark.usefixtures("by_analytic")
def test_more_is_simulated_where_the_change_by_a_factor_is_bent(monkeypatch):
    def sticking(time, wrist, masses, *_, model, **config):
        """Contacts slide in one protocol, and stick with more than 0.75 of the friction."""
        friction = np.prod([effect.friction_factor() for effect in model.effects[:-1]])
        slide = np.tanh(8.0 * (0.75 - friction)) * (masses.max() > 6e-5)
        return np.outer(time, np.full(13 + masses.shape[1], 5.0 + slide + 0.2 * friction))

    monkeypatch.setattr(grasp_rollouts, "_replay", lambda: sticking)
    data, factors = planned("usual", "little_air"), np.array([0.5, 0.64, 0.8, 0.9, 1.5])
    lanes = Friction.in_lanes({"factor": factors})
    expected = [
        simulated(data, [Friction(factor=factor), WEIGHT], 1.0, USUAL_ENGINE) for factor in factors
    ]

    def errors():
        left = HandGrasp(data).predict({}, [lanes, WEIGHT]) - expected
        return np.sqrt(np.mean(left**2, axis=1))

    close = errors()
    monkeypatch.setattr(hand_grasp, "RULES", replace(RULES, bent_share=np.inf))
    assert np.max(close) < 0.5 * np.max(errors())


@pytest.mark.usefixtures("by_analytic")
def test_grasps_that_end_otherwise_are_not_interpolated(monkeypatch):
    def slipping(time, wrist, masses, *_, model, **config):
        """All outputs are linear in friction; with little air, the object falls below 0.45."""
        friction = np.prod([effect.friction_factor() for effect in model.effects[:-1]])
        seen = np.outer(0.05 * time, (1.0 + friction) * np.ones(13 + masses.shape[1]))
        return seen * (friction > 0.45 or masses.max() > 6e-5)

    monkeypatch.setattr(grasp_rollouts, "_replay", lambda: slipping)
    data = planned("usual", "little_air")
    factors = np.array([simulated_values(Friction.parameters[0])[0], 0.52, 0.8, 1.5])
    assert factors[0] < 0.45

    def told(*lost):
        grasp = HandGrasp(exact(data, *lost))
        return grasp.predict({}, [Friction.in_lanes({"factor": factors}), WEIGHT])

    def true(factor):
        return simulated(data, [Friction(factor=factor), WEIGHT], 1.0, USUAL_ENGINE)

    expected = np.stack([true(factor) for factor in factors])
    little = [number for number, run in enumerate(data.runs) if run.protocol == "little_air"]
    lost = told(*little)[0]  # and held at the neutral value: nothing is left out
    assert lost == pytest.approx(expected[0])
    last_held = true(factors[0] ** 0.75)  # after two halvings of the logarithmic way
    expected[0] = np.where(np.isin(data.table.run, little), last_held, expected[0])
    assert told() == pytest.approx(expected)


@pytest.mark.usefixtures("by_analytic")
def test_samples_count_less_in_the_run_and_phase_in_which_steps_matter(monkeypatch):
    data = planned("usual", "near")
    *others, last = data.runs
    moved = {"wrist.x": last.columns["wrist.x"] + 0.001}  # a repeat, but not quite
    data = replace(data, runs=(*others, replace(last, columns={**last.columns, **moved})))
    time = last.columns["time"]

    def replayed(time, wrist, masses, *_, segments, step, **config):
        seen = np.outer(time, np.ones(9 + masses.shape[1]))
        seen[time > 2.0] += 1.0 * (step < 0.002) * (wrist[0, 0] == moved["wrist.x"][0])
        seen += 0.01 * (segments > 5)
        return np.hstack([seen / data.output_scales, np.zeros((len(time), 4))])

    monkeypatch.setattr(grasp_rollouts, "_replay", lambda: replayed)
    found = weighted(exact(data), load_model("gravity"))
    for run in found.runs:
        late = (time > 2.3) & (run.name == last.name)
        assert run.weights[:, late] == pytest.approx(0.01, rel=0.03)  # 1 N, usual are 0.01 N
        early = (time < 1.7) | (run.name != last.name)
        assert run.weights[:, early] == pytest.approx(np.sqrt(0.5))
    assert weighted(found, load_model("gravity")).table.value == pytest.approx(found.table.value)
    assert HandGrasp(found).predict({}, [WEIGHT])[0] == pytest.approx(found.table.value)
    assert held(found) == held(exact(data))


def test_stated_noise_is_weighted_as_the_samples_are():
    empty = planned("usual", repeats="a")
    noise = dict(zip(empty.outputs, 0.02 / empty.output_scales, strict=True))
    data = replace(empty, noise=noise, runs=(replace(empty.runs[0], weights=0.5),))
    course = np.linspace(0.0, 1.0, data.table.samples)
    floor = noise_floor(data, make_spectrum(data.table, course), course)
    assert floor.source == STATED
    assert floor.total == pytest.approx(0.01)


def test_without_an_object_the_set_is_refused():
    with pytest.raises(ValueError, match="expected an entry `object`, got none"):
        HandGrasp(replace(planned("usual"), grasped=None))
