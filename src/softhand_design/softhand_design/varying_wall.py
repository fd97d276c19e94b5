"""An actuator whose wall varies: actuation ratio and stiffness are met at every place along it.

Sections 3.2.1 and 3.4.4: the wall sets the actuation ratio, and then the circumference sets the
stiffness, at every place of its own. At each station rules 1 and 2 (3.6.1) are solved together with
the side walls (3.35). Modulus, wall and side walls cancel in their product: stiffness times
actuation ratio is (c/4)**3/2, so that c is known before the wall.

The thesis does not say how such a section is cast; these rules are ours. Where c falls to nothing,
as at the tip of P10, height and width follow (c/4)**3 over its largest value, but not below
`CAST_SHARE` of that, by the roots of P10 (7.3) or by a required aspect. The chamber is at least as
high as its wall is thick. The wall, and with an aspect also height and width, grow no steeper than
`LARGEST_SLOPE`, which smooths jumps. The circumference is that of the cast section; with P10's
tapers it is the required one, as in the thesis.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from softhand_common.numerics.arrays import Array
from softhand_design import castable
from softhand_design.castable import CHAMBER_IS_FILLED, LEAST_CHAMBER, LEAST_WALL, rounded
from softhand_design.design_rules import allowed
from softhand_design.requirements import RequirementError, Requirements, stations
from softhand_model.hand import plausible, section
from softhand_model.hand.profile import ConstantProfile, Profile, TableProfile

PROFILE_TOLERANCE = 1e-4  # of a size's largest value, by which its straight lines may be off
CAST_SHARE = 1.0 - castable.LARGEST_TAPER  # of (c/4)**3, below which height and width stay
LARGEST_SLOPE = 0.25  # slope of wall, height and width
ROUNDED = 5e-3  # length [m] over which kinks of height and width are rounded
LARGEST_SIDE_SHARE = 3.0  # of side walls, up to which a share is sought that can be cast
BISECTIONS = 60
FACTORS = np.geomspace(1.0, 1e4, 25)[1:]  # on a ratio, among which a possible one is sought


def profiles_with_varying_wall(wanted: Requirements) -> dict[str, Profile]:
    """Height, width, wall, side wall and circumference [m] along the actuator.

    Raises RequirementError that names a bound that can be met, if walls would fill the section or
    be too thin to be cast.
    """
    _refuse_walls(wanted)
    x = stations(wanted.length)
    return {key: _profile(x, size) for key, size in _sizes(wanted, x).items()}


# ---------------------------------------------------------------------- sections
def _sizes(wanted: Requirements, x: Array) -> dict[str, Array]:
    """Sizes [m] at stations x [m] of sections that can be cast."""
    height, width = _outer(wanted, x)
    wall = _limited_slope(x, _wall(wanted, x, height, width))
    side_wall = castable.side_wall(wall, width, wanted.side_share)
    sizes = {"height": height, "width": width, "wall": wall, "side_wall": side_wall}
    if wanted.aspect is not None:
        return sizes | {"circumference": 2.0 * (height + width)}
    share = 2.0 / section.side_wall_ratio(height, width, wall, side_wall)
    edge = np.cbrt(wanted.stiffness(x) / (2.0 * share * wanted.modulus * wall))
    return sizes | {"circumference": np.maximum(4.0 * edge, plausible.CIRCUMFERENCE.low)}


def _outer(wanted: Requirements, x: Array) -> tuple[Array, Array]:
    """Height and width [m]; the chamber is at least as high as the wall is thick."""
    height, width = _of_stiffness(wanted, x)
    least = castable.LEAST_TIP_HEIGHT * _wall(wanted, x, height, width)
    tall = np.maximum(height, np.minimum(least, height.max()))
    if wanted.aspect is None:
        return tall, width
    tall = _smooth(x, tall)
    return tall, _smooth(x, tall * wanted.aspect(x))


def _of_stiffness(wanted: Requirements, x: Array) -> tuple[Array, Array]:
    """Height and width [m] in proportion to c/4, whose cube is 2*stiffness*ratio, as far as the
    tip can be cast.
    """
    cube = 2.0 * wanted.stiffness(x) * wanted.ratio(x)
    share, edge = cube / cube.max(), float(np.cbrt(cube.max()))
    least = float(share.min())
    if least < 1.0:  # scaled from `least` to 1 onto the castable share to 1
        share = 1.0 - (1.0 - max(least, CAST_SHARE)) / (1.0 - least) * (1.0 - share)
    if wanted.aspect is None:
        roots = castable.TAPER_ROOT["height"], castable.TAPER_ROOT["width"]
        return edge * share ** (1.0 / roots[0]), edge * share ** (1.0 / roots[1])
    aspect = wanted.aspect(x)
    height = 2.0 * edge / (1.0 + aspect) * np.cbrt(share)
    return height, aspect * height


def _wall(wanted: Requirements, x: Array, height: Array, width: Array) -> Array:
    """Wall [m] at x [m] by rule 1 with side walls, the height where it fills the section: the root
    of d*2/ratio(d) = 1/(4*G*dkappa/dp), whose left side grows with d.
    """
    right = 1.0 / (4.0 * wanted.modulus * wanted.ratio(x))
    low, high = np.zeros_like(height), height.copy()
    for _ in range(BISECTIONS):
        wall = (low + high) / 2.0
        side_wall = castable.side_wall(wall, width, wanted.side_share)
        thick = 2.0 * wall / section.side_wall_ratio(height, width, wall, side_wall) > right
        low, high = np.where(thick, low, wall), np.where(thick, wall, high)
    return high


def _limited_slope(x: Array, size: Array) -> Array:
    """The least size [m] that is nowhere smaller and nowhere steeper than `LARGEST_SLOPE`."""
    below = size - LARGEST_SLOPE * np.abs(x[:, None] - x)
    return np.asarray(below.max(axis=1))


def _smooth(x: Array, size: Array) -> Array:
    """The same without kinks: its mean over `ROUNDED` around each place, less near the ends."""
    half = np.minimum(ROUNDED / 2.0, np.minimum(x, x[-1] - x))
    places = x + half * np.linspace(-1.0, 1.0, 9)[:, None]
    return np.asarray(np.interp(places, x, _limited_slope(x, size)).mean(axis=0))


def _refuse_walls(wanted: Requirements) -> None:
    """Refuse actuation ratios at which the wall fills the section, or is too thin to be cast."""
    x = stations(wanted.length)

    def spare(factor: float) -> Array:
        """Height of the chamber over LEAST_CHAMBER, minus 1, at `factor` times the ratio."""
        other = _scaled(wanted, factor)
        height, width = _outer(other, x)
        return (height - _wall(other, x, height, width)) / LEAST_CHAMBER - 1.0

    def thick(factor: float) -> Array:
        """Wall over LEAST_WALL, minus 1, at `factor` times the ratio."""
        other = _scaled(wanted, factor)
        return _wall(other, x, *_outer(other, x)) / LEAST_WALL - 1.0

    _refuse_ratio(wanted, spare, FACTORS, f"above {{}}, {CHAMBER_IS_FILLED}")
    thin = f"at most {{}}, at which the wall is {1e3 * LEAST_WALL:g} mm thin"
    if _refuse_ratio(wanted, thick, 1.0 / FACTORS, thin):
        height, width = _outer(wanted, x)
        ratio = section.side_wall_ratio(height, width, LEAST_WALL, wanted.side_share * LEAST_WALL)
        largest = float((ratio / (8.0 * LEAST_WALL * wanted.ratio(x))).min())
        expected = f"at most {{}} for walls of {1e3 * LEAST_WALL:g} mm"
        raise RequirementError("modulus", expected, largest, wanted.modulus)
    _refuse_side_share(wanted)


def _refuse_side_share(wanted: Requirements) -> None:
    x = stations(wanted.length)

    def thick(share: float) -> float:
        """Smallest side wall over LEAST_WALL, minus 1, where the width does not limit it."""
        other = replace(wanted, side_share=share)
        wall = _wall(other, x, *_outer(other, x))
        return share * float(wall.min()) / LEAST_WALL - 1.0

    if thick(wanted.side_share) < 0.0 < thick(LARGEST_SIDE_SHARE):
        least = float(brentq(thick, wanted.side_share, LARGEST_SIDE_SHARE))
        expected = f"at least {{}}, at which side walls are {1e3 * LEAST_WALL:g} mm thin"
        raise RequirementError("side_share", expected, least, wanted.side_share)


def _refuse_ratio(
    wanted: Requirements, room: Callable[[float], Array], factors: Array, expected: str
) -> bool:
    """Raise RequirementError if room(1) is below 0, with the ratio at the nearest factor at which
    it is not; return whether it is below 0 at all factors.
    """
    at, last = room(1.0), 1.0
    if at.min() >= 0.0:
        return False
    x = stations(wanted.length)
    ratio = wanted.ratio(x)
    for factor in factors:
        if room(factor).min() >= 0.0:
            worst = int(np.argmin(at))
            got, place = float(ratio[worst]), float(x[worst])
            times = float(brentq(lambda f: room(f).min(), last, factor, xtol=1e-12))
            if np.ptp(ratio) > 0.0:
                expected += f"; the whole profile {allowed(times, expected):.4g} times"
            raise RequirementError("ratio_profile", expected, times * got, got, place)
        last = factor
    return True


def _scaled(wanted: Requirements, factor: float) -> Requirements:
    """The requirements with a factor on their actuation ratio."""
    x = stations(wanted.length)
    return replace(wanted, ratio=TableProfile(tuple(x), tuple(factor * wanted.ratio(x))))


def _profile(x: Array, size: Array) -> Profile:
    """A size [m] as a number or straight lines, within `PROFILE_TOLERANCE` of its largest value."""
    if np.ptp(size) <= PROFILE_TOLERANCE * size.max():
        return ConstantProfile(rounded(float(size.mean())))
    corners = sorted(_corners(x, size, 0, len(x) - 1, PROFILE_TOLERANCE * float(size.max())))
    return TableProfile(
        tuple(rounded(float(x[i])) for i in corners),
        tuple(rounded(float(size[i])) for i in corners),
    )


def _corners(x: Array, size: Array, first: int, last: int, within: float) -> Iterable[int]:
    """Points, first and last among them, between which straight lines are `within` [m] of all
    others (Douglas and Peucker, 1973).
    """
    line = np.interp(x[first : last + 1], x[[first, last]], size[[first, last]])
    off = np.abs(size[first : last + 1] - line)
    if off.max() <= within:
        return {first, last}
    middle = first + int(np.argmax(off))
    return {*_corners(x, size, first, middle, within), *_corners(x, size, middle, last, within)}
