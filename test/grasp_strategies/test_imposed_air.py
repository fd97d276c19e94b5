import math

import numpy as np
import pytest

from grasp_strategies.imposed_air import SMALLEST_PULSE, ImposedAir
from softhand_model.pneumatics.parameters import load_pneumatics

AMBIENT = 101300.0


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
    air = ImposedAir(2)
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
    air = ImposedAir(3)
    air.command(wanted)
    for _ in range(3000):
        masses = air.advance(0.001, np.full(3, AMBIENT))
    assert np.abs(masses - wanted).max() <= SMALLEST_PULSE / 2
    assert masses / SMALLEST_PULSE == pytest.approx(np.round(masses / SMALLEST_PULSE))
    assert air.advance(0.001, np.full(3, AMBIENT)).tolist() == masses.tolist()


def test_air_leaves_only_while_the_pressure_is_above_ambient():
    air = ImposedAir(1)
    air.masses = np.array([2e-5])
    air.command(np.zeros(1))
    before = air.masses[0]
    assert air.advance(0.001, np.array([150e3]))[0] < before
    before = air.masses[0]
    assert air.advance(0.001, np.array([AMBIENT]))[0] == before


def test_emptying_through_the_wide_choke_is_faster_than_filling():
    filled, emptied = ImposedAir(1), ImposedAir(1)
    filled.command(np.array([1e-4]))
    emptied.masses = np.array([1e-4])
    emptied.command(np.zeros(1))
    gain = filled.advance(0.001, np.array([200e3]))[0]
    loss = 1e-4 - emptied.advance(0.001, np.array([200e3]))[0]
    assert loss > 3 * gain


@pytest.mark.parametrize("masses", [np.zeros(3), np.array([np.nan, 0.0])])
def test_a_command_that_cannot_be_met_is_refused(masses):
    with pytest.raises(ValueError, match="air masses: expected 2 finite numbers"):
        ImposedAir(2).command(masses)
