"""Flow effects of a model file act in the simulator's plant as the lab predicts that they do."""

import numpy as np
import pytest

from model_lab.experiments.forward import Forward
from model_lab.measurements.measurement_set import MeasurementSet, Run, Specimen
from pneuflex_sim.simulation import Simulation, SimulationConfig
from softhand_model.effects import FlowEffect, effect_classes
from softhand_model.gas import AMBIENT_PRESSURE, psi
from softhand_model.model_file import load_model
from softhand_model.pneumatics import PneumaticPlant, load_pneumatics

BOTTLE = np.array([0.5e-3])  # so large that its pressure hardly answers to what an effect adds
PULSES = ((1, 140e3, 0.18), (1, 170e3, 0.1), (-1, 180e3, 0.18), (-1, 220e3, 0.1))
"""Direction, absolute pressure in the bottle before [Pa], time for which the coil is on [s]."""
STEP, REST = 2.5e-4, 0.1  # [s]
COLUMNS = ("direction", "duration", "p_in", "p_out", "friction_integral", "injector_integral")
BUILT_IN = {
    "injector_flow": {"c2_inflate": 8e-11, "c2_deflate": 5e-10},
    "line_friction": {"c1_inflate": 2e-11, "c1_deflate": -1e-10},
    "switching_volume": {"c3_inflate": 1e-12, "c3_deflate": 5e-12, "c4_inflate": -1e-12},
    "pulse_bias": {"c0_inflate": 3e-7, "c0_deflate": -8e-7},
    "valve_delay": {"delay": 0.015},
    "leakage": {"conductance": 8e-11},
    "supply_droop": {"resistance": 4e9},
    "polytropic_gas": {"exponent": 1.2},
}
ADDITIVE = ("line_friction", "switching_volume", "pulse_bias", "leakage")  # free of the naive term
SEEN_WHILE = {"supply_droop": (1,)}  # directions in which an effect acts; both if it is not here
OWN = '''
import numpy as np
from softhand_model.effects import FlowEffect, Parameter

class Sticky(FlowEffect):
    """Short pulses move less."""
    name = "sticky"
    experiments = frozenset({"valve_pulse"})
    parameters = (Parameter("time", "s", 0.0, 1.0),)

    def act_on_mass(self, mass, pulse):
        return mass * -np.expm1(-pulse.duration / self.of("time"))
'''


def model_file(tmp_path, name, values, extra=""):
    path = tmp_path / f"{name}.yaml"
    listed = ", ".join(f"{key}: {value!r}" for key, value in values.items())
    path.write_text(
        "format: softhand-model/1\nbase: pneuflex\n"
        f"effects:\n  - {{name: {name}, {extra}parameters: {{{listed}}}}}\n"
    )
    return path


def simulator_plant(model):
    """The plant that a simulation builds with this model."""
    config = SimulationConfig(hand="single_finger", scene="stand", segments=1, model=model)
    simulation = Simulation(config)
    simulation.close()
    return simulation.plant


def pulse_columns(plant, direction, start, command):
    """One pulse on a bottle: the lab's columns, and the mass moved from p_in to p_out [kg]."""
    plant.fill(plant.rest_mass(BOTTLE) * start / AMBIENT_PRESSURE)
    before = plant.mass[0] + plant.leaked[0]
    course = []
    for k in range(round((command + REST) / STEP)):
        channel, supply = plant.pressures[0], plant.supply_pressure
        plant.step(STEP, [direction if k * STEP < command else 0], BOTTLE)
        if plant.valve_states[0]:
            course.append((supply, channel) if direction > 0 else (channel, AMBIENT_PRESSURE))
    p_in, p_out = np.transpose(course)
    integrals = STEP * np.sum([p_in - p_out, p_in * psi(p_out / p_in)], axis=1)
    mass = direction * (plant.mass[0] + plant.leaked[0] - before)  # a leak goes on between pulses
    return [direction, STEP * len(course), p_in[0], p_out[0], *integrals], mass


def pulses(model):
    plant = simulator_plant(model)
    plant.reset(BOTTLE)
    found = [pulse_columns(plant, *pulse) for pulse in PULSES]
    columns, mass = zip(*found, strict=True)
    return {**dict(zip(COLUMNS, np.transpose(columns), strict=True)), "mass": np.array(mass)}


