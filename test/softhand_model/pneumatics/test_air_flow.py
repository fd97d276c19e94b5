"""Flow through an orifice and a line in series: what it solves, and the exact solution."""

import numpy as np
import pytest
from scipy.optimize import brentq

from softhand_model.gas import (
    AMBIENT_PRESSURE,
    line_conductance,
    orifice_conductance,
    orifice_flow,
    psi,
)
from softhand_model.pneumatics.air_flow import series_flow

HOLE = np.pi / 4 * 0.2e-3**2


def exact_series_flow(p_in, p_out, orifice, line):
    """Solve for the pressure between the two elements, without the closed form."""

    def mismatch(between):
        through_orifice = orifice * p_in * float(psi(between / p_in))
        return through_orifice - line * (between**2 - p_out**2)

    between = brentq(mismatch, p_out, p_in)
    return line * (between**2 - p_out**2)


@pytest.mark.parametrize("diameter", [0.4e-3, 0.5e-3, 2e-3])
@pytest.mark.parametrize("p_in", [105e3, 140e3, 300e3])
def test_orifice_and_line_in_series_stay_near_the_exact_solution(p_in, diameter):
    orifice = float(orifice_conductance(0.8 * np.pi / 4 * 0.6e-3**2))
    line = float(line_conductance(diameter, 0.6))
    exact = exact_series_flow(p_in, AMBIENT_PRESSURE, orifice, line)
    assert series_flow(p_in, AMBIENT_PRESSURE, orifice, line) == pytest.approx(exact, rel=0.06)


@pytest.mark.parametrize("p_in", [105e3, 180e3, 400e3])
@pytest.mark.parametrize("diameter", [0.1e-3, 0.4e-3, 2e-3])
def test_drops_of_squared_pressure_of_orifice_and_line_add(p_in, diameter):
    line = float(line_conductance(diameter, 0.6))
    flow = series_flow(p_in, AMBIENT_PRESSURE, float(orifice_conductance(HOLE)), line)
    by_orifice = float(orifice_flow(p_in, AMBIENT_PRESSURE, HOLE))
    by_line = line * (p_in**2 - AMBIENT_PRESSURE**2)
    assert (flow / by_orifice) ** 2 + flow / by_line == pytest.approx(1.0, rel=1e-9)


def test_series_flow_passes_less_than_either_element_and_nothing_without_a_drop():
    orifice, line = float(orifice_conductance(HOLE)), float(line_conductance(0.4e-3, 0.6))
    both = series_flow(3e5, 2e5, orifice, line)
    assert 0 < both < min(float(orifice_flow(3e5, 2e5, HOLE)), line * (9e10 - 4e10))
    assert series_flow(2e5, 2e5, orifice, line) == 0.0
