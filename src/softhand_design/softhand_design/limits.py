"""Rules and limits that a designed actuator breaks, and the largest pressure in use."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from softhand_common.numerics.arrays import Array
from softhand_design import design_rules as rules
from softhand_design.castable import rounded
from softhand_design.design_rules import BrokenRule
from softhand_design.requirements import RequirementError, Requirements, stations
from softhand_model.hand import section
from softhand_model.hand.actuator import Actuator
from softhand_model.hand.rubber import Rubber

STIFF_ENOUGH = 0.01  # share of the largest stiffness, from which on rule 2 is checked


def broken_rules(wanted: Requirements, actuator: Actuator) -> list[BrokenRule]:
    """The broken rules among rules 1 to 5; rules 1 to 4 each at the place where it is broken most.
    An actuator with one wall is checked at its base only, and no place is given.
    """
    along = wanted.base is None
    x = stations(wanted.length) if along else np.zeros(1)
    height, width, wall, _ = actuator.sides(x)
    stiffness = wanted.stiffness(x)
    stiff = stiffness >= STIFF_ENOUGH * stiffness.max()  # without a tip that falls to none
    ratios, cast = actuator.actuation_ratio(x), cast_stiffness(actuator, x)
    checks = [
        _worst(rules.check_actuation_ratio, x, ratios, wanted.ratio(x), _apart),
        _worst(rules.check_stiffness, x[stiff], cast[stiff], stiffness[stiff], _apart),
        _worst(rules.check_shape, x, height, width, _apart),
        _worst(rules.check_wall, x, height, wall, lambda height, wall: wall / height),
        rules.check_rubber(wanted.rubber),
    ]
    if along and checks[1]:
        checks[1] = replace(checks[1], quantity="stiffness as cast")
    found = [check for check in checks if check is not None]
    return found if along else [replace(check, place=None) for check in found]


def cast_stiffness(actuator: Actuator, x: Array) -> Array:
    """Stiffness [N m2] at places [m] of the section that is cast: by the circumference of its
    rectangle, from which the tapers of P10 (7.3) depart.
    """
    height, width, wall, _ = actuator.sides(x)
    rule = section.rule_stiffness((height + width) / 2.0, wall, actuator.shear_modulus)
    return 2.0 / actuator.side_wall_ratio(x) * rule


def _worst(
    check: Callable[[float, float], BrokenRule | None],
    x: Array,
    first: Array,
    second: Array,
    distance: Callable[[Array, Array], Array],
) -> BrokenRule | None:
    """What a check of two quantities returns where their distance is largest."""
    i = int(np.argmax(distance(first, second)))
    broken = check(float(first[i]), float(second[i]))
    return None if broken is None else replace(broken, place=float(x[i]))


def _apart(first: Array, second: Array) -> Array:
    return np.asarray(np.abs(np.log(first / second)))


def pressure_limit(actuator: Actuator, rubber: Rubber) -> float:
    """Pressure [Pa] at which the stretch of the top is the largest that is advised in use: 0.3 of
    the rubber's largest stretch, or 0.5 of it where 0.3 would be a stretch below 1 (section 3.3.3).

    Raises RequirementError for a rubber that may not be stretched at all.
    """
    stretch = next((s for s in rules.useful_stretch(rubber.max_stretch) if s > 1.0), None)
    if stretch is None:
        least = 1.0 / rules.USEFUL_STRETCH[1]
        expected = f"above {{}} of {rubber.name}"
        raise RequirementError("max_stretch", expected, least, rubber.max_stretch)
    x = actuator.quadrature()[0]
    height, _, wall, _ = actuator.sides(x)
    load = section.bending_load(
        1.0, height, wall, actuator.side_wall_ratio(x), actuator.shear_modulus
    )
    return rounded(float(section.elastic_term(stretch) / load.max()))


def largest_pressure(wanted: Requirements, actuator: Actuator) -> float | None:
    """The largest pressure [Pa] in use, or None if the requirements do not give it: the pressure
    for their curvature at the station that bends most, else their `pressure`.
    """
    if wanted.curvature is None:
        return wanted.pressure
    x = stations(wanted.length)
    load = 2.0 * actuator.height(x) * actuator.actuation_ratio(x)  # over the pressure
    stress = section.elastic_term(1.0 + wanted.curvature * actuator.height(x))
    return float((stress / load).min())


def broken_limits(
    wanted: Requirements, actuator: Actuator, pressure: float | None
) -> list[BrokenRule]:
    """Limits of the stretch that are broken at the largest pressure [Pa] in use.

    Raises RequirementError for a stretch beyond half of the largest, and for a pressure too low for
    the required curvature.
    """
    if pressure is None:
        return []
    x = stations(wanted.length)
    height, ratio = actuator.height(x), actuator.actuation_ratio(x)
    stretch = section.free_stretch(2.0 * pressure * height * ratio)
    worst = int(np.argmax(stretch))
    cautious, largest = rules.useful_stretch(wanted.rubber.max_stretch)
    if stretch[worst] > largest:
        limit = float((section.elastic_term(max(largest, 1.0)) / (2.0 * height * ratio)).min())
        _refuse_stretch(wanted, actuator, pressure, limit)
    if wanted.pressure is not None and wanted.pressure < pressure:
        expected = "at least {} for this curvature"
        raise RequirementError("pressure", expected, pressure, wanted.pressure)
    place, value = float(x[worst]), float(stretch[worst])
    checks = (rules.check_use(value, cautious), rules.check_model(value))
    return [replace(check, place=place) for check in checks if check is not None]


def _refuse_stretch(
    wanted: Requirements, actuator: Actuator, pressure: float, limit: float
) -> None:
    """Raise RequirementError with the curvature or pressure at the pressure limit [Pa]."""
    expected = "at most {}, which stretches the rubber to half of what it bears"
    if wanted.curvature is None:
        raise RequirementError("pressure", expected, limit, pressure)
    largest = float(actuator.free_curvature(limit, stations(wanted.length)).max())
    raise RequirementError("curvature", expected, largest, wanted.curvature)
