"""Choice of the rubber for an actuator of required curvature and stiffness (section 3.3.3).

The section is square, its wall and side walls are equally thick, and the stiffness is that of eq.
3.26, without side walls. Two bounds enclose the height: a higher actuator stretches its top further
than the rubber stands (eq. 3.5), a lower one needs a wall of more than half its height (eq. 3.6).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from softhand_design.design_rules import DIGIT_TOLERANCE, LARGEST_WALL, allowed
from softhand_model.hand.rubber import Rubber, load_rubbers, suitability

LEAST_HEIGHT = 1e-6  # [m], where a rubber may not be stretched at all


@dataclass(frozen=True)
class Build:
    """An actuator of a rubber: height [m], wall [m], and mass of rubber per length [kg/m] of top
    and side walls.
    """

    height: float
    wall: float
    rubber_per_length: float

    @property
    def wall_over_height(self) -> float:
        """Ratio of wall and height [-], which may be at most 0.5 (eq. 3.6)."""
        return self.wall / self.height


@dataclass(frozen=True)
class Choice:
    """The possible actuators of a rubber with required curvature and stiffness: the lowest, the
    highest, and the one of the required height; `refused` names the bound that the rubber breaks,
    or is empty.
    """

    rubber: Rubber
    index: float
    lowest: Build
    highest: Build
    wanted: Build | None
    refused: str

    @property
    def suits(self) -> bool:
        """Whether such an actuator can be built of the rubber."""
        return not self.refused


def demand(curvature: float, stiffness: float) -> float:
    """Left side of eq. 3.9 [kPa**0.25]: largest curvature [1/m] times the root 4 of the bending
    stiffness [N m2], over 1000 to suit an index in kPa.

    A rubber suits if its index S (eq. 3.10) is above this value.

    >>> round(demand(100.0, 4e-3), 2)
    4.47
    """
    return float(curvature * (stiffness / 1e3) ** 0.25)


def wall_for_stiffness(stiffness: float, height: float, shear_modulus: float) -> float:
    """Wall d = B/(2*G*h**3) [m] of a square section (eq. 3.8 solved for d)."""
    return stiffness / (2.0 * shear_modulus * height**3)


def highest(curvature: float, stretch: float) -> float:
    """Height [m] at which the top has the stretch [-] `stretch` at the largest curvature [1/m] (eq.
    3.5).

    It is the largest that the rubber allows, and of all heights needs the least rubber: the wall
    falls as the cube of the height. ERRATUM: section 3.3.3 promises 3.5 times less rubber for an
    actuator of Elastosil M4125 in place of Dragon Skin 10. At equal stiffness the wall is 0.90 of
    the old one and the height 0.55, so that it is 2.0 times less; and its wall over height is 1.64
    times that of the old one, which must be below 0.30.

    >>> round(highest(100.0, 3.0), 6)
    0.02
    """
    return (stretch - 1.0) / curvature


def lowest(stiffness: float, shear_modulus: float) -> float:
    """Height (B/G)**(1/4) [m] at which the wall that the stiffness needs is half the height (eq.
    3.6).
    """
    return float((stiffness / (2.0 * LARGEST_WALL * shear_modulus)) ** 0.25)


def choose(
    curvature: float,
    stiffness: float,
    height: float | None = None,
    share: float = 1.0,
    rubbers: Iterable[Rubber] | None = None,
) -> list[Choice]:
    """The choice that each rubber gives; rubbers that suit come first, the highest index first.

    Args:
        curvature: largest curvature [1/m].
        stiffness: bending stiffness [N m2].
        height: height and width of the section [m]; None: free.
        share: share of the largest stretch that is used [-]; 0.3 to 0.5 in normal operation.
        rubbers: the rubbers; None: those of Table 3.2.

    >>> [found.rubber.name for found in choose(100.0, 4e-3)][:2]
    ['Dragon Skin 10', 'Elastosil M4125']
    """
    found = [
        _choice(rubber, curvature, stiffness, height, share)
        for rubber in (load_rubbers().values() if rubbers is None else rubbers)
    ]
    return sorted(found, key=lambda choice: (not choice.suits, -choice.index))


def _choice(
    rubber: Rubber, curvature: float, stiffness: float, height: float | None, share: float
) -> Choice:
    stretch = max(share * rubber.max_stretch, 1.0)  # none at all where less
    index = float(suitability(stretch, rubber.shear_modulus))
    low = _build(rubber, stiffness, lowest(stiffness, rubber.shear_modulus))
    high = _build(rubber, stiffness, max(highest(curvature, stretch), LEAST_HEIGHT))
    wanted = None if height is None else _build(rubber, stiffness, height)
    if stretch <= 1.0:
        least = allowed(1.0 / rubber.max_stretch, "above")
        refused = f"share above {least:.4g}, or it is not stretched at all"
    else:
        refused = _refused(index, demand(curvature, stiffness), curvature, low, high, height)
    return Choice(rubber, index, low, high, wanted, refused)


def _refused(
    index: float, needed: float, curvature: float, low: Build, high: Build, height: float | None
) -> str:
    """The bound that is broken, in the units of the command: mm, 1/m."""
    if index <= needed and (height is None or height < low.height):
        most = allowed(curvature * index / needed, "at most")
        return (
            f"index {index:.3g}, {needed:.3g} needed: curvature at most {most:.4g} 1/m at this "
            "stiffness (eq. 3.9)"
        )
    if height is None:
        return ""
    if height < low.height:
        least = allowed(1e3 * low.height, "at least")
        return f"height at least {least:.4g} mm, or the wall is above half of it (3.6)"
    if height > high.height * (1.0 + DIGIT_TOLERANCE):
        most = allowed(curvature * high.height / height, "at most")
        return f"curvature at most {most:.4g} 1/m, or this height stretches too far (eq. 3.5)"
    return ""


def _build(rubber: Rubber, stiffness: float, height: float) -> Build:
    wall = wall_for_stiffness(stiffness, height, rubber.shear_modulus)
    thin = min(wall, LARGEST_WALL * height)  # beyond that the walls fill the section
    area = 3.0 * height * thin - 2.0 * thin**2
    return Build(height, wall, float(rubber.density * area))
