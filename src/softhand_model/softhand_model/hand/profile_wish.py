"""What an actuator should do along its length, and what one that is made for it breaks."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np

from softhand_model.hand import design_rules as rules
from softhand_model.hand import section
from softhand_model.hand.actuator import Actuator
from softhand_model.hand.design_rules import BrokenRule
from softhand_model.hand.profile import Profile
from softhand_model.hand.rubber import Rubber
from softhand_model.hand.sizing import WishError
from softhand_model.numerics.arrays import Array

STATIONS = 257  # of a wish; what is made of them keeps those that straight lines would miss
COUNTS = 0.01  # of the largest stiffness, from which on it is held to rule 2


@dataclass(frozen=True)
class ProfileWish:
    """What an actuator should do along its length [m].

    ratio: actuation ratio [1/(m Pa)]; stiffness: in bending [N m2]; aspect: width over height [-],
    None for the tapers of P10; side_share: side wall over wall [-], the side wall is a third of the
    width at most; curvature [1/m] and pressure [Pa]: the largest in use, if they are known;
    arc_radius [m]: that of the line along which the length is measured, if it is an arc.

    Raises WishError for numbers that are not above 0.
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

    def __post_init__(self) -> None:
        for key in ("length", "side_share", "curvature", "pressure", "arc_radius"):
            value = getattr(self, key)
            if value is not None and not 0.0 < value < np.inf:
                raise WishError(key, "a number above {}", 0.0, value)
        x = stations(self.length)
        least = {"ratio_profile": self.ratio(x).min(), "stiffness_profile": self.stiffness(x).max()}
        if self.aspect is not None:
            least["aspect"] = self.aspect(x).min()
        for key, value in least.items():
            if not 0.0 < value < np.inf:
                raise WishError(key, "numbers above {}", 0.0, float(value))
        if self.stiffness(x).min() < 0.0:
            expected = "numbers of {} or more"
            raise WishError("stiffness_profile", expected, 0.0, float(self.stiffness(x).min()))

    @property
    def modulus(self) -> float:
        """Shear modulus [Pa]."""
        return self.rubber.shear_modulus


def stations(length: float) -> Array:
    """Stations [m], closer to each other towards base and tip."""
    return length * (1.0 - np.cos(np.linspace(0.0, np.pi, STATIONS))) / 2.0


def broken_rules(wish: ProfileWish, actuator: Actuator) -> Iterable[BrokenRule]:
    """Rules 1 to 4 at the station where each is broken most, and rule 5."""
    x = stations(wish.length)
    height, width, wall, _ = actuator.sides(x)
    wanted = wish.stiffness(x)
    counts = wanted >= COUNTS * wanted.max()  # a tip that falls to none is left out
    ratios, stiff = actuator.actuation_ratio(x), cast_stiffness(actuator, x)
    stiffness = _worst(rules.check_stiffness, x[counts], stiff[counts], wanted[counts], _apart)
    checks = (
        _worst(rules.check_actuation_ratio, x, ratios, wish.ratio(x), _apart),
        stiffness and replace(stiffness, quantity="stiffness as cast"),
        _worst(rules.check_shape, x, height, width, _apart),
        _worst(rules.check_wall, x, height, wall, lambda height, wall: wall / height),
        rules.check_rubber(wish.rubber),
    )
    return [check for check in checks if check is not None]


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
    far: Callable[[Array, Array], Array],
) -> BrokenRule | None:
    """What a check of two sizes says where they are furthest from what they should be."""
    i = int(np.argmax(far(first, second)))
    broken = check(float(first[i]), float(second[i]))
    return None if broken is None else replace(broken, place=float(x[i]))


def _apart(first: Array, second: Array) -> Array:
    return np.asarray(np.abs(np.log(first / second)))


def largest_pressure(wish: ProfileWish, actuator: Actuator) -> float | None:
    """The largest pressure [Pa] in use, as far as the wish says so: the one that its curvature
    takes, at the station that bends most, or else the one it names.
    """
    if wish.curvature is None:
        return wish.pressure
    x = stations(wish.length)
    load = 2.0 * actuator.height(x) * actuator.actuation_ratio(x)  # over the pressure
    stress = section.elastic_term(1.0 + wish.curvature * actuator.height(x))
    return float((stress / load).min())


def broken_limits(
    wish: ProfileWish, actuator: Actuator, pressure: float | None
) -> Iterable[BrokenRule]:
    """Limits of the stretch at the largest pressure [Pa] in use; those that hold what may be used
    at most, and a pressure below that which the curvature takes, raise WishError.
    """
    if pressure is None:
        return []
    x = stations(wish.length)
    height, ratio = actuator.height(x), actuator.actuation_ratio(x)
    stretch = section.free_stretch(2.0 * pressure * height * ratio)
    worst = int(np.argmax(stretch))
    cautious, most = rules.useful_stretch(wish.rubber.max_stretch)
    if stretch[worst] > most:
        limit = float((section.elastic_term(max(most, 1.0)) / (2.0 * height * ratio)).min())
        _refuse_stretch(wish, actuator, pressure, limit)
    if wish.pressure is not None and wish.pressure < pressure:
        raise WishError("pressure", "at least {} for this curvature", pressure, wish.pressure)
    place, value = float(x[worst]), float(stretch[worst])
    checks = (rules.check_use(value, cautious), rules.check_model(value))
    return [replace(check, place=place) for check in checks if check is not None]


def _refuse_stretch(wish: ProfileWish, actuator: Actuator, pressure: float, limit: float) -> None:
    """Raise WishError with the curvature or pressure at the pressure limit [Pa]."""
    expected = "at most {}, which stretches the rubber to half of what it bears"
    if wish.curvature is None:
        raise WishError("pressure", expected, limit, pressure)
    most = float(actuator.free_curvature(limit, stations(wish.length)).max())
    raise WishError("curvature", expected, most, wish.curvature)
