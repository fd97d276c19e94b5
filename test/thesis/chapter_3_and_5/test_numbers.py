"""The experiments of the thesis: what they take from it, and one independent number of each."""

import copy

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from softhand_model.hand.actuator import load_actuator
from softhand_model.hand.profile import ConstantProfile
from thesis.chapter_3_and_5 import (
    base_torque,
    blocked_force,
    discretisation,
    payload,
    straight_finger,
    wall_strain,
    wall_thickness,
)
from thesis.chapter_3_and_5.base_torque import gripped_part, pushed
from thesis.chapter_3_and_5.planar import planar_finger
from thesis.chapter_3_and_5.static_finger import blocked_finger, chain_of, line_of
from thesis.frame import NoParameters

SEGMENTS = 10


# ---------------------------------------------------------------- what the thesis states
def test_experiments_use_the_numbers_of_the_thesis():
    segments = discretisation.Parameters().segments
    assert sorted([*segments, discretisation.FINEST]) == [3, 5, 10, 20, 50]
    assert wall_thickness.Parameters().walls == (0.0025, 0.0035, 0.0045, 0.0055)
    assert base_torque.PRESSURE == 31e3
    assert np.degrees(base_torque.ANGLE) == pytest.approx(90.0)
    assert payload.Parameters().mass == 0.5


def test_the_finger_of_the_base_torque_is_one_of_the_thesis_and_bends_by_about_the_stated_angle():
    finger = base_torque.actuator()
    assert finger.wall == ConstantProfile(0.0025)
    assert finger.shear_modulus == pytest.approx(73.7e3)
    assert np.degrees(finger.tip_angle(base_torque.PRESSURE)) == pytest.approx(95.3, abs=0.05)


def test_the_force_of_a_blocked_tip_is_told_without_a_gap(small):
    """Held where the straight finger has it; 15 mm off it pushes less, and the row says so."""
    results, report = small("blocked_force")
    finger = load_actuator("P10.finger")
    told = {row.what: row.ours for row in report.findings}
    segments = blocked_force.SMALL["segments"]
    held = [blocked_finger(finger, segments, p, 0.0).tip_force for p in (20e3, 30e3, 50e3)]
    assert told["force at 20, 30, 50 kPa, tip held"] == ", ".join(f"{f:.2f}" for f in held) + " N"
    off = "force at 20, 30, 50 kPa, simulator, block 15 mm off"
    assert float(told[off].split(",")[0]) < 0.85 * held[0]
    assert results["bulge"][-1] > 0.001


def test_walls_of_the_rubber_that_the_thesis_fitted():
    """Section 5.2.2: 1.1 times 67 kPa, on top and at the sides."""
    finger = wall_thickness.actuator_of(0.0045)
    assert finger.shear_modulus == pytest.approx(73.7e3)
    assert finger.wall == finger.side_wall == ConstantProfile(0.0045)


# ---------------------------------------------------------------- independent numbers
def stretch_under(load):
    """Root u of u - u**-3 = load, eq. 3.21."""
    return brentq(lambda u: u - u**-3.0 - load, 1.0, 1.0 + load)


def test_tip_angle_of_a_wall_is_the_integral_of_the_root_of_the_moment_balance():
    finger, pressure = wall_thickness.actuator_of(0.0025), 46.3e3

    def curvature(x):
        load = finger.side_wall_ratio(x) * pressure * finger.height(x) / (4 * 73.7e3 * 0.0025)
        return (stretch_under(float(load)) - 1.0) / float(finger.height(x))

    expected = quad(curvature, 0.0, 0.090)[0]
    found = wall_thickness.bent(finger, 10)["simulated"][-1]
    assert found == pytest.approx(expected, rel=1e-4)


def test_left_is_left_of_a_finger_that_points_away_and_bends_upwards():
    """Forward times up is right; the force of a push r x F on the base follows."""
    chain = gripped_part(chain_of(base_torque.actuator(), 6).segments)
    rest = np.full(5, np.pi / 2 / 6)
    start = pushed(chain, rest, base_torque.UP, 0.0).place
    up, forward = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
    assert start @ up > 0.0
    right = np.cross(forward, up)
    directions = {"left": -right, "right": right, "down": -up, "up": up}
    for name, direction in base_torque.PUSHES:
        way = pushed(chain, rest, direction, 0.01).place - start
        assert way @ directions[name] == pytest.approx(0.01, abs=1e-6)
    axes = np.eye(3)[[base_torque.AXES[name] for name in "xyz"]]
    assert axes == pytest.approx(np.array([right, forward, up]))


