"""Effects of one's own in a Python file, stage by stage, in a chain as the simulator runs it."""

import numpy as np
import pytest
from scipy.optimize import brentq

from softhand_model.chain.chain import discretise
from softhand_model.effects import Effect, Parameter, effect_classes, effects_in_file
from softhand_model.hand.actuator import load_actuator
from softhand_model.hand.hand import load_hand
from softhand_model.hand.rubber import strain_invariant
from softhand_model.model_file import Model, load_model

FINGER = load_hand("single_finger").chain("finger")

IMPORTS = """
import numpy as np
from softhand_model.effects import ElasticEffect, InputEffect, LoadEffect, Parameter
from softhand_model.effects import StructureEffect
"""

LAG = """
class Lag(InputEffect):
    name = "lag"
    parameters = (Parameter("time_constant", "s", 0.0, 10.0),)

    def chamber_pressure(self, pressure, memory, dt):
        before = memory.get("pressure", 0.0)
        share = 1 - np.exp(-dt / self.values["time_constant"])
        memory["pressure"] = before + share * (pressure - before)
        return memory["pressure"]
"""

WARM = """
class Warm(LoadEffect):
    name = "warm"

    def modulus_factor(self, temperature):
        return 1 - 0.01 * (temperature - 293.15)
"""

GENT = """
class Stiffer(ElasticEffect):
    name = "stiffer"
    parameters = (Parameter("jm", "", 1.0, 1000.0),)

    def stress(self, stress, strain, shape, memory, dt):
        return stress / (1 - strain.invariant / self.values["jm"])
"""

CREEP = """
class Creep(ElasticEffect):
    name = "relaxing"
    adds = True

    def stress(self, stress, strain, shape, memory, dt):
        before, over = memory.get("before", (0.0, 0.0))
        return stress + (over + 0.5 * (stress - before)) * np.exp(-dt / 0.1)

    def remember(self, stress, strain, shape, memory, dt):
        memory["before"] = stress, self.stress(stress, strain, shape, memory, dt) - stress
"""

SLACK = """
class Slack(StructureEffect):
    name = "slack"

    def stiffness_factor(self, bend, rest):
        return np.where(bend < rest, 0.4, 1.0)
"""


def chain_with(tmp_path, source, name, **parameters):
    (tmp_path / "own.py").write_text(IMPORTS + source, encoding="utf-8")
    written = ", ".join(f"{key}: {value}" for key, value in parameters.items())
    text = (
        "format: softhand-model/1\nbase: pneuflex\n"
        f"effects: [{{name: {name}, file: own.py, parameters: {{{written}}}}}]\n"
    )
    (tmp_path / "model.yaml").write_text(text, encoding="utf-8")
    return discretise(FINGER, 5, load_model(tmp_path / "model.yaml", allow_effect_files=True))


def tip(chain, pressure=30e3, dt=1e-3, temperature=293.15):
    return float(chain.step(dt, [pressure], np.zeros((5, 3)), temperature)[:, 1].sum())


def about_y(bend):
    return np.stack([0 * bend, bend, 0 * bend], axis=1)


def base_tip(pressure=30e3):
    return float(load_actuator("P10.finger").tip_angle(pressure))


def test_gravity_is_built_in():
    assert effect_classes()["gravity"].stage == "load"


def test_input_effect_with_memory_lags_and_forgets_at_reset(tmp_path):
    chain = chain_with(tmp_path, LAG, "lag", time_constant=0.05)
    angles = [tip(chain, dt=0.01) for _ in range(10)]
    share = 1 - np.exp(-0.1 / 0.05)
    assert angles[-1] == pytest.approx(base_tip(share * 30e3), rel=1e-6)
    chain.reset()
    assert tip(chain, dt=0.01) == pytest.approx(angles[0])


def test_load_effect_softens_rubber_and_joints_with_the_temperature(tmp_path):
    chain = chain_with(tmp_path, WARM, "warm")
    rest = base_tip(30e3 / 0.9)
    actual = np.tile([0.02, 0.1, 0.03], (5, 1))
    moved = chain.step(1e-3, [30e3], actual, 303.15)
    pulled = moved[:, 1]
    assert moved[:, [0, 2]] == pytest.approx(np.tile([0.002, 0.003], (5, 1)))
    assert pulled.sum() == pytest.approx(0.5 + 0.9 * (rest - 0.5), rel=1e-6)
    assert tip(chain) == pytest.approx(base_tip(), rel=1e-6)


def test_elastic_effect_is_balanced_exactly(tmp_path):
    chain = chain_with(tmp_path, GENT, "stiffer", jm=8.0)
    finger = load_actuator("P10.finger")
    edges = np.linspace(0, 0.09, 2001)
    x = (edges[1:] + edges[:-1]) / 2
    loads = 60e3 * finger.side_wall_ratio(x) * finger.height(x) / (4 * 67e3 * 0.002)

    def balance(load):
        def excess(lam):
            return (lam - lam**-3) / (1 - strain_invariant(lam) / 8.0) - load

        return brentq(excess, 1.0, 3.0)

    stretch = np.array([balance(load) for load in loads])
    exact = np.sum((stretch - 1) / finger.height(x)) * 0.09 / 2000
    assert tip(chain, 60e3) == pytest.approx(exact, rel=1e-5)
    assert tip(chain, 60e3) < 0.9 * base_tip(60e3)


