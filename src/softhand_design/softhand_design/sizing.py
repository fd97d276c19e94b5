"""An actuator from its requirements: its sizes, and the rules and limits that it breaks."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from softhand_common.numerics.arrays import Array
from softhand_design import limits
from softhand_design.castable import rounded
from softhand_design.design_rules import BrokenRule
from softhand_design.one_wall import profiles_with_one_wall
from softhand_design.requirements import RequirementError, Requirements, stations
from softhand_design.varying_wall import profiles_with_varying_wall
from softhand_model.hand.actuator import Actuator
from softhand_model.hand.rubber import Rubber

TUBE_VOLUME = 9.4e-7  # [m3], 0.3 m of the tube of P10
Ranking = list[tuple[Rubber, "Design | RequirementError"]]


@dataclass(frozen=True)
class Design:
    """Requirements, the actuator that is sized for them, and the rules and limits that it
    breaks.
    """

    requirements: Requirements
    actuator: Actuator
    broken: tuple[BrokenRule, ...]

    def sizes_without_side_walls(self, x: Array) -> Array:
        """Wall and circumference (2, places) [m] at places x [m] by rules 1 and 2 as the thesis
        prints them, without side walls.
        """
        wanted = self.requirements
        wall = 1.0 / (8.0 * wanted.modulus * wanted.ratio(x))
        return np.stack([wall, 4.0 * np.cbrt(wanted.stiffness(x) / (2.0 * wanted.modulus * wall))])


def design_actuator(wanted: Requirements, name: str = "finger") -> Design:
    """Size an actuator by rules 1 and 2, and list the rules and limits that it breaks: rules 1 to 4
    where they are broken most, rule 5, and limits of the stretch in use.

    Raises RequirementError that names a bound that can be met, if the wall would fill the section
    or be too thin to be cast, the actuator would be as high as long, its pressure is too low for
    its curvature, or the rubber would be stretched beyond half of its largest stretch.

    >>> from softhand_design.requirements import of_numbers
    >>> dragon_skin = Rubber("Dragon Skin 10", "", "", 11.0, 67e3, 1070.0)
    >>> found = design_actuator(of_numbers(0.93e-3, 3.9e-3, 0.09, dragon_skin)).actuator
    >>> [round(1e3 * float(size), 2) for size in found.sides(0.0)]
    [19.36, 19.36, 2.25, 2.25]
    """
    actuator = _sized(wanted, name)
    height = float(actuator.height(stations(wanted.length)).max())
    if height >= wanted.length:
        expected = "above {}, the height that gives the stiffness"
        raise RequirementError("length", expected, height, wanted.length)
    actuator = replace(actuator, mass=rounded(wanted.rubber.density * actuator.rubber_volume()))
    pressure = limits.largest_pressure(wanted, actuator)
    broken = [
        *limits.broken_rules(wanted, actuator),
        *limits.broken_limits(wanted, actuator, pressure),
    ]
    pressure = pressure or limits.pressure_limit(actuator, wanted.rubber)
    return Design(wanted, replace(actuator, max_pressure=pressure), tuple(broken))


def _sized(wanted: Requirements, name: str) -> Actuator:
    """The actuator without mass and largest pressure."""
    if wanted.base is None:
        profiles = profiles_with_varying_wall(wanted)
    else:
        profiles = profiles_with_one_wall(wanted)
    return Actuator(
        name,
        wanted.length,
        **profiles,
        shear_modulus=wanted.modulus,
        mass=0.0,
        max_pressure=0.0,
        supply_volume=TUBE_VOLUME,
        arc_radius=wanted.arc_radius,
        arc_angle=None if wanted.arc_radius is None else wanted.length / wanted.arc_radius,
    )


def rank_rubbers(wanted: Requirements, rubbers: Iterable[Rubber]) -> Ranking:
    """The design in each rubber, or the error that says why there is none. Designs come first, the
    most suitable rubber (rule 5) first.
    """
    found = [(rubber, _tried(replace(wanted, rubber=rubber))) for rubber in rubbers]
    return sorted(
        found, key=lambda one: (isinstance(one[1], RequirementError), -one[0].suitability)
    )


def _tried(wanted: Requirements) -> Design | RequirementError:
    try:
        return design_actuator(wanted)
    except RequirementError as reason:
        return reason
