"""An actuator from what it should do along its length: actuation ratio and stiffness as profiles.

Sections 3.2.1 and 3.4.4: the wall sets the actuation ratio, and then the circumference sets the
stiffness, at every place of its own. At each station rules 1 and 2 (3.6.1) are solved together with
the side walls (3.35). Modulus, wall and side walls cancel in their product: stiffness times
actuation ratio is (c/4)**3/2, so that c is known before the wall.

Ours is how a section becomes one that can be cast. Where c falls to nothing, as at the tip of P10,
height and width follow (c/4)**3 over its largest value down to `CAST_SHARE` of it, by the roots of
P10 (7.3) or by a wanted aspect; the chamber keeps a wall's height; wall, and with an aspect height
and width, grow no steeper than `STEEPEST`, by which jumps are smoothed. The circumference is that
of the section that is cast, but with P10's tapers that of the wish, as the thesis has it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from softhand_model.hand import plausible, section
from softhand_model.hand.actuator import Actuator
from softhand_model.hand.design_rules import BrokenRule, allowed
from softhand_model.hand.profile import ConstantProfile, Profile, TableProfile
from softhand_model.hand.profile_wish import (
    ProfileWish,
    broken_limits,
    broken_rules,
    largest_pressure,
    stations,
)
from softhand_model.hand.rubber import Rubber
from softhand_model.hand.sizing import (
    FILLED,
    LEAST_CHAMBER,
    LEAST_TIP_HEIGHT,
    MOST_TAPER,
    SIDE_WALL_SHARE,
    TAPER_ROOT,
    TUBE_VOLUME,
    WishError,
    pressure_limit,
    rounded,
)
from softhand_model.numerics.arrays import Array

KEPT = 1e-4  # of the largest value, by which they may be missed
CAST_SHARE = 1.0 - MOST_TAPER  # of (c/4)**3, below which height and width stay
LEAST_WALL = 1e-3  # [m] that can be cast; the helix's groove takes 0.4 mm of it
STEEPEST = 0.25  # slope of wall, height and width
ROUNDED = 5e-3  # length [m] over which kinks of height and width are rounded
MOST_SHARE = 3.0  # of side walls, up to which a share is sought that can be cast
BISECTIONS = 60
FACTORS = np.geomspace(1.0, 1e4, 25)[1:]  # on a ratio, among which one that can be had is sought


@dataclass(frozen=True)
class Sections:
    """Sections at stations x [m]: height, width, wall, side_wall and circumference [m]."""

    x: Array
    height: Array
    width: Array
    wall: Array
    side_wall: Array
    circumference: Array


@dataclass(frozen=True)
class ProfileDesign:
    """An actuator for a wish, and what it breaks; printed: wall and circumference (2, stations) [m]
    by rules 1 and 2 as they are printed, without side walls, at the stations x [m].
    """

    wish: ProfileWish
    actuator: Actuator
    broken: tuple[BrokenRule, ...]
    x: Array
    printed: Array


def design_by_profiles(wish: ProfileWish, name: str = "finger") -> ProfileDesign:
    """Size an actuator by rules 1 and 2 at every station, and list what it breaks: rules 1 to 4
    where they are broken most, rule 5, and the stretch in use.

    Raises WishError with the bound that would do: the wall would fill the section or be too thin to
    be cast, the actuator would be as high as long, its pressure too low for its curvature, or the
    rubber stretched beyond half of what it bears.

    >>> dragon_skin = Rubber("Dragon Skin 10", "", "", 11.0, 67e3, 1070.0)
    >>> ratio = TableProfile((0.0, 0.09), (0.8e-3, 1.2e-3))
    >>> wish = ProfileWish(ratio, ConstantProfile(3e-3), 0.09, dragon_skin)
    >>> found = design_by_profiles(wish).actuator
    >>> [round(1e3 * float(found.wall(x)), 2) for x in (0.0, 0.045, 0.09)]
    [2.85, 2.13, 1.7]
    """
    _refuse_walls(wish)
    cast = _sections(wish)
    if cast.height.max() >= wish.length:
        expected = "above {}, the height that gives the stiffness"
        raise WishError("length", expected, float(cast.height.max()), wish.length)
    actuator = _actuator(wish, cast, name)
    pressure = largest_pressure(wish, actuator)
    broken = (*broken_rules(wish, actuator), *broken_limits(wish, actuator, pressure))
    actuator = replace(actuator, max_pressure=pressure or pressure_limit(actuator, wish.rubber))
    return ProfileDesign(wish, actuator, broken, cast.x, _printed(wish, cast.x))


# ---------------------------------------------------------------------- sections
def _sections(wish: ProfileWish) -> Sections:
    """Sections that can be cast."""
    x = stations(wish.length)
    ratio, stiffness = wish.ratio(x), wish.stiffness(x)
    height, width = _outer(wish, x)
    wall = _steady(x, _wall(wish, ratio, height, width))
    side_wall = _side_wall(wish, wall, width)
    if wish.aspect is not None:
        return Sections(x, height, width, wall, side_wall, 2.0 * (height + width))
    share = 2.0 / section.side_wall_ratio(height, width, wall, side_wall)
    edge = np.cbrt(stiffness / (2.0 * share * wish.modulus * wall))
    around = np.maximum(4.0 * edge, plausible.CIRCUMFERENCE.low)
    return Sections(x, height, width, wall, side_wall, around)


def _outer(wish: ProfileWish, x: Array) -> tuple[Array, Array]:
    """Height and width [m], of which the chamber keeps the height of a wall."""
    ratio = wish.ratio(x)
    height, width = _of_stiffness(wish, x)
    least = LEAST_TIP_HEIGHT * _wall(wish, ratio, height, width)
    tall = np.maximum(height, np.minimum(least, height.max()))
    if wish.aspect is None:
        return tall, width
    tall = _rounded(x, tall)
    return tall, _rounded(x, tall * wish.aspect(x))


def _of_stiffness(wish: ProfileWish, x: Array) -> tuple[Array, Array]:
    """Height and width [m] that follow the cube of c/4."""
    cube = 2.0 * wish.stiffness(x) * wish.ratio(x)
    share, edge = cube / cube.max(), float(np.cbrt(cube.max()))
    least = float(share.min())
    if least < 1.0:  # from `least` up to 1 it is laid out from the castable share up to 1
        share = 1.0 - (1.0 - max(least, CAST_SHARE)) / (1.0 - least) * (1.0 - share)
    if wish.aspect is None:
        height, width = (edge * share ** (1.0 / TAPER_ROOT[key]) for key in ("height", "width"))
        return height, width
    aspect = wish.aspect(x)
    height = 2.0 * edge / (1.0 + aspect) * np.cbrt(share)
    return height, aspect * height


def _wall(wish: ProfileWish, ratio: Array, height: Array, width: Array) -> Array:
    """Wall [m] by rule 1 with side walls, where it fills the section the height: the root of
    d*2/ratio(d) = 1/(4*G*dkappa/dp), whose left side grows with d.
    """
    wanted = 1.0 / (4.0 * wish.modulus * ratio)
    low, high = np.zeros_like(height), height.copy()
    for _ in range(BISECTIONS):
        wall = (low + high) / 2.0
        factor = section.side_wall_ratio(height, width, wall, _side_wall(wish, wall, width))
        thick = 2.0 * wall / factor > wanted
        low, high = np.where(thick, low, wall), np.where(thick, wall, high)
    return high


def _side_wall(wish: ProfileWish, wall: Array, width: Array) -> Array:
    return np.minimum(wish.side_share * wall, SIDE_WALL_SHARE * width)


def _steady(x: Array, size: Array) -> Array:
    """The least size [m] that is nowhere smaller and nowhere steeper than `STEEPEST`."""
    below = size - STEEPEST * np.abs(x[:, None] - x)
    return np.asarray(below.max(axis=1))


def _rounded(x: Array, size: Array) -> Array:
    """The same without kinks: its mean over `ROUNDED` around each place, less near the ends."""
    half = np.minimum(ROUNDED / 2.0, np.minimum(x, x[-1] - x))
    places = x + half * np.linspace(-1.0, 1.0, 9)[:, None]
    return np.asarray(np.interp(places, x, _steady(x, size)).mean(axis=0))


def _refuse_walls(wish: ProfileWish) -> None:
    """Refuse actuation ratios at which the wall fills the section, or is too thin to be cast."""
    x = stations(wish.length)

    def spare(factor: float) -> Array:
        """Height of the chamber over the least, less 1, at so many times the ratio."""
        other = _scaled(wish, factor)
        height, width = _outer(other, x)
        return (height - _wall(other, other.ratio(x), height, width)) / LEAST_CHAMBER - 1.0

    def thick(factor: float) -> Array:
        """Wall over the thinnest one, less 1, at so many times the ratio."""
        other = _scaled(wish, factor)
        return _wall(other, other.ratio(x), *_outer(other, x)) / LEAST_WALL - 1.0

    _refuse_ratio(wish, spare, FACTORS, f"above {{}}, {FILLED}")
    thin = f"at most {{}}, at which the wall is {1e3 * LEAST_WALL:g} mm thin"
    if _refuse_ratio(wish, thick, 1.0 / FACTORS, thin):
        height, width = _outer(wish, x)
        ratio = section.side_wall_ratio(height, width, LEAST_WALL, wish.side_share * LEAST_WALL)
        most = float((ratio / (8.0 * LEAST_WALL * wish.ratio(x))).min())
        expected = f"at most {{}} for walls of {1e3 * LEAST_WALL:g} mm"
        raise WishError("modulus", expected, most, wish.modulus)
    _refuse_side_share(wish)


def _refuse_side_share(wish: ProfileWish) -> None:
    x = stations(wish.length)

    def thick(share: float) -> float:
        """Least side wall over the thinnest one, less 1, where the width does not limit it."""
        other = replace(wish, side_share=share)
        return share * float(_wall(other, wish.ratio(x), *_outer(other, x)).min()) / LEAST_WALL - 1

    if thick(wish.side_share) < 0.0 < thick(MOST_SHARE):
        least = float(brentq(thick, wish.side_share, MOST_SHARE))
        expected = f"at least {{}}, at which side walls are {1e3 * LEAST_WALL:g} mm thin"
        raise WishError("side_share", expected, least, wish.side_share)


def _refuse_ratio(
    wish: ProfileWish, room: Callable[[float], Array], factors: Array, expected: str
) -> bool:
    """Raise WishError where room(1) is below 0, with the ratio of the nearest factor at which it is
    not; whether it is below 0 at all of them.
    """
    at = room(1.0)
    if at.min() >= 0.0:
        return False
    last = 1.0
    for factor in factors:
        if room(factor).min() >= 0.0:
            worst = int(np.argmin(at))
            got = float(wish.ratio(stations(wish.length))[worst])
            times = float(brentq(lambda f: room(f).min(), last, factor, xtol=1e-12))
            place = float(stations(wish.length)[worst])
            if np.ptp(wish.ratio(stations(wish.length))) > 0.0:
                expected += f"; the whole profile {allowed(times, expected):.4g} times"
            raise WishError("ratio_profile", expected, times * got, got, place)
        last = factor
    return True


def _scaled(wish: ProfileWish, factor: float) -> ProfileWish:
    """The wish with another factor on its actuation ratio."""
    x = stations(wish.length)
    return replace(wish, ratio=TableProfile(tuple(x), tuple(factor * wish.ratio(x))))


# ---------------------------------------------------------------------- the actuator
def _actuator(wish: ProfileWish, cast: Sections, name: str) -> Actuator:
    x = cast.x
    found = Actuator(
        name,
        wish.length,
        height=_profile(x, cast.height),
        width=_profile(x, cast.width),
        circumference=_profile(x, cast.circumference),
        wall=_profile(x, cast.wall),
        side_wall=_profile(x, cast.side_wall),
        shear_modulus=wish.modulus,
        mass=0.0,
        max_pressure=0.0,
        supply_volume=TUBE_VOLUME,
        arc_radius=wish.arc_radius,
        arc_angle=None if wish.arc_radius is None else wish.length / wish.arc_radius,
    )
    return replace(found, mass=rounded(wish.rubber.density * found.rubber_volume()))


def _profile(x: Array, size: Array) -> Profile:
    """A size [m] as a number or straight lines, missed by `KEPT` of its largest value at most."""
    if np.ptp(size) <= KEPT * size.max():
        return ConstantProfile(rounded(float(size.mean())))
    corners = sorted(_corners(x, size, 0, len(x) - 1, KEPT * float(size.max())))
    return TableProfile(
        tuple(rounded(float(x[i])) for i in corners),
        tuple(rounded(float(size[i])) for i in corners),
    )


def _corners(x: Array, size: Array, first: int, last: int, within: float) -> Iterable[int]:
    """Points, first and last among them, between which straight lines miss none (Douglas and
    Peucker's way).
    """
    line = np.interp(x[first : last + 1], x[[first, last]], size[[first, last]])
    off = np.abs(size[first : last + 1] - line)
    if off.max() <= within:
        return {first, last}
    middle = first + int(np.argmax(off))
    return {*_corners(x, size, first, middle, within), *_corners(x, size, middle, last, within)}


# ---------------------------------------------------------------------- rules and limits
def _printed(wish: ProfileWish, x: Array) -> Array:
    """Wall and circumference (2, stations) [m] by rules 1 and 2 as printed."""
    wall = 1.0 / (8.0 * wish.modulus * wish.ratio(x))
    return np.stack([wall, 4.0 * np.cbrt(wish.stiffness(x) / (2.0 * wish.modulus * wall))])


def rank_rubbers(
    wish: ProfileWish, rubbers: Iterable[Rubber]
) -> list[tuple[Rubber, ProfileDesign | WishError]]:
    """Designs of a wish in each rubber, or why there is none: those first that exist, by falling
    suitability (rule 5).
    """
    found = [(rubber, _tried(replace(wish, rubber=rubber))) for rubber in rubbers]
    return sorted(found, key=lambda one: (isinstance(one[1], WishError), -one[0].suitability))


def _tried(wish: ProfileWish) -> ProfileDesign | WishError:
    try:
        return design_by_profiles(wish)
    except WishError as reason:
        return reason
