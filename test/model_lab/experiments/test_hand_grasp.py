"""A grasping hand in the lab: what is replayed, and what is predicted of it."""

from dataclasses import replace

import numpy as np
import pytest

from model_lab.bench.hand_grasp_set import hand_grasp_set
from model_lab.experiments import grasp_rollouts
from model_lab.experiments.forward import Forward
from model_lab.experiments.grasp_rollouts import Engine
from model_lab.experiments.hand_grasp import HandGrasp, held, simulated, simulated_values
from softhand_model.effects.hand_parts import Friction, ObjectMass
from softhand_model.effects.load import STANDARD_GRAVITY, Gravity

WEIGHT = Gravity(mass_scale=1.0)
CYLINDER = 0.106  # [kg], table 8.1 of the thesis
FAST = Engine(step=0.0025, name="mujoco")


def planned(*protocols, repeats="ab"):
    data = hand_grasp_set(np.random.default_rng(3), repeats=repeats)
    return replace(data, runs=tuple(run for run in data.runs if run.protocol in protocols))


def test_a_held_object_pulls_at_the_wrist_with_its_weight():
    data = planned("usual", repeats="a")
    seen = simulated(data, [WEIGHT, ObjectMass(factor=1.5)], 1.0, FAST)
    force = data.table.of_run(seen, 0)[data.outputs.index("wrench.fz"), -1]
    assert force == pytest.approx(-1.5 * CYLINDER * STANDARD_GRAVITY, rel=0.03)
    assert held(data, seen) == [True]


def analytic(time, wrist, masses, start, scene, model, modulus_scale, **config):
    """A simulator in which everything is a sum of what the parameters do alone."""
    factors = [
        np.log(e.friction_factor() * e.object_mass_factor() ** 2) for e in model.effects[:-1]
    ]
    level = sum(factors) + 3.0 * (modulus_scale - 1.0) + 10.0 * start[0]
    return np.outer(time, np.arange(13.0 + masses.shape[1])) * level


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
def test_a_run_is_simulated_once_for_each_model():
    data = planned("usual", "turned")
    forward = Forward(data, effects=[Friction], fixed=[WEIGHT])
    forward.predict(np.array([[1.0, 0.8]]))
    first = grasp_rollouts.rollouts_done()
    assert first == 4 + 2 * (2 + 2)  # all runs, and of each protocol two moduli and two factors
    forward.predict(np.random.default_rng(0).uniform(0.9, 1.1, (20, 2)))
    assert grasp_rollouts.rollouts_done() == first


def test_without_an_object_the_set_is_refused():
    with pytest.raises(ValueError, match="expected the key object, got none"):
        HandGrasp(replace(planned("usual"), grasped=None))
