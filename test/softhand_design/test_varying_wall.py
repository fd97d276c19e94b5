"""Walls and sections from profiles of actuation ratio and stiffness, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest

from softhand_design.castable import LEAST_WALL
from softhand_design.design_rules import allowed
from softhand_design.hand_file import finger_text
from softhand_design.requirements import RequirementError, Requirements, stations
from softhand_design.sizing import design_actuator, rank_rubbers
from softhand_design.varying_wall import LARGEST_SLOPE
from softhand_model.hand import section
from softhand_model.hand.actuator import load_actuator
from softhand_model.hand.hand import load_hand
from softhand_model.hand.profile import ConstantProfile, TableProfile
from softhand_model.hand.rubber import Rubber, load_rubbers

DRAGON_SKIN = Rubber("Dragon Skin 10", "Smooth-On", "", 11.0, 67e3, 1070.0)
X = np.linspace(0.0, 0.09, 181)


def line(first, last, length=0.09):
    return TableProfile((0.0, length), (first, last))


FINGER = Requirements(line(0.7e-3, 1.1e-3), line(4e-3, 1.5e-3), 0.09, DRAGON_SKIN)


def broken_by(wanted):
    return {broken.rule: broken for broken in design_actuator(wanted).broken}


@pytest.mark.parametrize(
    "name", ["P10.finger", "P10.thumb", "P10.PalmInner", "P10.PalmOuter", "P5"]
)
def test_a_shipped_actuator_comes_back_from_its_own_profiles(name):
    shipped = load_actuator(name)
    wanted = Requirements(shipped.actuation_ratio, shipped.stiffness, shipped.length, DRAGON_SKIN)
    found = design_actuator(wanted).actuator
    x = np.linspace(0.0, shipped.length, 181)
    assert found.wall(x) == pytest.approx(shipped.wall(x), rel=5e-3)
    largest = shipped.circumference(x).max()
    assert found.circumference(x).max() == pytest.approx(largest, rel=5e-3)
    for key in ("height", "width", "actuation_ratio"):
        assert getattr(found, key)(x) == pytest.approx(getattr(shipped, key)(x), rel=1e-2)
    stiff = shipped.stiffness(x) > 1e-3 * shipped.stiffness(0.0)
    assert found.stiffness(x)[stiff] == pytest.approx(shipped.stiffness(x)[stiff], rel=1e-2)


def test_ratio_and_stiffness_follow_their_profiles_in_the_file_that_is_written(tmp_path):
    path = tmp_path / "finger.yaml"
    path.write_text(finger_text(design_actuator(FINGER).actuator), encoding="utf-8")
    finger = load_hand(path).chain("finger").actuators["finger"]
    assert finger.actuation_ratio(X) == pytest.approx(FINGER.ratio(X), rel=1e-3)
    assert finger.stiffness(X) == pytest.approx(FINGER.stiffness(X), rel=1e-3)
    assert finger.wall(0.0) > 1.5 * finger.wall(0.09)


def test_curvature_at_the_stretch_of_the_rule_is_the_ratio_times_the_pressure():
    """Where lambda + lambda**-3 = 2 the exact free bending has the rule's slope, at any wall."""
    finger = design_actuator(FINGER).actuator
    stretch = max(np.roots([1, -1, -1, -1]).real)
    for x in (0.0, 0.03, 0.09):
        curvature = (stretch - 1.0) / float(finger.height(x))
        pressure = curvature / float(FINGER.ratio(x))
        assert float(finger.free_curvature(pressure, x)) == pytest.approx(curvature, rel=1e-3)


def test_walls_of_arcs_for_curvatures_as_the_inverse_radius_are_those_of_the_palm_by_the_rule():
    """Section 7.3. Side walls, which the rule leaves out, would ask for a thicker outer wall."""
    radii, walls = (0.0375, 0.0625), []
    for radius in radii:
        ratio = 0.0375 / radius / (8.0 * 67e3 * 0.00346)
        wanted = Requirements(ConstantProfile(ratio), ConstantProfile(7e-3), radius, DRAGON_SKIN)
        design = design_actuator(replace(wanted, arc_radius=radius))
        walls.append(
            (
                float(design.sizes_without_side_walls(np.zeros(1))[0, 0]),
                float(design.actuator.wall(0.0)),
            )
        )
        assert walls[-1][0] == pytest.approx(1.0 / (8.0 * 67e3 * ratio))
    (inner, inner_solved), (outer, outer_solved) = walls
    assert outer / inner == pytest.approx(5.76 / 3.46, rel=1e-2)
    assert outer_solved / inner_solved > 1.05 * outer / inner


