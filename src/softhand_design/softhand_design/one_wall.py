"""An actuator with one wall: the section at its base, and sizes that taper as those of P10.

The rules of thumb (3.6.1) are solved at the base together with the side walls, so that
`actuation_ratio` and `Actuator.stiffness` give back what is required there. The free section is
square. Along the actuator the stiffness falls in a straight line, as the cube of a circumference
that tapers with the root 3; height and width taper as those of P10 (7.3).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from scipy.optimize import brentq

from softhand_design import castable
from softhand_design.castable import CHAMBER_IS_FILLED, LEAST_CHAMBER, rounded
from softhand_design.design_rules import circumference_for_stiffness
from softhand_design.requirements import BaseSizes, RequirementError, Requirements
from softhand_model.hand import section
from softhand_model.hand.profile import ConstantProfile, Profile, TaperedProfile


def profiles_with_one_wall(wanted: Requirements) -> dict[str, Profile]:
    """Height, width, circumference, wall and side wall [m] along the actuator.

    Raises RequirementError if the walls would fill the section at the base.
    """
    ratio, stiffness = float(wanted.ratio(0.0)), float(wanted.stiffness(0.0))
    base = _Base(ratio, stiffness, wanted.modulus, wanted.base or BaseSizes())
    height, width, wall = base.section()
    taper = 1.0 - float(wanted.stiffness(wanted.length)) / stiffness
    # the chamber at the tip keeps the height of a wall, as far as there is one at the base
    tip = min(castable.LEAST_TIP_HEIGHT * wall / height, 1.0) ** castable.TAPER_ROOT["height"]
    largest = min(taper, castable.LARGEST_TAPER)
    sizes = {
        "height": (height, min(largest, 1.0 - tip)),
        "width": (width, largest),
        "circumference": (2.0 * (height + width), taper),
    }
    return {
        **{key: _tapered(key, *size, wanted.length) for key, size in sizes.items()},
        "wall": ConstantProfile(rounded(wall)),
        "side_wall": ConstantProfile(rounded(float(castable.side_wall(wall, width)))),
    }


def _tapered(key: str, largest: float, taper: float, length: float) -> Profile:
    if taper < 1e-9:
        return ConstantProfile(rounded(largest))
    return TaperedProfile(rounded(largest), length, rounded(taper), castable.TAPER_ROOT[key])


@dataclass(frozen=True)
class _Base:
    """The base: required actuation ratio [1/(m Pa)] and stiffness [N m2], shear modulus [Pa], and
    the sizes that are fixed.
    """

    ratio: float
    stiffness: float
    modulus: float
    fixed: BaseSizes

    def section(self) -> tuple[float, float, float]:
        """Height, width and wall [m]."""
        height, width = self._sides(self._edge())
        wall = self.fixed.wall
        if wall is None:
            return height, width, self._wall(height, width)
        if wall >= height - LEAST_CHAMBER:
            expected = f"below {{}}, which leaves a chamber of {1e3 * LEAST_CHAMBER:g} mm"
            raise RequirementError("wall", expected, height - LEAST_CHAMBER, wall)
        return height, width, wall

    def _sides(self, edge: float) -> tuple[float, float]:
        """Height and width [m] whose mean is `edge` [m]; square unless one or both are fixed."""
        height, width = self.fixed.height, self.fixed.width
        height = height or (2.0 * edge - width if width else edge)
        return height, width or 2.0 * edge - height

    def _edge(self) -> float:
        """Mean of height and width [m] that gives the stiffness (rule 2, with side walls)."""
        height, width, wall = self.fixed.height, self.fixed.width, self.fixed.wall
        if height and width:
            return 0.5 * (height + width)
        half = 0.5 * (height or width or 0.0) * (1.0 + 1e-6)
        if wall is None:  # modulus, wall and side walls cancel in stiffness*ratio = edge**3/2
            edge = (2.0 * self.stiffness * self.ratio) ** (1.0 / 3.0)
        else:
            edge = self._edge_at_wall(wall, half)
        if edge <= half:
            key = "height" if height else "width"
            raise RequirementError(key, "below {} for this stiffness", 2.0 * edge, 2.0 * half)
        return edge

    def _edge_at_wall(self, wall: float, least: float) -> float:
        """The same for a wall [m] that is fixed; `least` [m] where that is already too stiff."""

        def excess(edge: float) -> float:
            rule = section.rule_stiffness(edge, wall, self.modulus)
            return float(2.0 / _side_wall_ratio(*self._sides(edge), wall) * rule) - self.stiffness

        # side walls only make it stiffer
        largest = circumference_for_stiffness(self.stiffness, wall, self.modulus) / 4.0
        least = max(least, 0.1 * largest)
        return least if excess(least) >= 0.0 else float(brentq(excess, least, largest))

    def _wall(self, height: float, width: float) -> float:
        """Wall [m] that gives the actuation ratio (rule 1, with side walls)."""
        fixed = self.fixed.height
        if fixed is not None and fixed <= LEAST_CHAMBER:
            raise RequirementError("height", "above {}, for a chamber", LEAST_CHAMBER, fixed)
        if self._excess(self.ratio) <= 0.0:
            expected = f"above {{}}, {CHAMBER_IS_FILLED}"
            raise RequirementError("actuation_ratio", expected, self._least_ratio(), self.ratio)

        def excess(wall: float) -> float:
            return self.ratio / self._reached(height, width, wall) - 1.0

        return float(brentq(excess, 1e-6 * height, height, xtol=1e-12))

    def _reached(self, height: float, width: float, wall: float) -> float:
        """Actuation ratio [1/(m Pa)] by the rule with side walls (eq. 3.32 with 3.37)."""
        rule = float(section.rule_actuation_ratio(wall, self.modulus))
        return _side_wall_ratio(height, width, wall) * rule

    def _excess(self, ratio: float) -> float:
        """By how much an actuation ratio [1/(m Pa)] is above that of the thickest wall."""
        height, width = self._sides(replace(self, ratio=ratio)._edge())
        thickest = height - LEAST_CHAMBER
        return ratio - self._reached(height, width, thickest) if thickest > 0.0 else -ratio

    def _least_ratio(self) -> float:
        """Actuation ratio [1/(m Pa)] of the thickest wall, above the required one."""
        low, high = self.ratio, 2.0 * self.ratio
        while self._excess(high) <= 0.0:
            low, high = high, 2.0 * high
        return float(brentq(self._excess, low, high, xtol=1e-15))


def _side_wall_ratio(height: float, width: float, wall: float) -> float:
    """Factor of the side walls [-] (eq. 3.35)."""
    return float(section.side_wall_ratio(height, width, wall, castable.side_wall(wall, width)))
