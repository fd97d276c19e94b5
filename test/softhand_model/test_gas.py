"""Air: gas law, flow function, orifice and line against closed forms and integration."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from softhand_model.gas import (
    AMBIENT_PRESSURE,
    CRITICAL_RATIO,
    GAS_CONSTANT,
    ROOM_TEMPERATURE,
    VISCOSITY,
    air_mass,
    line_conductance,
    orifice_flow,
    psi,
)

KAPPA = 1.4
HOLE = np.pi / 4 * 0.2e-3**2


def test_a_litre_of_room_air_weighs_what_tables_say():
    assert float(air_mass(101_325.0, 1e-3)) == pytest.approx(1.2041e-3, rel=1e-4)


def test_critical_ratio_is_that_of_the_thesis():
    assert pytest.approx(1.894, abs=1.5e-3) == 1 / CRITICAL_RATIO
    assert pytest.approx(0.5283, abs=5e-5) == CRITICAL_RATIO


def test_psi_at_sonic_flow_has_its_closed_form_and_stays_there():
    sonic = (2 / (KAPPA + 1)) ** (1 / (KAPPA - 1)) * np.sqrt(KAPPA / (KAPPA + 1))
    assert sonic == pytest.approx(0.484, abs=5e-4)
    np.testing.assert_allclose(psi(np.array([0.01, 0.3, CRITICAL_RATIO])), sonic, rtol=1e-9)


def test_psi_follows_the_text_with_3_5_under_the_root_and_not_7_0():
    ratio = np.linspace(0.55, 0.99, 12)
    text = np.sqrt(3.5 * (ratio ** (2 / 1.4) - ratio ** (2.4 / 1.4)))
    np.testing.assert_allclose(psi(ratio), text, rtol=1e-9)
    assert np.sqrt(7.0 / 3.5) * float(psi(0.5)) == pytest.approx(0.685, abs=5e-4)


def test_psi_ends_at_no_pressure_drop_and_lets_nothing_flow_back():
    np.testing.assert_array_equal(psi(np.array([1.0, 1.3])), 0.0)


def test_choked_flow_is_that_of_the_textbook():
    factor = (2 / (KAPPA + 1)) ** ((KAPPA + 1) / (2 * (KAPPA - 1)))
    textbook = HOLE * 4e5 * np.sqrt(KAPPA / (GAS_CONSTANT * ROOM_TEMPERATURE)) * factor
    assert float(orifice_flow(4e5, 1.5e5, HOLE)) == pytest.approx(textbook, rel=1e-9)


def test_a_small_drop_gives_the_flow_of_an_incompressible_fluid():
    drop = 20.0
    density = AMBIENT_PRESSURE / (GAS_CONSTANT * ROOM_TEMPERATURE)
    bernoulli = HOLE * np.sqrt(2 * density * drop)
    flow = float(orifice_flow(AMBIENT_PRESSURE + drop, AMBIENT_PRESSURE, HOLE))
    assert flow == pytest.approx(bernoulli, rel=1e-3)


def test_line_conductance_agrees_with_integrating_poiseuille_along_the_tube():
    diameter, length, flow = 0.5e-3, 0.7, 5e-6

    def gradient(_, pressure):
        density = pressure / (GAS_CONSTANT * ROOM_TEMPERATURE)
        return -128 * VISCOSITY * flow / (np.pi * diameter**4 * density)

    end = solve_ivp(gradient, (0, length), [200e3], rtol=1e-9, atol=1e-3).y[0, -1]
    conductance = float(line_conductance(diameter, length))
    assert conductance * (200e3**2 - end**2) == pytest.approx(flow, rel=1e-6)