def test_an_aspect_and_a_side_share_are_kept():
    wanted = replace(FINGER, aspect=line(1.0, 1.3), side_share=0.5)
    finger = design_actuator(wanted).actuator
    height, width, wall, side_wall = finger.sides(X)
    assert width / height == pytest.approx(wanted.aspect(X), rel=1e-3)
    assert side_wall == pytest.approx(0.5 * wall, rel=1e-3)
    assert finger.actuation_ratio(X) == pytest.approx(wanted.ratio(X), rel=1e-3)
    assert finger.circumference(X) == pytest.approx(2.0 * (height + width), rel=1e-3)
    assert finger.stiffness(X) == pytest.approx(wanted.stiffness(X), rel=2e-3)


def test_a_jump_of_the_stiffness_is_smoothed_to_a_section_that_can_be_cast_and_told():
    jump = TableProfile((0.0, 0.044, 0.0445, 0.09), (4e-3, 4e-3, 1e-3, 1e-3))
    design = design_actuator(replace(FINGER, stiffness=jump, aspect=ConstantProfile(1.0)))
    for side in (design.actuator.height, design.actuator.width):
        assert np.abs(np.diff(side(X)) / np.diff(X)).max() <= 1.02 * LARGEST_SLOPE
    assert {b.rule: b for b in design.broken}[2].place == pytest.approx(0.0445, abs=1e-3)


def test_a_jump_of_the_ratio_is_smoothed_to_a_wall_that_can_be_cast():
    jump = TableProfile((0.0, 0.044, 0.046, 0.09), (0.6e-3, 0.6e-3, 1.2e-3, 1.2e-3))
    design = design_actuator(replace(FINGER, ratio=jump))
    slope = np.diff(design.actuator.wall(X)) / np.diff(X)
    assert np.abs(slope).max() == pytest.approx(LARGEST_SLOPE, rel=0.05)
    assert 0.04 < {b.rule: b for b in design.broken}[1].place < 0.06
    assert design.actuator.stiffness(X) == pytest.approx(FINGER.stiffness(X), rel=2e-2)


def test_rules_are_broken_at_their_place():
    assert broken_by(replace(FINGER, aspect=ConstantProfile(1.0))) == {}
    assert broken_by(FINGER)[3].place == pytest.approx(0.09)
    # with P10's tapers the tip is wider than the required stiffness would have it
    assert broken_by(FINGER)[2].place == pytest.approx(0.09)
    assert "stiffness as cast expected" in str(broken_by(FINGER)[2])
    assert broken_by(replace(FINGER, aspect=line(1.0, 0.7)))[3].place == pytest.approx(0.09)
    thick = replace(FINGER, ratio=line(0.45e-3, 0.33e-3), stiffness=line(3e-3, 3e-3))
    assert broken_by(thick)[4].value > 0.5 and broken_by(thick)[4].place == pytest.approx(0.09)


def test_p5_at_210_kpa_is_stretched_beyond_the_range_of_the_model():
    p5 = load_actuator("P5")
    wanted = Requirements(p5.actuation_ratio, p5.stiffness, p5.length, DRAGON_SKIN, pressure=210e3)
    broken = broken_by(wanted)["of the model"]
    stretch = 1.0 + 0.009 * float(p5.free_curvature(210e3, 0.0))
    assert broken.value == pytest.approx(stretch, rel=1e-3)
    assert "stretch expected at most 3, got 3.28" in str(broken)
    assert set(broken_by(replace(wanted, pressure=250e3))) == {"in use", "of the model"}


