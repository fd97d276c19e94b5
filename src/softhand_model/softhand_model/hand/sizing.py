"""An actuator from what it should do: wall and profile from an actuation ratio and a stiffness.

The rules of thumb (3.6.1) are solved together with the side walls, so that `actuation_ratio` and
`Actuator.stiffness` give back what was wanted. The free section is square. Along the actuator the
stiffness falls in a straight line, as the cube of a circumference that tapers with the root 3;
height and width taper as those of P10 (7.3). `finger_text` writes it as a hand of a single finger.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import yaml
from scipy.optimize import brentq

from softhand_model.hand import design_rules as design
from softhand_model.hand import section
from softhand_model.hand.actuator import Actuator
from softhand_model.hand.design_rules import BrokenRule
from softhand_model.hand.hand import FORMAT, WRIST
from softhand_model.hand.profile import ConstantProfile, Profile, TableProfile, TaperedProfile
from softhand_model.hand.rubber import Rubber

MOST_TAPER = 0.925  # of height and width, as of P10
TAPER_ROOT = {"height": 3.0, "width": 8.0, "circumference": 3.0}
SIDE_WALL_SHARE = 1.0 / 3.0  # of the width at most, as of P5
LEAST_TIP_HEIGHT = 2.0  # walls
LEAST_CHAMBER = 1e-3  # height of the chamber [m], for which a mould has room
TUBE_VOLUME = 9.4e-7  # [m3], 0.3 m of the tube of P10
DIGITS = 7  # of the sizes of an actuator
FILLED = (
    f"at which the chamber is {1e3 * LEAST_CHAMBER:g} mm high (a stiffer actuator is higher, a "
    "stiffer rubber takes less wall)"
)
UNITS = {  # of what an actuator should do; of all else [m]
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
PLATE = {"size": [0.030, 0.030, 0.010], "position": [-0.010, 0.0, -0.005]}  # [m]
STAND_MASS = 0.020  # [kg]


class WishError(ValueError):
    """A wish that cannot be fulfilled: its `key`, what is `expected` with `{}` for the bound, and
    bound and value that came in `unit`, the SI unit of the key; `place` [m] along the actuator.
    """

    def __init__(
        self, key: str, expected: str, bound: float, got: float, place: float | None = None
    ) -> None:
        self.key, self.expected, self.bound, self.got = key, expected, bound, got
        self.place = place
        self.unit = UNITS.get(key, "m")
        super().__init__(self.told(key, 1.0, self.unit))

    def told(self, name: str, scale: float, unit: str) -> str:
        """The same with another name of the key, in a unit of `scale` SI units.

        >>> WishError("wall", "below {}", 0.009, 0.03).told("wall", 1e-3, "mm")
        'wall: expected below 9 mm, got 30 mm'
        """
        values = design.allowed(self.bound / scale, self.expected), self.got / scale
        bound, got = (f"{value:.{design.DIGITS}g} {unit}".rstrip() for value in values)
        place = "" if self.place is None else f" at {1e3 * self.place:.4g} mm"
        return f"{name}{place}: expected {self.expected.format(bound)}, got {got}"


@dataclass(frozen=True)
class Wish:
    """What an actuator should do: actuation_ratio [1/(m Pa)] and stiffness [N m2] at the base,
    length [m], rubber, tip_stiffness [N m2]; wall, height and width [m] where a mould fixes them.

    Raises WishError for numbers that are not above 0, and a tip stiffer than the base.
    """

    actuation_ratio: float
    stiffness: float
    length: float
    rubber: Rubber
    tip_stiffness: float = 0.0
    wall: float | None = None
    height: float | None = None
    width: float | None = None

    def __post_init__(self) -> None:
        for key in ("actuation_ratio", "stiffness", "length", "wall", "height", "width"):
            value = getattr(self, key)
            if value is not None and not 0.0 < value < np.inf:
                raise WishError(key, "a number above {}", 0.0, value)
        if not 0.0 <= self.tip_stiffness <= self.stiffness:
            expected = "0 to the stiffness at the base, {}"
            raise WishError("tip_stiffness", expected, self.stiffness, self.tip_stiffness)


@dataclass(frozen=True)
class Section:
    """Height, width and wall [m] of a section of a shear modulus [Pa]; the side walls are as thick
    as the wall, or a third of the width where that is less.
    """

    height: float
    width: float
    wall: float
    shear_modulus: float

    @property
    def side_wall(self) -> float:
        """Thickness [m] of each side wall."""
        return min(self.wall, SIDE_WALL_SHARE * self.width)

    @property
    def ratio(self) -> float:
        """Factor of the side walls [-] (eq. 3.35)."""
        return float(section.side_wall_ratio(self.height, self.width, self.wall, self.side_wall))

    @property
    def actuation_ratio(self) -> float:
        """Actuation ratio [1/(m Pa)] by the rule with side walls (eq. 3.32 with 3.37)."""
        return self.ratio * float(section.rule_actuation_ratio(self.wall, self.shear_modulus))

    @property
    def stiffness(self) -> float:
        """Stiffness [N m2] as of `Actuator.stiffness` (eq. 3.26 with 3.35)."""
        edge = 0.5 * (self.height + self.width)
        return 2.0 / self.ratio * float(section.rule_stiffness(edge, self.wall, self.shear_modulus))


@dataclass(frozen=True)
class Design:
    """An actuator for a wish, and the rules that it breaks."""

    wish: Wish
    actuator: Actuator
    broken: tuple[BrokenRule, ...]


def design_actuator(wish: Wish, name: str = "finger") -> Design:
    """Size an actuator: wall by rule 1 and circumference by rule 2, with side walls, height equal
    to width by rule 3; what the wish fixes stays. Rules that are broken are listed.

    Raises WishError when no such actuator exists: the walls would fill it, or it would be as high
    as it is long.

    >>> dragon_skin = Rubber("Dragon Skin 10", "", "", 11.0, 67e3, 1070.0)
    >>> found = design_actuator(Wish(0.93e-3, 3.9e-3, 0.09, dragon_skin)).actuator
    >>> [round(1e3 * float(size), 2) for size in found.sides(0.0)]
    [19.36, 19.36, 2.25, 2.25]
    """
    base = _section(wish)
    _refuse_unfit(wish, base)
    actuator = _actuator(wish, base, name)
    return Design(wish, actuator, _broken_rules(wish, base))


def _section(wish: Wish) -> Section:
    """Section at the base; raises WishError where the wall would fill it."""
    height, width = _sides(wish, _edge(wish))
    modulus = wish.rubber.shear_modulus
    if wish.wall is None:
        return Section(height, width, _wall(wish, height, width), modulus)
    if wish.wall >= height - LEAST_CHAMBER:
        expected = f"below {{}}, which leaves a chamber of {1e3 * LEAST_CHAMBER:g} mm"
        raise WishError("wall", expected, height - LEAST_CHAMBER, wish.wall)
    return Section(height, width, wish.wall, modulus)


def _sides(wish: Wish, edge: float) -> tuple[float, float]:
    """Height and width [m] whose mean is `edge` [m]; square unless one or both are fixed."""
    height = wish.height or (2.0 * edge - wish.width if wish.width else edge)
    return height, wish.width or 2.0 * edge - height


def _edge(wish: Wish) -> float:
    """Mean of height and width [m] that gives the stiffness (rule 2, with side walls)."""
    if wish.height and wish.width:
        return 0.5 * (wish.height + wish.width)
    half = 0.5 * (wish.height or wish.width or 0.0) * (1.0 + 1e-6)
    if wish.wall is None:  # modulus, wall and ratio cancel in stiffness*actuation_ratio = edge**3/2
        edge = (2.0 * wish.stiffness * wish.actuation_ratio) ** (1.0 / 3.0)
    else:
        edge = _edge_at_wall(wish, wish.wall, half)
    if edge <= half:
        fixed = "height" if wish.height else "width"
        raise WishError(fixed, "below {} for this stiffness", 2.0 * edge, 2.0 * half)
    return edge


def _edge_at_wall(wish: Wish, wall: float, least: float) -> float:
    """The same for a wall [m] that is fixed; `least` [m] where that is already too stiff."""
    modulus = wish.rubber.shear_modulus

    def excess(edge: float) -> float:
        return Section(*_sides(wish, edge), wall, modulus).stiffness - wish.stiffness

    # side walls only make it stiffer
    most = design.circumference_for_stiffness(wish.stiffness, wall, modulus) / 4.0
    least = max(least, 0.1 * most)
    return least if excess(least) >= 0.0 else float(brentq(excess, least, most))


def _wall(wish: Wish, height: float, width: float) -> float:
    """Wall [m] that gives the actuation ratio (rule 1, with side walls)."""
    modulus = wish.rubber.shear_modulus
    if wish.height is not None and wish.height <= LEAST_CHAMBER:
        raise WishError("height", "above {}, for a chamber", LEAST_CHAMBER, wish.height)
    if _excess_ratio(wish, wish.actuation_ratio) <= 0.0:
        least = _least_actuation_ratio(wish)
        raise WishError("actuation_ratio", f"above {{}}, {FILLED}", least, wish.actuation_ratio)

    def excess(wall: float) -> float:
        return wish.actuation_ratio / Section(height, width, wall, modulus).actuation_ratio - 1.0

    return float(brentq(excess, 1e-6 * height, height, xtol=1e-12))


def _excess_ratio(wish: Wish, ratio: float) -> float:
    """By how much an actuation ratio [1/(m Pa)] is above that of the thickest wall."""
    other = replace(wish, actuation_ratio=ratio)
    height, width = _sides(other, _edge(other))
    thickest = height - LEAST_CHAMBER
    if thickest <= 0.0:
        return -ratio
    return ratio - Section(height, width, thickest, wish.rubber.shear_modulus).actuation_ratio


def _least_actuation_ratio(wish: Wish) -> float:
    """Actuation ratio [1/(m Pa)] of the thickest wall, above that of the wish."""
    low, high = wish.actuation_ratio, 2.0 * wish.actuation_ratio
    while _excess_ratio(wish, high) <= 0.0:
        low, high = high, 2.0 * high
    return float(brentq(lambda ratio: _excess_ratio(wish, ratio), low, high, xtol=1e-15))


def _refuse_unfit(wish: Wish, base: Section) -> None:
    if base.height >= wish.length:
        expected = "above {}, the height that gives the stiffness"
        raise WishError("length", expected, base.height, wish.length)


def _actuator(wish: Wish, base: Section, name: str) -> Actuator:
    """Actuator with that section at its base."""
    taper = 1.0 - wish.tip_stiffness / wish.stiffness
    # the chamber at the tip keeps the height of a wall, as far as there is one at the base
    room = min(LEAST_TIP_HEIGHT * base.wall / base.height, 1.0) ** TAPER_ROOT["height"]
    height_taper = min(taper, MOST_TAPER, 1.0 - room)
    found = Actuator(
        name,
        wish.length,
        _profile("height", base.height, height_taper, wish.length),
        _profile("width", base.width, min(taper, MOST_TAPER), wish.length),
        _profile("circumference", 2.0 * (base.height + base.width), taper, wish.length),
        ConstantProfile(rounded(base.wall)),
        ConstantProfile(rounded(base.side_wall)),
        wish.rubber.shear_modulus,
        mass=0.0,
        max_pressure=0.0,
        supply_volume=TUBE_VOLUME,
    )
    mass = rounded(wish.rubber.density * found.rubber_volume())
    return replace(found, mass=mass, max_pressure=pressure_limit(found, wish.rubber))


def _profile(key: str, largest: float, taper: float, length: float) -> Profile:
    if taper < 1e-9:
        return ConstantProfile(rounded(largest))
    return TaperedProfile(rounded(largest), length, rounded(taper), TAPER_ROOT[key])


def pressure_limit(actuator: Actuator, rubber: Rubber) -> float:
    """Pressure [Pa] at which the top is stretched as far as the rubber should be in use: to 0.3 of
    its largest stretch, or to 0.5 of it where 0.3 is no stretch at all (section 3.3.3).

    Raises WishError for a rubber that may not be stretched at all.
    """
    stretch = next((s for s in design.useful_stretch(rubber.max_stretch) if s > 1.0), None)
    if stretch is None:
        least = 1.0 / design.USEFUL_STRETCH[1]
        raise WishError("max_stretch", f"above {{}} of {rubber.name}", least, rubber.max_stretch)
    x = actuator.quadrature()[0]
    height, _, wall, _ = actuator.sides(x)
    load = section.bending_load(
        1.0, height, wall, actuator.side_wall_ratio(x), actuator.shear_modulus
    )
    return rounded(float(section.elastic_term(stretch) / load.max()))


def rounded(value: float) -> float:
    """A size with as many digits as are written."""
    return float(f"{value:.{DIGITS}g}")


def _broken_rules(wish: Wish, base: Section) -> tuple[BrokenRule, ...]:
    checks = (
        design.check_actuation_ratio(base.actuation_ratio, wish.actuation_ratio),
        design.check_stiffness(base.stiffness, wish.stiffness),
        design.check_shape(base.height, base.width),
        design.check_wall(base.height, base.wall),
        design.check_rubber(wish.rubber),
    )
    return tuple(check for check in checks if check is not None)


def actuator_entry(actuator: Actuator) -> dict[str, Any]:
    """What stands under the actuator's name in a hand's `types`, SI units."""
    sizes = ("height", "width", "circumference", "wall", "side_wall")
    profiles = {key: profile_entry(getattr(actuator, key)) for key in sizes}
    plain = ("shear_modulus", "mass", "max_pressure", "supply_volume")
    numbers = {key: float(getattr(actuator, key)) for key in plain}
    line: dict[str, Any] = {"length": actuator.length}
    if actuator.arc_radius is not None:
        line = {"arc_radius": actuator.arc_radius, "arc_angle": actuator.arc_angle}
    return {**line, **profiles, **numbers}


def finger_text(actuator: Actuator, comment: str = "") -> str:
    """Text of a YAML file of the format softhand-hand/1: the actuator as a finger on a stand, with
    lines of comment before it.
    """
    name = actuator.name
    turn = {} if actuator.arc_radius is None else {"turn": 1}
    hand = {
        "format": FORMAT,
        "name": f"{name}_on_stand",
        "channels": ["a"],
        "mass": round(actuator.mass + STAND_MASS, 3),
        "types": {name: actuator_entry(actuator)},
        "plate": PLATE,
        "chains": {
            "finger": {
                "actuators": {"finger": {"type": name, "channel": "a"}},
                "mount": {"parent": WRIST, "position": [0.0, 0.0, 0.0], "rpy": [0.0, 0.0, 0.0]},
                **turn,
            }
        },
        "tips": ["finger"],
    }
    lines = "".join(f"# {line}\n" for line in comment.splitlines())
    return lines + yaml.safe_dump(hand, sort_keys=False, default_flow_style=None)


def profile_entry(profile: Profile) -> Any:
    """A profile as `actuator.read_profile` reads it."""
    if isinstance(profile, ConstantProfile):
        return profile.value
    if isinstance(profile, TableProfile):
        return [list(row) for row in zip(profile.x, profile.value, strict=True)]
    if isinstance(profile, TaperedProfile):
        return {"maximum": profile.maximum, "taper": profile.taper, "root": profile.root}
    raise ValueError(f"profile: expected a constant, a table or a taper, got {profile!r}")