def prediction(columns, effects=(), calibration=None):
    """What the lab predicts for the columns; without a calibration the one that fits them."""
    run = Run("r", "valve", "p", 293.15, columns)
    data = MeasurementSet("valve_pulse", "", {"valve": Specimen("valve")}, (run,))
    free = calibration is None
    forward = Forward(data, fixed=effects, calibration=calibration, free_calibration=free)
    start = forward.start()
    fitted = {p.name: value for p, value in zip(forward.parameters, start, strict=True)}
    return forward.predict(start[None])[0], fitted


@pytest.fixture(scope="module")
def plain():
    return pulses("base")


def changes(path, plain):
    """By how much an effect changes the masses [kg]: in the plant, and by the lab."""
    model = load_model(path, allow_effect_files=True)
    with_effect, effects = pulses(model), model.effects
    base, calibration = prediction(plain)
    known = {} if effects[0].replaces_naive else calibration
    lab, _ = prediction(with_effect, effects, known)
    return with_effect["mass"] - plain["mass"], lab - base, with_effect


def check_alike(path, plain, tolerance, directions=(1, -1)):
    """What an effect adds moves the pressure in the bottle and so the valve's own flow: 2 %.
    Effects that act on the naive term differ by 10 % more: it is c*p_in*duration in the lab and
    the valve's own flow in the plant, which with one c a direction agree no better here.
    """
    plant, lab, _ = changes(path, plain)
    acts = np.isin(plain["direction"], directions)
    assert (np.abs(lab[acts]) > 0.01 * plain["mass"][acts]).all()
    assert plant[acts] == pytest.approx(lab[acts], rel=tolerance)
    assert np.abs(plant[~acts]) == pytest.approx(0.0, abs=1e-12)


def test_every_flow_effect_of_the_catalogue_is_tried_here():
    assert set(BUILT_IN) == {n for n, e in effect_classes().items() if e.stage == "flow"}


@pytest.mark.parametrize("name", BUILT_IN)
def test_an_effect_changes_a_pulse_in_the_simulator_as_in_the_lab(name, tmp_path, plain):
    path = model_file(tmp_path, name, BUILT_IN[name])
    tolerance = 0.03 if name in ADDITIVE else 0.12
    check_alike(path, plain, tolerance, SEEN_WHILE.get(name, (1, -1)))


def test_an_effect_of_the_users_own_acts_as_the_built_in_ones_do(tmp_path, plain):
    (tmp_path / "sticky.py").write_text(OWN)
    check_alike(model_file(tmp_path, "sticky", {"time": 0.1}, "file: sticky.py, "), plain, 0.12)


def test_the_plain_valve_is_near_the_naive_law_and_far_from_what_effects_do_to_it(plain):
    base, _ = prediction(plain)
    assert base == pytest.approx(plain["mass"], rel=0.08)


def test_a_pulse_with_an_injector_term_moves_just_that_and_nothing_of_the_valves_own(
    tmp_path, plain
):
    path = model_file(tmp_path, "injector_flow", BUILT_IN["injector_flow"])
    _, _, found = changes(path, plain)
    c2 = np.where(found["direction"] > 0, 8e-11, 5e-10)
    assert found["mass"] == pytest.approx(c2 * found["injector_integral"], rel=0.01)


# ------------------------------------------------------------------ the plant itself

FINGER = np.array([30e-6, 45e-6])


def effect(name, **values):
    return effect_classes()[name](**(values or BUILT_IN[name]))


def drive(plant, steps=400, seed=4):
    """What random valves make of a plant."""
    draw, valves, told = np.random.default_rng(seed), np.zeros(2, int), []
    for _ in range(steps):
        if draw.random() < 0.03:
            valves = draw.choice([-1, 0, 1, 1], 2)
        told.append(np.append(plant.step(1e-3, valves, FINGER), plant.read()))
    return np.array(told)


def test_an_effect_that_does_nothing_leaves_the_plant_as_it_is():
    plain = PneumaticPlant("ab", FINGER, seed=1)
    neutral = [effect("pulse_bias", c0_inflate=0.0, c0_deflate=0.0)]
    same = PneumaticPlant("ab", FINGER, seed=1, effects=neutral)
    assert drive(same) == pytest.approx(drive(plain), rel=1e-9)
    assert same.mass == pytest.approx(plain.mass, rel=1e-12)


