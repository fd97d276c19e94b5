"""Actuators of chapter 7: their data, and integrals over them against scipy's quadrature."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from softhand_model.hand import section
from softhand_model.hand.actuator import actuator_names, load_actuator
from softhand_model.hand.profile import ConstantProfile, TableProfile, TaperedProfile

NAMES = [
    "P5",
    "P10.finger",
    "P10.thumb",
    "P10.PalmInner",
    "P10.PalmOuter",
    "P5.proximal",
    "P5.distal",
]
HEADER = "format: softhand-actuators/1\nshear_modulus: 67000.0\ndensity: 1070.0\nactuators:\n"
BLOCK = "  box: {length: 0.1, height: 0.02, width: 0.02, wall: 0.002, side_wall: 0.002, "


def test_shipped_actuators_are_those_of_chapter_7():
    assert actuator_names() == NAMES


@pytest.mark.parametrize(
    ("name", "length", "largest", "wall"),
    [
        ("P5", 0.120, 0.009, 0.003),
        ("P10.finger", 0.090, 0.020, 0.002),
        ("P10.thumb", 0.070, 0.025, 0.00346),
        ("P10.PalmInner", 0.0375 * np.pi / 2, 0.025, 0.00346),
        ("P10.PalmOuter", 0.0625 * np.pi / 2, 0.025, 0.00576),
    ],
)
def test_dimensions_of_table_7_1(name, length, largest, wall):
    actuator = load_actuator(name)
    x = np.linspace(0, actuator.length, 50)
    assert actuator.length == pytest.approx(length)
    assert actuator.height(x).max() == actuator.width(x).max() == largest
    assert actuator.circumference(x).max() == pytest.approx(4 * largest)
    assert actuator.wall == actuator.side_wall == ConstantProfile(wall)
    assert actuator.shear_modulus == 67e3


def test_p10_finger_tapers_as_section_7_3_says():
    finger = load_actuator("P10.finger")
    x = 0.06
    assert finger.height(x) == pytest.approx(0.02 * (1 - 0.925 * 2 / 3) ** (1 / 3))
    assert finger.width(x) == pytest.approx(0.02 * (1 - 0.925 * 2 / 3) ** (1 / 8))
    assert finger.circumference(x) == pytest.approx(0.08 * (1 / 3) ** (1 / 3))
    assert finger.circumference(0.09) == 0.0


def test_p5_chamber_holds_what_its_walls_leave():
    assert load_actuator("P5").chamber_volume() * 1e6 == pytest.approx(2.16)
    bare = replace(load_actuator("P5"), side_wall=ConstantProfile(0.0))
    assert bare.chamber_volume() * 1e6 == pytest.approx(6.48)


def test_walls_of_the_palm_are_in_the_ratio_of_its_radii():
    """By the rule, equal pressure then bends both arcs by equal angles (kappa ~ 1/r)."""
    inner, outer = load_actuator("P10.PalmInner"), load_actuator("P10.PalmOuter")
    walls = outer.wall(0.0) / inner.wall(0.0)
    assert walls == pytest.approx(outer.arc_radius / inner.arc_radius, rel=2e-3)
    angles = [
        30e3 * section.rule_actuation_ratio(arc.wall(0.0), arc.shear_modulus) * arc.length
        for arc in (inner, outer)
    ]
    assert angles[0] == pytest.approx(angles[1], rel=2e-3)


def test_palm_arcs_bend_nearly_alike_at_equal_pressure_in_the_exact_form():
    inner, outer = load_actuator("P10.PalmInner"), load_actuator("P10.PalmOuter")
    pressure = np.array([5e3, 15e3, 30e3])
    assert inner.tip_angle(pressure) == pytest.approx(outer.tip_angle(pressure), rel=0.08)


def test_palm_is_twice_as_stiff_as_a_finger_by_its_size_alone():
    finger, palm = load_actuator("P10.finger"), load_actuator("P10.PalmInner")
    bare = [
        section.rule_stiffness(part.circumference(0.0) / 4, 1.0, 1.0) for part in (finger, palm)
    ]
    assert bare[1] / bare[0] == pytest.approx((25 / 20) ** 3)
    assert bare[1] / bare[0] == pytest.approx(2.0, abs=0.05)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("pressure", [5e3, 40e3])
def test_tip_angle_is_the_integral_of_the_free_curvature(name, pressure):
    actuator = load_actuator(name)
    exact, _ = quad(lambda x: float(actuator.free_curvature(pressure, x)), 0, actuator.length)
    assert actuator.tip_angle(pressure) == pytest.approx(exact, rel=1e-9)


def test_tip_angle_with_the_height_profile_and_square_sections():
    """Check value: 114.6 deg at 31 kPa, G = 73.7 kPa, width equal to the height."""
    finger = load_actuator("P10.finger").with_modulus(1.1)
    square = replace(finger, width=finger.height)
    assert np.degrees(square.tip_angle(31e3)) == pytest.approx(114.6, abs=0.05)


def test_finger_of_constant_section_bends_to_the_check_value():
    block = ConstantProfile(0.02)
    finger = replace(load_actuator("P10.finger"), height=block, width=block).with_modulus(1.1)
    assert np.degrees(finger.tip_angle(31e3)) == pytest.approx(122.2, abs=0.05)


def test_suction_does_not_bend():
    assert load_actuator("P10.finger").tip_angle(np.array([-5e3, 0.0])) == pytest.approx([0.0, 0.0])


def test_stiffness_falls_nearly_linearly_to_nothing_at_the_tip():
    finger = load_actuator("P10.finger")
    x = np.linspace(0, 0.09, 10)
    rule = 2 * 67e3 * 0.002 * (finger.circumference(x) / 4) ** 3
    assert rule == pytest.approx(rule[0] * (1 - x / 0.09), abs=1e-12)
    assert finger.stiffness(x) == pytest.approx(2 / finger.side_wall_ratio(x) * rule)


def test_linear_springs_hold_a_blocked_section_like_the_exact_one():
    """B*kappa against h**2*z*p/2: half of it at small pressure, equal where the secant is 1."""
    block = replace(
        load_actuator("P10.finger"),
        height=ConstantProfile(0.02),
        width=ConstantProfile(0.02),
        circumference=ConstantProfile(0.08),
    )

    def share(pressure):
        moment = block.stiffness(0.0) * block.free_curvature(pressure, 0.0)
        return moment / section.bending_moment(pressure, 0.0, 0.02, 0.02, 0.002, 0.002, 67e3)

    assert share(1.0) == pytest.approx(0.5, abs=1e-3)
    assert share(1e7) == pytest.approx(2.0, abs=0.05)


@pytest.mark.parametrize("name", ["P10.finger", "P10.thumb"])
def test_chamber_volume_grows_by_the_gain(name):
    actuator = load_actuator(name)
    gain, _ = quad(lambda x: float(actuator.chamber_volume_gain(x)), 0, actuator.length)
    grown = actuator.chamber_volume(10.0) - actuator.chamber_volume(0.0)
    assert grown == pytest.approx(10.0 * gain, rel=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_mass_is_that_of_the_rubber_and_adds_up(name):
    actuator = load_actuator(name)

    def area(x):
        h, z, d, side = (float(size) for size in actuator.sides(x))
        return z * d + max(h - d, 0) * 2 * side

    volume, _ = quad(area, 0, actuator.length)
    assert actuator.mass == pytest.approx(1070 * volume, rel=1e-9)
    parts = [
        actuator.mass_between(a, a + actuator.length / 4)
        for a in np.arange(4) * actuator.length / 4
    ]
    assert sum(parts) == pytest.approx(actuator.mass, rel=1e-9)


@pytest.mark.parametrize("name", [name for name in NAMES if name.startswith("P10")])
def test_pressure_limit_of_p10_keeps_the_rubber_below_a_third_of_its_stretch(name):
    actuator = load_actuator(name)
    curvature = actuator.free_curvature(actuator.max_pressure, 0.0)
    assert 1 + curvature * actuator.height(0.0) == pytest.approx(0.3 * 11, abs=0.05)


def test_four_walls_bend_constantly_by_the_rule_and_not_exactly():
    """Section 3.5.1: the rule lets a tapered finger bend to a circle; the exact form nearly."""
    x = np.linspace(0, 0.09, 10)
    for wall in (2.5e-3, 3.5e-3, 4.5e-3, 5.5e-3):
        hull = ConstantProfile(wall)
        finger = replace(load_actuator("P10.finger"), wall=hull, side_wall=hull)
        curvature = finger.free_curvature(46.3e3, x)
        assert 0.0 < curvature[-1] / curvature[0] - 1 < 0.25


def test_unknown_actuator_is_answered_with_the_names():
    with pytest.raises(ValueError, match=r"P5, P10.finger, .* got P11"):
        load_actuator("P11")


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (
            BLOCK + "max_pressure: -1}",
            "box.max_pressure: expected a number from 1000 to 1e+07 Pa, got -1",
        ),
        (BLOCK + "max_pressure: 1, colour: 2}", "got colour"),
        (BLOCK + "max_pressure: 1, arc_radius: 2}", "expected length, or arc_radius and arc_angle"),
        (BLOCK.replace("length: 0.1, ", "") + "max_pressure: 1}", "got none of them"),
        (BLOCK.replace("0.02,", "[[0, 1], [0, 2]],") + "max_pressure: 1}", "growing x"),
        (BLOCK.replace("0.02,", "{maximum: 0.1},") + "max_pressure: 1}", "expected the key taper"),
        ("  box: 3", "actuators.box: expected a mapping, got 3"),
    ],
)
def test_bad_actuator_is_named(tmp_path, body, message):
    path = tmp_path / "actuators.yaml"
    path.write_text(HEADER + body + "\n", encoding="utf-8")
    with pytest.raises(ValueError) as caught:
        load_actuator("box", path)
    assert str(path) in str(caught.value)
    assert message in str(caught.value)


def test_profiles_from_a_table_and_the_default_circumference(tmp_path):
    path = tmp_path / "actuators.yaml"
    body = BLOCK.replace("height: 0.02", "height: [[0, 0.03], [0.1, 0.01]]") + "max_pressure: 1e5}"
    path.write_text(HEADER + body, encoding="utf-8")
    box = load_actuator("box", path)
    assert box.height([0.0, 0.05, 0.2]) == pytest.approx([0.03, 0.02, 0.01])
    assert box.circumference(0.05) == pytest.approx(0.08)


def test_taper_and_table_hold_their_ends():
    assert TaperedProfile(2.0, 1.0, 1.0, 3)([-1.0, 2.0]) == pytest.approx([2.0, 0.0])
    with pytest.raises(ValueError, match="growing x"):
        TableProfile((0.0, 0.0), (1.0, 2.0))
