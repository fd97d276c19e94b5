"""Compiled stretches through whole runs, against steps of arrays and another integrator."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from softhand_model.bending.balance import SteppedBalance
from softhand_model.bending.elastic_chain import compiled_effects
from softhand_model.bending.loaded_finger import Blocked, BlockedSolver
from softhand_model.bending.whole_runs import (
    Runs,
    force_in_runs,
    stress_in_runs,
    stretch_in_runs,
)
from softhand_model.effects import Effect, effect_classes
from softhand_model.effects.pipeline import StagedEffects
from softhand_model.effects.stages import SectionShape, Strain
from softhand_model.effects.whole_runs import LONG

CLASSES = effect_classes()
RUNS, SAMPLES, LANES = 3, 120, 5
IN_LANES = {
    "gent_stiffening": {"jm": np.geomspace(3.0, 50.0, LANES)},
    "yeoh_stiffening": {"c2": np.geomspace(0.01, 0.3, LANES)},
    "thick_wall": {"gain": np.linspace(0.0, 5.0, LANES)},
    "mullins_softening": {"softening": np.linspace(0.0, 0.5, LANES), "stretch_scale": 0.3},
    "viscoelasticity": {
        "relative_modulus": np.linspace(0.0, 2.0, LANES),
        "relaxation_time": np.geomspace(0.01, 30.0, LANES),
    },
    "creep": {
        "rate": np.linspace(0.0, 0.12, LANES),
        "onset_time": np.geomspace(0.01, 3.0, LANES),
    },
    "hysteresis": {
        "relative_pressure": np.linspace(0.0, 0.4, LANES),
        "stretch_scale": np.geomspace(0.02, 0.5, LANES),
    },
    "permanent_set": {"share": np.linspace(0.0, 0.3, LANES)},
    "side_wall_integral": {},
}
ALL = tuple(name for name in IN_LANES if name != "creep")


def of(*names: str) -> list[Effect]:
    return [
        CLASSES[name].in_lanes({k: np.broadcast_to(v, LANES) for k, v in IN_LANES[name].items()})
        for name in names
    ]


def shape_of_runs() -> SectionShape:
    wall = np.array([0.002, 0.0035, 0.003])[None, :, None]
    width = np.array([0.02, 0.018])[None, None, :] * np.ones((1, RUNS, 1))
    return SectionShape(np.full((1, RUNS, 1), 0.02), width, wall, wall, np.array([[[0.9]]]), 6e4)


def loads() -> np.ndarray:
    """Loads (1, rows, 2) of two sections: up and down again, with rests, and below 0."""
    place = np.linspace(0.0, 1.0, SAMPLES)
    courses = [
        1.5 * np.sin(9.0 * place) ** 2,
        np.clip(3.0 * place - 0.5, 0.0, 1.2),
        0.8 * np.sin(14.0 * place),
    ]
    return np.concatenate(courses)[None, :, None] * np.array([1.0, 0.7])


def runs(steady: bool = False, carries: bool = False) -> Runs:
    random = np.random.default_rng(3)
    steps = random.uniform(0.01, 0.3, (RUNS, SAMPLES))
    steps[:, 0] = 0.0
    before = np.arange(RUNS) - 1 if carries else np.full(RUNS, -1)
    starts = SAMPLES * np.arange(RUNS + 1)
    return Runs(starts, steps.ravel(), np.array([steady, False, steady]), before)


def stepped(effects: list[Effect], load: np.ndarray, given: Runs) -> np.ndarray:
    """The same run by run, each sample a step of `SteppedBalance`."""
    shape, found, ends = shape_of_runs(), np.empty((LANES, *load.shape[1:])), {}
    for run in range(RUNS):
        balance = SteppedBalance(StagedEffects(effects))
        here = shape.of_rows(np.array([run]))
        if given.before[run] >= 0 and "mullins_softening" in balance.staged.memory:
            balance.staged.memory["mullins_softening"]["largest_stretch"] = ends[run - 1]
        rows = range(given.starts[run], given.starts[run + 1])
        if given.steady[run]:
            balance.stretch(load[:, rows[:1]], here, LONG)
        for row in rows:
            found[:, row : row + 1] = balance.stretch(load[:, row : row + 1], here, given.dt[row])
        memory = balance.staged.memory.get("mullins_softening", {})
        ends[run] = memory.get("largest_stretch", 1.0)
    return found


def compiled(effects: list[Effect], load: np.ndarray, given: Runs) -> np.ndarray:
    known = compiled_effects(StagedEffects(effects))
    assert known is not None
    return stretch_in_runs(known, load, shape_of_runs(), given, "pure_shear")


@pytest.mark.parametrize("names", [(), *((name,) for name in IN_LANES), ALL])
def test_all_lanes_in_one_loop_are_each_sample_stepped_alone(names: tuple[str, ...]) -> None:
    found = compiled(of(*names), loads(), runs())
    expected = stepped(of(*names), loads(), runs())
    assert np.abs(found - expected).max() < 1e-6  # where friction turns, a step settles late
    assert np.ptp(found) > 0.2


def test_steady_runs_start_where_their_first_load_has_been_for_long() -> None:
    names, load = ("viscoelasticity", "mullins_softening"), loads() + 0.3
    found = compiled(of(*names), load, runs(steady=True))
    assert found == pytest.approx(stepped(of(*names), load, runs(steady=True)), abs=1e-7)
    assert np.abs(found - compiled(of(*names), load, runs())).max() > 0.01


def test_a_specimen_starts_a_run_with_the_largest_stretch_of_those_before() -> None:
    found = compiled(of("mullins_softening"), loads(), runs(carries=True))
    expected = stepped(of("mullins_softening"), loads(), runs(carries=True))
    assert found == pytest.approx(expected, abs=1e-7)
    assert np.abs(found - compiled(of("mullins_softening"), loads(), runs())).max() > 0.01


def test_a_lane_is_what_it_is_without_the_others() -> None:
    together = compiled(of(*ALL), loads(), runs())
    last = [
        type(effect).in_lanes({name: value[-1:] for name, value in effect.values.items()})
        for effect in of(*ALL)
    ]
    assert compiled(last, loads(), runs())[0] == pytest.approx(together[-1], abs=1e-9)


@pytest.mark.parametrize("name", [name for name in IN_LANES if len(IN_LANES[name]) > 1])
def test_the_order_in_which_parameters_are_given_does_not_matter(name: str) -> None:
    given = {key: np.broadcast_to(value, LANES)[-2] for key, value in IN_LANES[name].items()}
    orders = (given, dict(reversed(given.items())))
    first, second = (compiled([CLASSES[name](**values)], loads(), runs()) for values in orders)
    np.testing.assert_array_equal(first, second)


def test_an_imposed_stretch_gives_the_stress_of_the_steps() -> None:
    names = ("gent_stiffening", "mullins_softening", "viscoelasticity", "hysteresis")
    given, stretch = runs(), 1.0 + 0.3 * np.abs(loads())
    for mode in ("pure_shear", "uniaxial", "equibiaxial", "linear"):
        staged = StagedEffects(of(*names))
        found = stress_in_runs(list(staged.elastic), stretch, shape_of_runs(), given, mode)
        for row in range(SAMPLES):
            strain = Strain(stretch[:, row : row + 1], mode)
            expected = staged.stress(strain, shape_of_runs(), given.dt[row])
            staged.remember(strain, shape_of_runs(), given.dt[row])
            assert found[:, row] == pytest.approx(expected[:, 0], rel=1e-10)


def test_relaxing_rubber_follows_its_differential_equation() -> None:
    """nu' = -nu/tau + g*Q' with Q + nu = s: solved as a differential equation of the stretch."""
    modulus, time_constant, rate, rows = 0.8, 0.7, 0.5, 2001
    time = np.linspace(0.0, 4.0, rows)

    def elastic(stretch: float) -> float:
        return stretch - stretch**-3

    def slope(t: float, state: np.ndarray) -> list[float]:
        over = rate * t - elastic(state[0])
        return [(rate + over / time_constant) / ((1.0 + modulus) * (1.0 + 3.0 * state[0] ** -4))]

    exact = solve_ivp(slope, (0.0, 4.0), [1.0], t_eval=time, rtol=1e-9, atol=1e-11).y[0]
    one = Runs(
        np.array([0, rows]),
        np.diff(time, prepend=0.0),
        np.zeros(1, bool),
        np.full(1, -1),
    )
    effect = CLASSES["viscoelasticity"](relative_modulus=modulus, relaxation_time=time_constant)
    load = (rate * time)[None, :, None]
    shape = SectionShape(*(np.full((1, 1, 1), size) for size in (0.02, 0.02, 0.002, 0.002, 1.0, 1)))
    found = stretch_in_runs([effect], load, shape, one, "pure_shear")[0, :, 0]
    assert found == pytest.approx(exact, abs=2e-6)
    relaxed = brentq(lambda stretch: elastic(stretch) - rate * 4.0, 1.0, 4.0)
    assert relaxed - found[-1] > 0.05


def test_a_load_that_no_stretch_carries_ends_at_the_last_one() -> None:
    assert compiled([], 1e6 + loads(), runs()).min() > 59.0


def test_models_with_an_effect_of_their_own_are_not_compiled() -> None:
    class Own(CLASSES["viscoelasticity"]):  # type: ignore[misc]
        name = "own"

        def stress(self, stress, strain, shape, memory, dt):  # type: ignore[no-untyped-def]
            return stress

    assert compiled_effects(StagedEffects([Own(relative_modulus=1.0, relaxation_time=1.0)])) is None
    assert compiled_effects(StagedEffects(of("gent_stiffening"))) is not None


@pytest.mark.parametrize("names", [(), ("viscoelasticity",), ("mullins_softening", "hysteresis")])
@pytest.mark.parametrize("compliance", [0.0, 1e-3])
def test_blocked_tips_in_one_loop_push_as_each_sample_alone(
    names: tuple[str, ...], compliance: float
) -> None:
    reach = np.array([0.07, 0.02])[None, None, :] * np.ones((1, RUNS, 1))
    blocked = Blocked(reach, np.full((1, RUNS, 2), 0.045), compliance, np.zeros((RUNS, 2, 2)))
    load, given = np.abs(loads()), runs(steady=True)
    effects = compiled_effects(StagedEffects(of(*names)))
    assert effects is not None
    found = force_in_runs(effects, load, shape_of_runs(), blocked, given)
    for run in range(RUNS):
        balance = SteppedBalance(StagedEffects(of(*names)))
        rows = range(given.starts[run], given.starts[run + 1])
        here = shape_of_runs().of_rows(np.array([run]))
        solver = BlockedSolver(blocked.of_rows(np.array([run])), here)
        if given.steady[run]:
            balance.stretch(load[:, rows[:1]], here, LONG, solver)
        for row in rows:
            balance.stretch(load[:, row : row + 1], here, given.dt[row], solver)
            expected = np.broadcast_to(solver.force[:, 0], found[:, row].shape)
            assert found[:, row] == pytest.approx(expected, abs=1e-6 * found.max())
