"""Requirements of an actuator: actuation ratio and stiffness along its length, and its use.

`of_numbers` makes the requirements of an actuator with one wall from single numbers at its base.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from softhand_common.numerics.arrays import Array
from softhand_design.design_rules import MESSAGE_DIGITS, allowed
from softhand_model.hand.profile import ConstantProfile, Profile, TableProfile
from softhand_model.hand.rubber import Rubber

STATIONS = 257  # at which requirements are evaluated along the actuator
UNITS = {  # of requirements; all others are lengths [m]
    "actuation_ratio": "1/(m Pa)",
    "stiffness": "N m2",
    "tip_stiffness": "N m2",
    "max_stretch": "",
    "ratio_profile": "1/(m Pa)",
    "stiffness_profile": "N m2",
    "aspect": "",
    "side_share": "",
    "curvature": "1/m",
    "pressure": "Pa",
    "modulus": "Pa",
}


class RequirementError(ValueError):
    """A requirement that cannot be met.

    key: name of the required quantity. expected: what it should be, as text with `{}` in the place
    of the bound. bound, got: the bound and the value that was required, in the SI unit of the key
    (`unit`). place [m]: where along the actuator; None if it has no place.
    """

    def __init__(
        self, key: str, expected: str, bound: float, got: float, place: float | None = None
    ) -> None:
        self.key, self.expected, self.bound, self.got = key, expected, bound, got
        self.place = place
        self.unit = UNITS.get(key, "m")
        super().__init__(self.message(key, 1.0, self.unit))

    def message(self, name: str, scale: float, unit: str) -> str:
        """The message with another name of the key, in a unit of `scale` SI units.

        >>> RequirementError("wall", "below {}", 0.009, 0.03).message("wall", 1e-3, "mm")
        'wall: expected below 9 mm, got 30 mm'
        """
        values = allowed(self.bound / scale, self.expected), self.got / scale
        bound, got = (f"{value:.{MESSAGE_DIGITS}g} {unit}".rstrip() for value in values)
        place = "" if self.place is None else f" at {1e3 * self.place:.4g} mm"
        return f"{name}{place}: expected {self.expected.format(bound)}, got {got}"


@dataclass(frozen=True)
class BaseSizes:
    """Sizes at the base [m] that a mould fixes; None for those that follow from requirements."""

    wall: float | None = None
    height: float | None = None
    width: float | None = None


@dataclass(frozen=True)
class Requirements:
    """Requirements of an actuator along its length.

    Args:
        ratio: actuation ratio [1/(m Pa)] over the position [m].
        stiffness: bending stiffness [N m2] over the position [m].
        length: length of the actuator [m].
        rubber: rubber of which it is cast.
        aspect: width over height [-]; None: width and height taper as those of P10 (section 7.3).
        side_share: thickness of the side wall over that of the wall [-]; the side wall is at most a
            third of the width.
        curvature: largest curvature in use [1/m]; None if it is not known.
        pressure: largest pressure in use [Pa]; None if it is not known.
        arc_radius: radius [m] of the line along which the length is measured; None for a straight
            line.
        base: fixed sizes of an actuator with one wall, which meets ratio and stiffness at its base,
            and whose sizes taper as those of P10; None: ratio and stiffness are met at every place,
            and the wall varies.

    Raises RequirementError for numbers that are not above 0.
    """

    ratio: Profile
    stiffness: Profile
    length: float
    rubber: Rubber
    aspect: Profile | None = None
    side_share: float = 1.0
    curvature: float | None = None
    pressure: float | None = None
    arc_radius: float | None = None
    base: BaseSizes | None = None

    def __post_init__(self) -> None:
        keys = ("length", "side_share", "curvature", "pressure", "arc_radius")
        require_positive({key: getattr(self, key) for key in keys})
        x = stations(self.length)
        least = {"ratio_profile": self.ratio(x).min(), "stiffness_profile": self.stiffness(x).max()}
        if self.aspect is not None:
            least["aspect"] = self.aspect(x).min()
        require_positive(least, "numbers above {}")
        if self.stiffness(x).min() < 0.0:
            expected = "numbers of {} or more"
            least_stiffness = float(self.stiffness(x).min())
            raise RequirementError("stiffness_profile", expected, 0.0, least_stiffness)

    @property
    def modulus(self) -> float:
        """Shear modulus of the rubber [Pa]."""
        return self.rubber.shear_modulus


def of_numbers(
    actuation_ratio: float,
    stiffness: float,
    length: float,
    rubber: Rubber,
    tip_stiffness: float = 0.0,
    wall: float | None = None,
    height: float | None = None,
    width: float | None = None,
) -> Requirements:
    """Requirements of an actuator with one wall.

    Args:
        actuation_ratio: actuation ratio at the base [1/(m Pa)].
        stiffness: bending stiffness at the base [N m2], from which it falls linearly.
        length: length of the actuator [m].
        rubber: rubber of which it is cast.
        tip_stiffness: bending stiffness at the tip [N m2].
        wall, height, width: sizes at the base [m] that a mould fixes; None for those that follow
            from the rest.

    Raises RequirementError for numbers that are not above 0, and for a tip stiffer than the base.
    """
    require_positive({"actuation_ratio": actuation_ratio, "stiffness": stiffness, "length": length})
    require_positive({"wall": wall, "height": height, "width": width})
    if not 0.0 <= tip_stiffness <= stiffness:
        expected = "0 to the stiffness at the base, {}"
        raise RequirementError("tip_stiffness", expected, stiffness, tip_stiffness)
    return Requirements(
        ConstantProfile(actuation_ratio),
        TableProfile((0.0, length), (stiffness, tip_stiffness)),
        length,
        rubber,
        base=BaseSizes(wall, height, width),
    )


def require_positive(
    values: Mapping[str, float | None], expected: str = "a number above {}"
) -> None:
    """Raise RequirementError for the first value that is neither None nor a finite number above 0.

    values: by their keys. expected: words for the message, with `{}` in the place of the 0.
    """
    for key, value in values.items():
        if value is not None and not 0.0 < value < np.inf:
            raise RequirementError(key, expected, 0.0, float(value))


def stations(length: float) -> Array:
    """Stations (STATIONS,) [m] along an actuator, closer to each other towards base and tip."""
    return length * (1.0 - np.cos(np.linspace(0.0, np.pi, STATIONS))) / 2.0
