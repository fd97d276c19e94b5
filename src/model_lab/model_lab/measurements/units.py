"""Units of measured columns, which may be any that pint knows, and units in which values
are shown.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from model_lab.aliases import Array
from softhand_common.documents.quoted import quoted

if TYPE_CHECKING:
    import pint

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
    "curvature": "1/m",
    "radius": "m",
    "displacement": "m",
    "force": "N",
}  # those whose quantity is known; any other column may have any unit
MARKER_COLUMN = re.compile(r".+\.[xyz]")
QUATERNION_COLUMN = re.compile(r".+\.q[xyzw]")
LARGEST_VALUES = {
    "s": 1e11,
    "Pa": 1e12,
    "Pa s": 1e15,
    "N": 1e12,
    "N m": 1e12,
    "m": 1e12,
    "rad": 1e12,
    "kg": 1e5,
    "K": 1e5,
}  # of a measured value in SI units: what is larger is a slip of the recording
LARGEST_OTHER_VALUE = 1e15
LONGEST_UNIT, LONGEST_EXPONENT = 60, 3  # characters
_NUMBER = re.compile(r"(?<![\w.])[\d.]+")  # that is not part of a name
CACHED_UNITS = 256  # units of a set, looked up once


def unit_of(column: str) -> str | None:
    """SI unit of a column; None where its quantity is not known.

    >>> unit_of("pressure.a"), unit_of("index_tip.x"), unit_of("speed")
    ('Pa', 'm', None)
    """
    if column in COLUMN_UNITS:
        return COLUMN_UNITS[column]
    if column.startswith("pressure."):
        return "Pa"
    if column.startswith("mass."):
        return "kg"
    if QUATERNION_COLUMN.fullmatch(column):
        return ""
    if column.startswith("wrench."):
        return "N m" if column.startswith("wrench.t") else "N"
    return "m" if MARKER_COLUMN.fullmatch(column) else None


def largest(unit: str | None) -> float:
    """The largest value that is accepted for a quantity in this SI unit; None for an unknown unit.

    >>> largest("Pa")
    1000000000000.0
    """
    return LARGEST_VALUES.get(unit or "", LARGEST_OTHER_VALUE)


@dataclass(frozen=True)
class Unit:
    """A unit of a column: SI value = scale * value + offset. si: name of the SI unit."""

    scale: float = 1.0
    offset: float = 0.0
    si: str = ""

    def to_si(self, values: Array) -> Array:
        """Values (n,) in SI units."""
        with np.errstate(over="ignore"):  # who reads the values refuses what is too large
            return self.scale * values + self.offset

    @property
    def largest(self) -> float:
        """The largest value that is accepted in this unit; the offset is not taken into account."""
        return largest(self.si) / self.scale


USUAL_UNITS = {
    **{unit: Unit(1.0, 0.0, unit) for unit in ("s", "Pa", "rad", "N", "kg", "m", "K", "Pa s")},
    "": Unit(),
    "ms": Unit(1e-3, 0.0, "s"),
    "kPa": Unit(1e3, 0.0, "Pa"),
    "MPa": Unit(1e6, 0.0, "Pa"),
    "mbar": Unit(1e2, 0.0, "Pa"),
    "bar": Unit(1e5, 0.0, "Pa"),
    "psi": Unit(6894.7572931683635, 0.0, "Pa"),
    "mmHg": Unit(133.322387415, 0.0, "Pa"),
    "kgf/cm**2": Unit(98066.5, 0.0, "Pa"),
    "inH2O": Unit(249.08890999999997, 0.0, "Pa"),
    "cmH2O": Unit(98.06649999999999, 0.0, "Pa"),
    "inHg": Unit(3386.3886403409997, 0.0, "Pa"),
    "atm": Unit(101325.0, 0.0, "Pa"),
    "deg": Unit(np.pi / 180.0, 0.0, "rad"),
    "turn": Unit(2.0 * np.pi, 0.0, "rad"),
    "mrad": Unit(1e-3, 0.0, "rad"),
    "gf": Unit(9.80665e-3, 0.0, "N"),
    "kgf": Unit(9.80665, 0.0, "N"),
    "lbf": Unit(4.4482216152605005, 0.0, "N"),
    "ozf": Unit(0.2780138509537813, 0.0, "N"),
    "percent": Unit(1e-2),
    "mN": Unit(1e-3, 0.0, "N"),
    "mg": Unit(1e-6, 0.0, "kg"),
    "g": Unit(1e-3, 0.0, "kg"),
    "mm": Unit(1e-3, 0.0, "m"),
    "degC": Unit(1.0, 273.15, "K"),
}  # units that are known without pint's list


@lru_cache(maxsize=CACHED_UNITS)
def column_unit(column: str, text: str) -> Unit:
    """The unit that a text names, for a column with this name.

    Raises ValueError if pint does not know the unit, or if it measures another quantity than the
    column.

    >>> column_unit("pressure", "kPa")
    Unit(scale=1000.0, offset=0.0, si='Pa')
    >>> column_unit("temperature", "degC").to_si(np.array([20.0])).tolist()
    [293.15]
    """
    if len(text) > LONGEST_UNIT or not _is_simple(text):
        raise ValueError(
            "expected a unit such as kPa, deg or m/s**2, without numbers but 1 and exponents of "
            f"one or two digits, got {quoted(text)}"
        )
    if text.casefold() == "grad":
        raise ValueError(
            f"expected deg, or gon for the 400th part of a turn, got {quoted(text)}, which may be "
            "either"
        )
    usual = USUAL_UNITS.get(text)
    if usual is not None and usual.si == unit_of(column):
        return usual
    try:
        return _unit(_parsed(text), unit_of(column), text)
    except ArithmeticError as reason:  # km**99
        raise ValueError(
            f"expected a unit such as kPa or mm, got {quoted(text)}, which is too large or small"
        ) from reason


def _unit(unit: Any, wanted: str | None, text: str) -> Unit:
    registry = _registry()
    base = registry.get_base_units(unit)[1]
    target = base if wanted is None else registry.Unit(wanted)
    counted = wanted == "rad" and text not in ("", "1") and base != target
    if unit.dimensionality != target.dimensionality or counted:
        raise ValueError(
            f"expected a unit of the same quantity as {wanted or 'a number without unit'}, "
            f"got {quoted(text)} ({unit}){_meant(text, target)}"
        )
    zero, one = (registry.Quantity(value, unit).to(target).magnitude for value in (0.0, 1.0))
    if not 0.0 < abs(one - zero) < np.inf:
        raise OverflowError
    return Unit(one - zero, zero, wanted if wanted is not None else f"{target:~}")


@lru_cache(maxsize=1)
def _registry() -> pint.UnitRegistry:
    import pint  # here, as it and its list of units take long to load

    return pint.UnitRegistry()


def _is_simple(text: str) -> bool:
    """Whether its numbers are 1 or short exponents: pint would evaluate 9**9**9."""
    for number in _NUMBER.finditer(text):
        before = text[: number.start()].rstrip(" (+-")
        after = text[number.end() :].lstrip(" )")
        exponent = before.endswith(("**", "^")) and len(number.group()) <= LONGEST_EXPONENT
        if after.startswith(("**", "^")) or not (exponent or number.group() == "1"):
            return False
    return True


def _parsed(text: str) -> Any:
    try:
        return _registry().Unit(text)
    # pint raises what its tokenizer and evaluator happen to raise, assertions among them
    except Exception as reason:
        raise ValueError(
            f"expected a unit that pint knows, such as kPa, deg or mg, got {quoted(text)}"
            f"{_other_case(text)}"
        ) from reason


def _other_case(text: str) -> str:
    """Units that differ from this one in capital letters alone."""
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
        """A value (given in SI) as text with its unit, to so many significant digits."""
        return f"{self.number(value, digits)} {self.unit}".rstrip()

    def number(self, value: float, digits: int = 3) -> str:
        """A value (given in SI) as text without its unit, to so many significant digits."""
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
    """How values in an SI unit are shown: in a unit of daily use, such as deg or degC.

    >>> display_of("rad").shown(0.5)
    '28.6 deg'
    >>> display_of("K").shown(293.15)
    '20 degC'
    """
    return _DISPLAYS.get(unit, Display(unit))


def display_among(units: Mapping[str, str], unit: str) -> Display:
    """How values in an SI unit, or in such a unit per second, are shown: like the first column in
    `units` (stated unit by column) with this quantity, else in a unit of daily use.

    >>> display_among({"pressure": "psi"}, "Pa/s").unit
    'psi/s'
    >>> display_among({"pressure": "psi"}, "rad").unit
    'deg'
    """
    quantity = unit.removesuffix("/s")
    stated = [name for name in units if quantity and unit_of(name) == quantity]
    if not stated:
        return display_of(unit)
    display = stated_display(stated[0], units[stated[0]])
    return display if quantity == unit else Display(f"{display.unit}/s", display.factor)


def stated_display(column: str, text: str) -> Display:
    """How values of a column are shown in a unit that was stated for it.

    >>> stated_display("pressure", "psi").shown(6894.757)
    '1 psi'
    """
    unit = column_unit(column, text)
    return Display(text, 1.0 / unit.scale, -unit.offset / unit.scale)
