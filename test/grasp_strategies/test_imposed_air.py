import math

import numpy as np
import pytest

from grasp_strategies.in_process_scene import SMALLEST_PULSE, ImposedAir
from pneumaticbox_driver.safety import PressureGuard
from softhand_model.pneumatics.parameters import load_pneumatics

AMBIENT = 101300.0
NO_LIMITS = np.full(3, np.inf)


def choked_flow(pressure, diameter, discharge):
    """Mass flow of a choked orifice [kg/s] from the textbook form with the speed of sound."""
    gamma, heat = 1.4, 287.05 * 293.15
    area = discharge * math.pi / 4 * diameter**2
    return (
        area
        * pressure
        * math.sqrt(gamma / heat)
        * (2 / (gamma + 1)) ** ((gamma + 1) / (2 * (gamma - 1)))
    )


def test_a_channel_fills_at_the_rate_of_the_inlet_choke():
    box = load_pneumatics()
    air = ImposedAir(NO_LIMITS[:2])
    air.command(np.array([1e-4, 0.0]))
    for _ in range(100):
        masses = air.advance(0.001, np.array([AMBIENT, AMBIENT]))
    expected = choked_flow(
        box.supply.pressure + AMBIENT,
        box.choke.inlet_diameter,
        np.mean(box.choke.discharge_coefficient),
    )
    assert masses[0] / 0.1 == pytest.approx(expected, rel=0.01)
    assert masses[1] == 0.0


def test_a_command_is_met_to_half_a_pulse_and_then_rests():
    wanted = np.array([4.1e-6, 1.37e-5, 2.5e-6])
    air = ImposedAir(NO_LIMITS)
    air.command(wanted)
    for _ in range(3000):
        masses = air.advance(0.001, np.full(3, AMBIENT))
    assert np.abs(masses - wanted).max() <= SMALLEST_PULSE / 2
    assert masses / SMALLEST_PULSE == pytest.approx(np.round(masses / SMALLEST_PULSE))
    assert air.advance(0.001, np.full(3, AMBIENT)).tolist() == masses.tolist()


def test_air_leaves_only_while_the_pressure_is_above_ambient():
    air = ImposedAir(NO_LIMITS[:1])
    air.masses = np.array([2e-5])
    air.command(np.zeros(1))
    before = air.masses[0]
    assert air.advance(0.001, np.array([150e3]))[0] < before
    before = air.masses[0]
    assert air.advance(0.001, np.array([AMBIENT]))[0] == before


def test_emptying_through_the_wide_choke_is_faster_than_filling():
    filled, emptied = ImposedAir(NO_LIMITS[:1]), ImposedAir(NO_LIMITS[:1])
    filled.command(np.array([1e-4]))
    emptied.masses = np.array([1e-4])
    emptied.command(np.zeros(1))
    gain = filled.advance(0.001, np.array([200e3]))[0]
    loss = 1e-4 - emptied.advance(0.001, np.array([200e3]))[0]
    assert loss > 3 * gain


VOLUME = 60e-6  # of a rigid bottle [m3]


def bottle_pressure(air):
    """Absolute pressures (channels,) [Pa] when each channel is a bottle."""
    return AMBIENT + air.masses * 287.05 * 293.15 / VOLUME


def follow(air, steps):
    """Absolute pressures (steps, channels) [Pa] of bottles."""
    found = []
    for _ in range(steps):
        air.advance(0.001, bottle_pressure(air))
        found.append(bottle_pressure(air))
    return np.array(found)


def test_a_channel_is_held_below_its_limit_whatever_is_commanded():
    air = ImposedAir(np.array([80e3, 250e3]))
    air.command(np.array([5e-4, 4e-5]))
    gauge = follow(air, 6000) - AMBIENT
    assert 80e3 < gauge[:, 0].max() < 81e3  # one step's air above the limit
    assert 0.96 * 80e3 < gauge[-1, 0] < 0.97 * 80e3
    assert gauge[-1, 1] == pytest.approx(4e-5 * 287.05 * 293.15 / VOLUME)
    assert np.ptp(gauge[4000:], axis=0).max() == 0.0  # control and relief do not take turns
    assert air.limited.tolist() == [True, False]


def test_the_limits_act_as_those_of_the_driver():
    """The same pressures shown to both: what the driver's guard forbids does not happen."""
    limits = np.array([80e3])
    air, guard = ImposedAir(limits), PressureGuard(limits)
    goal = np.array([5e-4])
    for k, gauge in enumerate([70e3, 81e3, 79e3, 77e3, 70e3, 70e3, 82e3, 60e3]):
        if k == 5:  # a new command
            air.command(goal)
            guard.unblock((0,))
        elif k == 0:
            air.command(goal)
        before = air.masses
        change = air.advance(0.001, np.array([AMBIENT + gauge])) - before
        assert (
            np.sign(change).tolist()
            == guard.apply(np.array([gauge]), goal, np.ones(1, np.int8)).tolist()
        )


def test_a_relieved_channel_fills_again_at_the_next_command():
    air = ImposedAir(np.array([80e3]))
    air.command(np.array([5e-4]))
    follow(air, 4000)
    assert air.limited.all()
    air.command(np.array([5e-5]))
    follow(air, 2000)
    assert air.masses[0] == pytest.approx(5e-5)


@pytest.mark.parametrize("masses", [np.zeros(3), np.array([np.nan, 0.0])])
def test_a_command_that_cannot_be_met_is_refused(masses):
    with pytest.raises(ValueError, match="air masses: expected 2 finite numbers"):
        ImposedAir(NO_LIMITS[:2]).command(masses)
