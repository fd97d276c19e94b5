"""Units of measured columns, any that pint knows, and units in which people read."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import pint

from model_lab.aliases import Array

COLUMN_UNITS = {
    **dict.fromkeys(("time", "duration"), "s"),
    **dict.fromkeys(("pressure", "p_in", "p_out", "stress"), "Pa"),
    **dict.fromkeys(("friction_integral", "injector_integral"), "Pa s"),
    **dict.fromkeys(("torque_x", "torque_y", "torque_z"), "N m"),
    **dict.fromkeys(("tip_x", "tip_y", "tip_z"), "m"),
    **dict.fromkeys(("tip_qx", "tip_qy", "tip_qz", "tip_qw", "stretch", "direction"), ""),
    "temperature": "K",
    "tip_angle": "rad",
    "tip_force": "N",
    "mass": "kg",
}  # those whose quantity is known; any other column may have any unit
REMEMBERED = 256  # units of a set, looked up once


@dataclass(frozen=True)
class Unit:
    """A unit of a column: SI value = scale * value + offset, with the SI unit's name."""

    scale: float = 1.0
    offset: float = 0.0
    si: str = ""

    def to_si(self, values: Array) -> Array:
        """Values (n,) in SI units."""
        return self.scale * values + self.offset


@lru_cache(maxsize=REMEMBERED)
def column_unit(column: str, text: str) -> Unit:
    """The unit that a text names, for a column of that name.

    Raises ValueError (expected, got, and the mend where there is one) when pint does not know it or
    it measures another quantity than the column's.

    >>> column_unit("pressure", "kPa")
    Unit(scale=1000.0, offset=0.0, si='Pa')
    >>> column_unit("temperature", "degC").to_si(np.array([20.0])).tolist()
    [293.15]
    """
    unit = _parsed(text)
    wanted = COLUMN_UNITS.get(column)
    target = _registry().Unit(wanted) if wanted is not None else _base_unit(unit)
    if unit.dimensionality != target.dimensionality:
        raise ValueError(
            f"expected a unit of the same quantity as {wanted or 'a number without unit'}, "
            f"got {text!r} ({unit}){_meant(text, target)}"
        )
    zero, one = (_registry().Quantity(value, unit).to(target).magnitude for value in (0.0, 1.0))
    return Unit(one - zero, zero, wanted if wanted is not None else f"{target:~}")


@lru_cache(maxsize=1)
def _registry() -> pint.UnitRegistry:
    return pint.UnitRegistry()


def _parsed(text: str) -> Any:
    try:
        return _registry().Unit(text)
    # pint raises what its tokenizer and evaluator happen to raise, assertions among them
    except Exception as reason:
        raise ValueError(
            f"expected a unit that pint knows, such as kPa, deg or mg, got {text!r}"
            f"{_other_case(text)}"
        ) from reason


def _base_unit(unit: Any) -> Any:
    return _registry().get_base_units(unit)[1]


def _other_case(text: str) -> str:
    """The units that were meant, if it only has capitals in the wrong places."""
    tried = dict.fromkeys([*_spellings(text), text.lower()]) if text.isalpha() else ()
    meant = [spelling for spelling in tried if spelling in _registry()]
    return f"; perhaps {' or '.join(meant)}" if meant else ""


def _spellings(text: str) -> Iterator[str]:
    """Ways to write a prefix of one letter and a unit."""
    for first in (text[:1].lower(), text[:1].upper()):
        for rest in (text[1:].lower(), text[1:].capitalize(), text[1:].upper()):
            yield first + rest


def _meant(text: str, target: Any) -> str:
    """The unit of a temperature is easily written as that of a charge or a capacitance."""
    degrees = {"C": "degC", "F": "degF"}
    if target.dimensionality == "[temperature]" and text in degrees:
        return f"; write {degrees[text]}"
    return ""


@dataclass(frozen=True)
class Display:
    """A unit to show values in: shown = factor * SI value + offset."""

    unit: str
    factor: float = 1.0
    offset: float = 0.0

    def shown(self, value: float, digits: int = 3) -> str:
        """A value with its unit, to so many significant digits."""
        return f"{self.number(value, digits)} {self.unit}".rstrip()

    def number(self, value: float, digits: int = 3) -> str:
        """The same without its unit."""
        number = self.factor * value + self.offset
        return f"{float(f'{number:.{digits}g}'):g}" if np.isfinite(number) else "-"


_DISPLAYS = {
    "rad": Display("deg", 180.0 / np.pi),
    "Pa": Display("kPa", 1e-3),
    "Pa/s": Display("kPa/s", 1e-3),
    "kg": Display("mg", 1e6),
    "N m": Display("N mm", 1e3),
    "m": Display("mm", 1e3),
    "K": Display("degC", 1.0, -273.15),
    "1/s": Display("1/s"),
}


def display_of(unit: str) -> Display:
    """How values of an SI unit are shown.

    >>> display_of("rad").shown(0.5)
    '28.6 deg'
    >>> display_of("K").shown(293.15)
    '20 degC'
    """
    return _DISPLAYS.get(unit, Display(unit))