def test_no_air_is_made_or_lost_by_effects_that_are_together_in_a_model():
    plant = PneumaticPlant("ab", FINGER, effects=[effect(name) for name in BUILT_IN])
    start = plant.mass
    drive(plant)
    left = start + plant.inflow - plant.outflow - plant.leaked - plant.relieved
    assert plant.mass == pytest.approx(left, rel=1e-12)
    assert plant.leaked.max() > 1e-9


def test_a_run_with_effects_repeats_bit_for_bit_after_restore_and_after_reset():
    plant = PneumaticPlant("ab", FINGER, seed=1, effects=[effect(name) for name in BUILT_IN])
    first = drive(plant)
    saved, more = plant.save(), drive(plant, seed=5)
    drive(plant, seed=6)
    plant.restore(saved)
    np.testing.assert_array_equal(drive(plant, seed=5), more)
    plant.reset()
    np.testing.assert_array_equal(drive(plant), first)


def test_a_channel_with_a_leak_loses_air_between_pulses_down_to_ambient_pressure():
    plant = PneumaticPlant("ab", FINGER, effects=[effect("leakage", conductance=1e-10)])
    plant.fill(plant.rest_mass(FINGER) * 1.5)
    mass = plant.mass
    plant.step(0.1, [0, 0], FINGER)
    assert plant.leaked == pytest.approx(1e-10 * 0.5 * AMBIENT_PRESSURE * 0.1, rel=0.02)
    assert plant.mass == pytest.approx(mass - plant.leaked, rel=1e-12)
    plant.step(60.0, [0, 0], FINGER)
    assert plant.pressures == pytest.approx(AMBIENT_PRESSURE, rel=1e-4)


def test_effects_take_no_channel_above_the_supply_or_below_ambient_pressure():
    strong = [effect("pulse_bias", c0_inflate=1e-4, c0_deflate=1e-4)]
    plant = PneumaticPlant("ab", FINGER, effects=strong)
    plant.step(0.2, [1, 1], FINGER)
    assert (plant.pressures <= plant.supply_pressure + 1e3).all()
    plant.step(0.2, [-1, -1], FINGER)
    assert (plant.pressures >= AMBIENT_PRESSURE - 1.0).all()


def test_a_pulse_that_has_just_begun_adds_no_more_than_its_valve_could_pass():
    longer = [effect("valve_delay", delay=-0.05)]
    plant = PneumaticPlant("ab", FINGER, load_pneumatics("ideal"), effects=longer)
    course = np.array([plant.step(1e-3, [int(k < 80)] * 2, FINGER) for k in range(200)])
    assert (course[-1] > AMBIENT_PRESSURE + 5e3).all()
    assert (course <= course[-1] + 500.0).all()  # no peak while the dead volumes fill


def test_a_valve_that_goes_from_one_outlet_to_the_other_begins_another_pulse():
    def moved(*effects):
        plant = PneumaticPlant("a", BOTTLE, effects=effects)
        plant.fill(plant.rest_mass(BOTTLE) * 1.5)
        for valve in (1, -1, 0):
            for _ in range(150):
                plant.step(1e-3, [valve], BOTTLE)
        return plant.mass[0]

    added = BUILT_IN["pulse_bias"]["c0_inflate"] - BUILT_IN["pulse_bias"]["c0_deflate"]
    assert moved(effect("pulse_bias")) - moved() == pytest.approx(added, rel=0.03)


class NoMass(FlowEffect):
    name = "broken"

    def act_on_mass(self, mass, pulse):
        return mass * np.nan


class NoLeak(FlowEffect):
    name = "broken"

    def leak(self, pressure_abs):
        return pressure_abs * np.nan


@pytest.mark.parametrize(("kind", "what"), [(NoMass, "mass"), (NoLeak, "leak")])
def test_an_effect_that_gives_no_finite_numbers_is_named(kind, what):
    plant = PneumaticPlant("ab", FINGER, effects=[kind()])
    with pytest.raises(ValueError, match=f"flow effects broken: expected a finite {what}"):
        plant.step(0.1, [1, 0], FINGER)


def test_imposed_air_masses_are_refused_for_they_pass_no_valve(tmp_path):
    path = model_file(tmp_path, "leakage", BUILT_IN["leakage"])
    simulation = Simulation(
        SimulationConfig(hand="single_finger", scene="stand", segments=1, model=path)
    )
    with pytest.raises(ValueError, match=r"leakage\.yaml: effects: leakage: .* pulses"):
        simulation.set_air_masses([1e-6])
    simulation.close()
