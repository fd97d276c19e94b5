"""The pneumatic plant against conservation laws, closed forms and independent integration."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from softhand_model.chain.volumes import FreeActuators
from softhand_model.gas import AMBIENT_PRESSURE, GAS_CONSTANT, orifice_flow
from softhand_model.hand.hand import load_hand
from softhand_model.pneumatics import PneumaticPlant, load_pneumatics

GAS = GAS_CONSTANT * 293.15  # [J/kg]
BOTTLE = 0.5e-3
FINGER = 30e-6
EIGHT = list("abcdefgh")
STATED_DELAYS = (0.020, 0.040)


def even_box(**changes):
    """A box without tolerances and heat, its tubes so wide that only the chokes count."""
    p = load_pneumatics("ideal")
    return replace(
        p,
        choke=replace(p.choke, discharge_coefficient=(0.8, 0.8)),
        line=replace(p.line, diameter=0.02),
        valve=replace(p.valve, diameter=0.02, delay_jitter=0.0),
        supply=replace(p.supply, droop=0.0),
        **changes,
    )


def run(plant, duration, valves, volumes, dt=1e-3):
    for _ in range(round(duration / dt)):
        plant.step(dt, valves, volumes)


def test_all_air_is_at_ambient_pressure_at_rest_and_stays_there():
    plant = PneumaticPlant(EIGHT, np.full(8, FINGER))
    run(plant, 0.5, [0] * 8, np.full(8, FINGER))
    np.testing.assert_allclose(plant.pressures, AMBIENT_PRESSURE, rtol=1e-12)
    dead = 2 * load_pneumatics().choke.dead_volume
    expected = AMBIENT_PRESSURE * (FINGER + dead) / GAS
    np.testing.assert_allclose(plant.rest_mass(np.full(8, FINGER)), expected, rtol=1e-12)


def test_what_flows_in_less_what_flows_out_is_what_is_there():
    plant = PneumaticPlant(EIGHT, np.full(8, FINGER))
    random = np.random.default_rng(5)
    start = plant.mass
    for _ in range(60):
        valves = random.integers(-1, 2, 8)
        volumes = FINGER * random.uniform(0.9, 1.3, 8)
        run(plant, 0.03, valves, volumes, dt=random.choice([0.001, 0.002, 0.01]))
    assert (plant.inflow > 1e-6).all() and (np.abs(plant.outflow) > 1e-7).all()
    np.testing.assert_allclose(start + plant.inflow - plant.outflow, plant.mass, rtol=1e-12)


def test_with_closed_valves_mass_stays_while_pressure_times_volume_does():
    plant = PneumaticPlant(["a"], [FINGER], load_pneumatics("ideal"))
    run(plant, 0.4, [1], [FINGER])
    run(plant, 0.3, [0], [FINGER])
    mass = float(plant.mass[0])
    dead = 2 * load_pneumatics().choke.dead_volume
    for volume in FINGER * np.array([0.7, 1.0, 1.8, 1.2]):
        run(plant, 0.5, [0], [volume])
        assert float(plant.mass[0]) == pytest.approx(mass, rel=1e-13)
        assert plant.pressures[0] * (volume + dead) == pytest.approx(mass * GAS, rel=1e-4)


def test_a_choked_inlet_fills_a_bottle_at_a_constant_rate():
    plant = PneumaticPlant(["a"], [BOTTLE], even_box())
    run(plant, 0.1, [1], [BOTTLE])
    before = float(plant.mass[0])
    run(plant, 1.0, [1], [BOTTLE])
    rate = float(orifice_flow(401_300.0, AMBIENT_PRESSURE, 0.8 * np.pi / 4 * 0.2e-3**2))
    assert float(plant.mass[0]) - before == pytest.approx(rate * 1.0, rel=2e-3)


def test_a_finger_empties_as_an_independent_integration_says():
    box = even_box()
    plant = PneumaticPlant(["a"], [FINGER], box)
    plant.fill(1.6 * plant.rest_mass([FINGER]))
    run(plant, 0.05, [-1], [FINGER])  # the valve is open by now
    start = float(plant.pressures[0])
    run(plant, 0.08, [-1], [FINGER])
    area = 0.8 * np.pi / 4 * box.choke.outlet_diameter**2

    def emptying(_, pressure):
        return -orifice_flow(pressure, AMBIENT_PRESSURE, area) * GAS / FINGER

    expected = solve_ivp(emptying, (0, 0.08), [start], rtol=1e-8).y[0, -1]
    gauge = float(plant.pressures[0]) - AMBIENT_PRESSURE
    assert gauge == pytest.approx(expected - AMBIENT_PRESSURE, rel=0.03)


def test_the_dead_volume_empties_into_the_channel_after_closing():
    box = even_box()
    plant = PneumaticPlant(["a"], [BOTTLE], box)
    run(plant, 0.2, [1], [BOTTLE])
    while plant.valve_states[0]:
        at_closing = float(plant.pressures[0])
        plant.step(1e-3, [0], [BOTTLE])
    run(plant, 0.5, [0], [BOTTLE])
    caught = (401_300.0 - at_closing) * box.choke.dead_volume / GAS
    assert (plant.pressures[0] - at_closing) * BOTTLE / GAS == pytest.approx(caught, rel=0.02)


def test_valves_open_and_close_within_the_stated_delays_each_with_its_own():
    plant = PneumaticPlant(EIGHT, np.full(8, BOTTLE), seed=3)
    volumes = np.full(8, BOTTLE)
    seen = {}
    for direction in (1, -1):
        for phase, command in (("opens", direction), ("closes", 0)):
            switched = np.full(8, np.nan)
            for k in range(80):
                plant.step(1e-3, [command] * 8, volumes)
                fresh = np.isnan(switched) & (plant.valve_states == command)
                switched[fresh] = (k + 0.5) * 1e-3
            seen[direction, phase] = switched
    times = np.array(list(seen.values()))
    assert times.min() > STATED_DELAYS[0] - 1e-3 and times.max() < STATED_DELAYS[1] + 1e-3
    assert all(np.ptp(row) > 4e-3 for row in times)


def test_a_pulse_shorter_than_the_opening_delay_moves_nothing():
    plant = PneumaticPlant(EIGHT, np.full(8, FINGER))
    start = plant.mass
    run(plant, 0.018, [1] * 8, np.full(8, FINGER))
    run(plant, 0.2, [0] * 8, np.full(8, FINGER))
    np.testing.assert_allclose(plant.mass, start, rtol=1e-13)


def test_the_smallest_pulse_moves_about_what_the_thesis_states():
    plant = PneumaticPlant(EIGHT, np.full(8, FINGER))
    run(plant, 0.5, [1] * 8, np.full(8, FINGER))
    run(plant, 0.3, [0] * 8, np.full(8, FINGER))
    before = plant.mass
    run(plant, 0.045, [-1] * 8, np.full(8, FINGER))
    run(plant, 0.3, [0] * 8, np.full(8, FINGER))
    taken = 1e6 * (before - plant.mass)  # [mg]
    assert taken.min() > 1.2 and taken.max() < 5.0


def test_inlet_and_outlet_are_never_open_together():
    plant = PneumaticPlant(["a"], [FINGER])
    run(plant, 0.1, [1], [FINGER])
    states = []
    for _ in range(100):
        plant.step(1e-3, [-1], [FINGER])
        states.append(int(plant.valve_states[0]))
    assert states[0] == 1 and states[-1] == -1 and 0 in states
    assert states == sorted(states, reverse=True)


def test_the_supply_droops_with_the_flow_and_recovers():
    plant = PneumaticPlant(["a"], [BOTTLE])
    rest = plant.supply_pressure
    run(plant, 1.5, [1], [BOTTLE])
    before = float(plant.mass[0])
    run(plant, 0.2, [1], [BOTTLE])
    flow = (float(plant.mass[0]) - before) / 0.2
    compressor = plant.parameters.compressor
    tank = compressor.cut_out + AMBIENT_PRESSURE - plant.tank_pressure
    expected = plant.parameters.supply.droop * flow + compressor.passed * tank
    assert rest - plant.supply_pressure == pytest.approx(expected, rel=0.02)
    run(plant, 3.0, [0], [BOTTLE])
    assert plant.supply_pressure == pytest.approx(rest - compressor.passed * tank, rel=1e-4)


@pytest.mark.parametrize("gauge", [260e3, 300e3, 320e3])
def test_a_choked_inlet_passes_mass_in_proportion_to_the_supply(gauge):
    plant = PneumaticPlant(["a"], [BOTTLE], even_box())
    plant.set_supply(gauge)
    run(plant, 1.0, [0], [BOTTLE])
    run(plant, 0.1, [1], [BOTTLE])
    before = float(plant.mass[0])
    run(plant, 0.5, [1], [BOTTLE])
    rate = float(orifice_flow(gauge + AMBIENT_PRESSURE, 101e3, 0.8 * np.pi / 4 * 0.2e-3**2))
    assert float(plant.mass[0]) - before == pytest.approx(rate * 0.5, rel=2e-3)


def test_steps_of_any_length_substep_at_a_millisecond():
    fine, coarse = (PneumaticPlant(["a"], [FINGER]) for _ in range(2))
    run(fine, 0.3, [1], [FINGER], dt=1e-3)
    run(coarse, 0.3, [1], [FINGER], dt=1e-2)
    np.testing.assert_allclose(coarse.pressures, fine.pressures, rtol=1e-12)


@pytest.mark.parametrize("delays", [(0.020, 0.040), (0.001, 0.004)])
def test_what_a_pulse_moves_does_not_depend_on_the_length_of_steps(delays):
    """Spools move at their own moments, not at the ends of substeps."""
    p = even_box()
    box = replace(p, valve=replace(p.valve, opening_delay=delays, closing_delay=delays))
    moved = []
    for dt in (1e-3, 1e-4):
        plant = PneumaticPlant(["a", "b"], [BOTTLE] * 2, box)
        before = plant.mass
        run(plant, 0.05, [1, 1], [BOTTLE] * 2, dt)
        run(plant, 0.05, [0, 0], [BOTTLE] * 2, dt)
        moved.append(plant.mass - before)
    np.testing.assert_allclose(moved[0], moved[1], rtol=2e-4)


@pytest.mark.parametrize(("delays", "pulse"), [((0.001, 0.004), 0.006), ((0.02, 0.04), 0.045)])
def test_a_choked_pulse_brings_its_time_times_the_flow_and_the_dead_volume(delays, pulse):
    p = even_box()
    box = replace(p, valve=replace(p.valve, opening_delay=delays, closing_delay=delays))
    plant = PneumaticPlant(["a"], [BOTTLE], box)
    before, valve = float(plant.mass[0]), plant._valves
    run(plant, pulse, [1], [BOTTLE])
    run(plant, 0.2, [0], [BOTTLE])
    duration = pulse + float(valve.closing_delay[1, 0] - valve.opening_delay[1, 0])
    flow = orifice_flow(401_300.0, AMBIENT_PRESSURE, 0.8 * np.pi / 4 * 0.2e-3**2)
    caught = 300e3 * p.choke.dead_volume / GAS
    assert float(plant.mass[0]) - before == pytest.approx(duration * flow + caught, rel=2e-3)


def filling_time(hand, box):
    """Time [s] from the command until all channels are at their pressure limits."""
    actuators = FreeActuators(hand)
    volumes = actuators.volumes(np.full(len(hand.channels), AMBIENT_PRESSURE))
    plant = PneumaticPlant(hand.channels, volumes, box)
    full = np.zeros(len(volumes), bool)
    while not full.all():
        volumes = volumes + 0.05 * (actuators.volumes(plant.pressures) - volumes)  # lag of 20 ms
        full |= (
            plant.step(1e-3, np.where(full, 0, 1), volumes)
            > AMBIENT_PRESSURE + hand.max_pressures()
        )
    return plant.time


def test_without_chokes_a_hand_is_filled_within_a_quarter_of_a_second():
    p = load_pneumatics()
    unchoked = replace(p, choke=replace(p.choke, inlet_diameter=0.01, outlet_diameter=0.01))
    assert 0.1 < filling_time(load_hand("rbo_hand_2"), unchoked) < 0.25


def history(seed, box=None):
    plant = PneumaticPlant(["a", "b"], [FINGER, FINGER], box, seed)
    readings = []
    for k in range(150):
        plant.step(2e-3, [1 if k % 50 < 30 else -1, 0], [FINGER, FINGER])
        readings.append(plant.read())
    return np.array(readings)


def test_a_seed_gives_the_same_run_and_another_one_another_run():
    np.testing.assert_array_equal(history(4), history(4))
    assert not np.array_equal(history(4), history(5))


def test_the_box_keeps_its_tolerances_whatever_the_seed_and_the_number_of_channels():
    assert abs(history(4)[-20:, 1].mean() - history(5)[-20:, 1].mean()) < 100.0
    other_box = replace(load_pneumatics(), box_seed=1)
    assert abs(history(4)[-20:, 1].mean() - history(4, other_box)[-20:, 1].mean()) > 100.0
    wide = PneumaticPlant(EIGHT, np.full(8, FINGER), seed=4)
    wide.step(0.3, [1, 1, 0, 0, 0, 0, 0, 0], np.full(8, FINGER))
    narrow = PneumaticPlant(["x", "y"], np.full(2, FINGER), seed=4)
    narrow.step(0.3, [1, 1], np.full(2, FINGER))
    np.testing.assert_allclose(wide.pressures[:2], narrow.pressures, rtol=2e-3)


def test_reset_gives_the_run_of_a_new_plant():
    plant = PneumaticPlant(["a"], [FINGER], seed=8)
    run(plant, 0.2, [1], [FINGER])
    first = plant.read()
    plant.reset()
    run(plant, 0.2, [1], [FINGER])
    np.testing.assert_array_equal(plant.read(), first)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((0.0, [0], [FINGER]), "dt must be above 0 s, got 0.0"),
        ((1e-3, [0, 1], [FINGER]), "valves must have shape (1,), got (2,)"),
        ((1e-3, [2], [FINGER]), "valves must be -1, 0 or 1, got 2"),
        ((1e-3, [float("nan")], [FINGER]), "valves must be -1, 0 or 1, got nan"),
        ((1e-3, [0], [FINGER, FINGER]), "volumes must have shape (1,), one for each"),
        ((1e-3, [0], [-FINGER]), "volumes must be above 0 m3"),
        ((1e-3, [0], [float("nan")]), "volumes must be above 0 m3"),
    ],
)
def test_a_step_that_cannot_be_is_refused(arguments, words):
    plant = PneumaticPlant(["a"], [FINGER])
    with pytest.raises(ValueError) as error:
        plant.step(*arguments)
    assert words in str(error.value)
    assert plant.time == 0.0


def test_more_channels_are_those_of_further_boxes():
    """The thirteen channels of two boxes: all inflate, and no channel is the copy of another."""
    names = [f"c{number}" for number in range(13)]
    plant = PneumaticPlant(names, np.full(13, FINGER))
    for _ in range(100):
        pressures = plant.step(0.001, np.ones(13), np.full(13, FINGER))
    assert np.all(pressures > 102e3)
    assert len(np.unique(pressures)) == 13
    with pytest.raises(ValueError, match="channels must be 1 to 64 names, got 65"):
        PneumaticPlant([f"c{number}" for number in range(65)], np.full(65, FINGER))