def test_the_largest_curvature_sets_the_pressure_that_it_needs():
    finger = design_actuator(replace(FINGER, curvature=60.0)).actuator
    assert finger.free_curvature(finger.max_pressure, X).max() == pytest.approx(60.0, rel=1e-3)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"ratio": line(0.1e-3, 0.3e-3)}, "ratio_profile at 0 mm: expected above 0.000"),
        ({"ratio": line(0.6e-3, 3e-3)}, "ratio_profile at 90 mm: expected at most 0.00"),
        (
            {"rubber": load_rubbers()["Dragon Skin 30"], "ratio": line(3e-3, 3e-3)},
            "expected at mos",
        ),
        ({"length": 0.012}, "length: expected above 0.01"),
        ({"ratio": line(0.0, 1e-3)}, "ratio_profile: expected numbers above 0 1/(m Pa), got 0"),
        ({"stiffness": line(1e-3, -1e-3)}, "stiffness_profile: expected numbers of 0 N m2 or more"),
        ({"side_share": 0.0}, "side_share: expected a number above 0, got 0"),
        ({"curvature": 60.0, "pressure": 20e3}, "pressure: expected at least 5.3"),
        ({"curvature": 500.0}, "curvature: expected at most 301.3 1/m, which"),
        ({"pressure": 1e6}, "pressure: expected at most "),
    ],
)
def test_what_cannot_be_had_is_refused_with_the_bound(change, words):
    with pytest.raises(RequirementError) as caught:
        design_actuator(replace(FINGER, **change))
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("change", "key", "off"),
    [
        ({"ratio": line(0.2e-3, 0.2e-3)}, "ratio", 1e-3),
        ({"ratio": line(4e-3, 4e-3)}, "ratio", -1e-3),
        ({"ratio": line(1.942e-3, 1.942e-3)}, "ratio", -1e-3),
        ({"side_share": 0.1}, "side_share", 1e-3),
        ({"curvature": 500.0}, "curvature", -1e-3),
        ({"curvature": 500.0, "pressure": 20e3}, "curvature", -1e-3),
        ({"pressure": 1e6}, "pressure", -1e-3),
        ({"curvature": 60.0, "pressure": 20e3}, "pressure", 1e-3),
    ],
)
def test_the_bound_that_is_named_would_do_as_it_is_printed_and_less_would_not(change, key, off):
    wanted = replace(FINGER, **change)
    with pytest.raises(RequirementError) as caught:
        design_actuator(wanted)
    printed = allowed(caught.value.bound, caught.value.expected)
    for factor, fits in ((1.0, True), (1.0 - off, False)):
        bound = factor * printed
        other = replace(wanted, **{key: line(bound, bound) if key == "ratio" else bound})
        if key == "curvature":  # the pressure that it takes is another bound
            other = replace(other, pressure=None)
        if fits:
            assert float(design_actuator(other).actuator.wall(X).min()) > 0.99 * LEAST_WALL
        else:
            with pytest.raises(RequirementError):
                design_actuator(other)


@pytest.mark.parametrize("ratio", [line(0.1e-3, 0.3e-3), line(0.6e-3, 3e-3)])
def test_of_a_profile_that_is_no_number_the_factor_that_would_do_is_named(ratio):
    with pytest.raises(RequirementError) as caught:
        design_actuator(replace(FINGER, ratio=ratio))
    factor = float(str(caught.value).split("the whole profile ")[1].split(" times")[0])
    assert design_actuator(
        replace(FINGER, ratio=line(factor * float(ratio(0.0)), factor * float(ratio(0.09))))
    )


def test_rubbers_rank_by_their_index_and_say_why_not():
    ranking = rank_rubbers(FINGER, load_rubbers().values())
    fitting = [rubber for rubber, found in ranking if not isinstance(found, RequirementError)]
    assert [rubber.suitability for rubber in fitting] == sorted(
        (rubber.suitability for rubber in fitting), reverse=True
    )
    refused = {
        rubber.name: str(found) for rubber, found in ranking if isinstance(found, RequirementError)
    }
    assert fitting and "at most" in refused["Elastosil M4125"]


def test_without_side_walls_the_printed_rules_come_out():
    design = design_actuator(replace(FINGER, aspect=ConstantProfile(1.0)))
    x = stations(0.09)
    finger, (wall, around) = design.actuator, design.sizes_without_side_walls(x)
    assert wall == pytest.approx(1.0 / (8.0 * 67e3 * FINGER.ratio(x)))
    stiffness = section.rule_stiffness(around / 4.0, wall, 67e3)
    assert stiffness == pytest.approx(FINGER.stiffness(x))
    assert (finger.wall(x) > wall).all()