def test_viscous_effect_creeps_to_the_relaxed_shape(tmp_path):
    chain = chain_with(tmp_path, CREEP, "relaxing")
    angles = np.array([tip(chain, dt=0.02) for _ in range(60)])
    assert angles[0] < 0.8 * base_tip()
    assert np.all(np.diff(angles) > -1e-9)
    assert angles[-1] == pytest.approx(base_tip(), rel=1e-3)


def test_structure_effect_pulls_as_a_softer_spring_would(tmp_path):
    chain = chain_with(tmp_path, SLACK, "slack")
    free = chain.rest_rotation([30e3])[:, 1]
    bend = free - 0.2
    pulled = chain.step(1e-3, [30e3], about_y(bend))[:, 1]
    assert pulled - bend == pytest.approx(np.full(5, 0.4 * 0.2), rel=1e-6)
    beyond = chain.step(1e-3, [30e3], about_y(free + 0.2))[:, 1]
    assert beyond == pytest.approx(free, rel=1e-6)


def test_effects_that_do_nothing_leave_the_base_model(tmp_path):
    source = """
class Idle(ElasticEffect):
    name = 'idle'

    def stress(self, stress, strain, shape, memory, dt):
        return stress
"""
    chain = chain_with(tmp_path, source, "idle")
    for pressure in (0.0, 200.0, 30e3, 79e3):
        found = chain.step(1e-3, [pressure], np.zeros((5, 3)))
        assert found == pytest.approx(chain.rest_rotation([pressure]), rel=1e-7, abs=1e-12)


def test_effect_without_equilibrium_is_named(tmp_path):
    source = """
class Falling(ElasticEffect):
    name = "falling"

    def stress(self, stress, strain, shape, memory, dt):
        return 0.1 * np.tanh(stress)
"""
    chain = chain_with(tmp_path, source, "falling")
    with pytest.raises(RuntimeError, match="falling the rubber has no equilibrium"):
        tip(chain)


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("import nothing_like_this\n", "got ModuleNotFoundError"),
        ("x = 1\n", "expected a class derived from softhand_model.effects.Effect that has a name"),
        (
            "class Odd(InputEffect):\n    name = 'odd'\n    stage = 'soul'\n",
            "stage: expected one of",
        ),
        ("class Odd(ElasticEffect)\n    pass\n", "got SyntaxError: expected ':' (own.py, line 5)"),
        (
            "class Odd(ElasticEffect):\n    name = 'odd'\n",
            "effect odd: expected a method of its stage, stress, got none",
        ),
        (
            "from softhand_model.effects import Effect\n"
            "class Odd(Effect):\n    name, stage = 'odd', 'load'\n",
            "effect odd: expected a subclass of one of InputEffect, LoadEffect,",
        ),
        (
            "class Odd(LoadEffect):\n    name = 'odd'\n    parameters = (Parameter('x', 'm'),)\n",
            "missing 2 required positional arguments: 'low' and 'high'",
        ),
        ("Parameter('x', 'm', 0.0, float('inf'))\n", "parameter x: expected two numbers as bounds"),
        ("Parameter('x', 'm', 0.0, 1.0, logarithmic=True)\n", "expected bounds above 0"),
        ("Parameter('x', 'm', 0.0, 1.0, typical=(0.5, 2.0))\n", "typical: expected numbers within"),
        (
            "class Odd(LoadEffect):\n    name = 'gravity'\n"
            "    def modulus_factor(self, temperature):\n        return 1.0\n",
            "effect gravity: expected a name that no built-in effect has",
        ),
    ],
)
def test_unusable_effect_file_is_named(tmp_path, source, message):
    path = tmp_path / "own.py"
    path.write_text(IMPORTS + source, encoding="utf-8")
    with pytest.raises(ValueError) as caught:
        effects_in_file(path)
    assert str(path) in str(caught.value)
    assert message in str(caught.value)


def test_unknown_experiment_is_named():
    with pytest.raises(ValueError, match="experiments: expected some of free_bending"):
        type(
            "Odd",
            (Effect,),
            {"name": "odd", "stage": "input", "experiments": frozenset({"dance"})},
        )


def test_parameters_show_in_the_representation():
    (parameter,) = effect_classes()["gravity"].parameters
    assert isinstance(parameter, Parameter)
    assert repr(effect_classes()["gravity"](mass_scale=2)) == "Gravity(mass_scale=2)"
    assert Model(effects=(effect_classes()["gravity"](mass_scale=2),)).gravity_scale == 2.0
