"""Units in which people read: degrees, kilopascal, milligram."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


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