def test_blocked_force_of_a_stiff_finger_is_that_of_a_propped_beam():
    """Little pressure, its tip kept where it is: F = sum of moments over levers, by hand."""
    finger = load_actuator("P10.finger")
    model = chain_of(finger, SEGMENTS)
    compliance = 1.0 / model.segments.stiffness[:, 1]
    lever = 0.09 * (1.0 - (np.arange(SEGMENTS) + 0.5) / SEGMENTS)
    rest = model.rest_rotation([1e3])[:, 1]
    expected = rest @ lever / (compliance @ lever**2)
    assert blocked_finger(finger, 10, 1e3, 0.0).tip_force == pytest.approx(expected, rel=1e-3)


def test_the_finger_that_stays_straight_is_half_as_stiff_half_way():
    finger = straight_finger.tapered()
    share = finger.stiffness(0.045) / finger.stiffness(0.0)
    edge = 0.5 ** (1 / 3)
    ratio = finger.side_wall_ratio(0.0) / finger.side_wall_ratio(0.045)
    assert share == pytest.approx(edge**3 * ratio, rel=1e-3)


def test_error_of_the_approximation_at_the_least_pressure(small):
    """5.3 by its printed closed form, the exact one by its root."""
    results, report = small("approximation")
    u = 0.3
    exact = stretch_under(2.0 * u) - 1.0
    printed = float(np.interp(u, results["u"], results["printed"]))
    assert f"{100.0 * (printed / exact - 1.0):+.1f} %" in report.findings[0].ours


@pytest.mark.parametrize("bend", ["0.25", "2"])
def test_mean_energy_of_a_wall_is_the_integral_over_the_rubber(bend, small):
    def invariant(v):
        kept = v**2 / 2 + float(bend) / 3
        u = brentq(lambda u: u**2 / 2 + float(bend) * u**3 / 3 - kept, 0.0, 1.0)
        along, around = 1.0 + float(bend) * u, u / v
        return along**2 + around**2 + (along * around) ** -2 - 3.0

    mean = quad(lambda v: v * invariant(v), 0.5, 1.0)[0] / quad(lambda v: v, 0.5, 1.0)[0]
    expected = mean / invariant(1.0) - 1.0
    found = wall_strain.energy_error(small("wall_strain")[0], bend)
    assert found == pytest.approx(expected, abs=1e-4)


def test_the_verdict_on_wall_strain_follows_its_figures(small):
    results, report = small("wall_strain")
    assert "is sound up to" in report.conclusion and "+68 % (kappa*h = 0.25)" in report.conclusion
    results = copy.deepcopy(results)
    results["curves"]["1"]["invariant"] = [9.0] * 61
    report = wall_strain.report(results, NoParameters())
    assert "is not sound up to" in report.conclusion and not all(report.judged)


# ---------------------------------------------------------------- free tips at every pressure
def arc_tip(bend, length):
    return np.array([(1.0 - np.cos(bend)) / bend, np.sin(bend) / bend]) * length


@pytest.mark.parametrize("pressure", [60e3, 200e3, 250e3])
def test_free_tip_of_an_even_finger_is_at_a_closed_form_distance_from_the_arc(pressure):
    """The chain's links are tangents of a circle: its tip is at half a segment's bend over the
    tangent of it, times the arc's.
    """
    actuator = load_actuator("P5")
    bend = float(actuator.tip_angle(pressure))
    for count in (10, 50):
        half = bend / count / 2.0
        expected = half / np.tan(half) * arc_tip(bend, 0.120)
        found = discretisation.free_tips(actuator, count, np.array([pressure]))[0]
        assert found == pytest.approx(expected, abs=1e-9)


def test_free_tips_are_those_of_the_chain_of_the_simulator():
    actuator = load_actuator("P10.thumb")
    model = chain_of(actuator, 7)
    line = line_of(planar_finger(model.segments), model.rest_rotation([80e3])[:, 1])
    found = discretisation.free_tips(actuator, 7, np.array([80e3]))[0]
    assert found == pytest.approx(line[-1], abs=1e-7)


def test_one_percent_holds_in_a_part_of_the_range_and_the_sweep_tells_which():
    swept = discretisation.sweep(load_actuator("P10.finger"), [10], 50)
    off = np.interp([40e3, 72e3], swept["pressure"], swept["off"]["10"])
    assert off == pytest.approx([0.57, 1.46], abs=0.01)
    limit = discretisation.holds_up_to(swept, 10)
    assert 40e3 < limit < 72e3
    assert discretisation.worst(swept, 10)[0] > 1.4
    at = swept["pressure"].index(limit)
    assert swept["enough"][at] <= 10 < swept["enough"][at + 1]
    finer = discretisation.sweep(load_actuator("P10.finger"), [swept["enough"][-1]], 50)
    assert discretisation.worst(finer, swept["enough"][-1])[0] <= 1.0
