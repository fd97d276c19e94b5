"""Numbers as people write them: decimal points or commas, signs between thousands, exponents.

A cell such as 1,234 may be a little more than one or more than a thousand. So the decimal sign is
found from all cells of a column, and if these do not tell, from the other columns.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence

import numpy as np
import pandas as pd

from model_lab.aliases import Array

SIGNS = (".", ",")
MISSING = ("", "-", "--", "nan", "na", "n/a", "null", "none", "#n/a", "inf", "-inf")
DECIMAL, THOUSANDS, OPEN = "decimal", "thousands", "open"
_MINUS = str.maketrans({"\u2212": "-", "\u2013": "-"})
_BETWEEN_THOUSANDS = re.compile(r"(?<=\d)[ '\u2019\u00a0\u2009\u202f](?=\d{3}(?!\d))")
_FORTRAN = re.compile(r"(?<=[\d.,])[dD](?=[+-]?\d)")
_NUMERAL = re.compile(r"[+-]?(?P<digits>\d[\d.,]*|[.,]\d+)(?P<exponent>[eE][+-]?\d+)?$")
_SIMPLE = re.compile(r"-?\d+(?:[.,]\d*)?$")
_GROUPED = re.compile(r"\d{1,3}(?:([.,])\d{3})(?:\1\d{3})*$")

Roles = Mapping[str, frozenset[str]]
"""By sign (point, comma): as what it is used, of DECIMAL, THOUSANDS and OPEN (either)."""


def is_missing(cell: str) -> bool:
    """Whether a cell is empty or marks a missing number.

    >>> is_missing("NaN"), is_missing("0")
    (True, False)
    """
    return cell.lower() in MISSING


def is_number(cell: str) -> bool:
    """Whether a cell contains a number, with a decimal point or comma.

    >>> is_number("-1.234,5e-3"), is_number("12 345,6"), is_number("A12"), is_number("1.3.2024")
    (True, True, False, False)
    """
    if _SIMPLE.match(cell):
        return True
    found = _NUMERAL.match(_plain(cell))
    return found is not None and _roles_in(found) is not None


def roles(cells: Iterable[str]) -> Roles:
    """For what points and commas are used in the numbers of some cells: decimals, thousands, or
    either.
    """
    found: dict[str, set[str]] = {sign: set() for sign in SIGNS}
    for cell in cells:
        match = _NUMERAL.match(_plain(cell)) if "." in cell or "," in cell else None
        for sign, role in (_roles_in(match) or {}).items() if match else ():
            found[sign].add(role)
    return {sign: frozenset(seen) for sign, seen in found.items()}


def _roles_in(match: re.Match[str]) -> dict[str, str] | None:
    """As what the signs of one number are used; None where they make no number."""
    digits = match["digits"]
    present = sorted((sign for sign in SIGNS if sign in digits), key=digits.rfind)
    if not present:
        return {}
    last = present[-1]
    if len(present) == 2:
        whole = digits[: digits.rfind(last)]
        grouped = _GROUPED.match(whole) and last not in whole
        return {last: DECIMAL, present[0]: THOUSANDS} if grouped else None
    if digits.count(last) > 1:
        return {last: THOUSANDS} if _GROUPED.match(digits) else None
    whole, _, rest = digits.partition(last)
    is_open = len(rest) == 3 and 0 < len(whole) <= 3 and whole[0] != "0" and not match["exponent"]
    return {last: OPEN if is_open else DECIMAL}


def decimal_sign(cells: Sequence[str], others: Roles, point: bool = False) -> str:
    """The decimal sign of the numbers in a column.

    Args:
        cells: cells of the column.
        others: for what points and commas are used in the whole file, see `roles`.
        point: whether a point that may be either is a decimal point, as in files with commas
            between columns.

    Raises ValueError if signs contradict each other, or may be either.
    """
    own = roles(cells)
    sign = _sign_by(own)
    if sign is None and any(OPEN in own[one] for one in SIGNS):
        try:
            sign = _sign_by(others)
        except ValueError:
            sign = None
        sign = sign or _by_looks(cells, own, point)
    return sign or "."


def _sign_by(seen: Roles) -> str | None:
    """The decimal sign that is certain; ValueError where signs contradict each other."""
    decimal = {sign for sign in SIGNS if DECIMAL in seen[sign]}
    thousands = {sign for sign in SIGNS if THOUSANDS in seen[sign]}
    decimal |= {_other(sign) for sign in thousands}
    if len(decimal) == 2 or decimal & thousands:
        raise ValueError("decimal points as well as decimal commas")
    return next(iter(decimal), None)


def _by_looks(cells: Sequence[str], own: Roles, point: bool) -> str:
    """The decimal sign of a column whose numbers may be read both ways."""
    with_point = [cell for cell in cells if not is_missing(cell) and "." in cell]
    if OPEN not in own[","] and (point or len(with_point) == len(cells)):
        return "."
    example = next(cell for cell in cells if _GROUPED.match(_plain(cell).lstrip("+-")))
    raise ValueError(f"{example}, whose separator may be a decimal sign or a thousands separator")


def _other(sign: str) -> str:
    return SIGNS[1 - SIGNS.index(sign)]


def numbers(cells: Sequence[str], decimal: str) -> Array:
    """Numbers (rows,) in cells that use the given decimal sign; NaN for a cell without a number.

    >>> numbers(["1.234,5", "-2,5", "x"], ",").tolist(), numbers(["1,234.5"], ".").tolist()
    ([1234.5, -2.5, nan], [1234.5])
    """
    texts = pd.Series([_plain(cell) for cell in cells], dtype=str)
    texts = texts.str.replace(_other(decimal), "", regex=False)
    texts = texts.str.replace(decimal, ".", regex=False)
    texts = texts.mask(texts.str.lower().isin(MISSING))
    return np.asarray(pd.to_numeric(texts, errors="coerce"), float)


def _plain(cell: str) -> str:
    """A cell without signs of typesetters, blanks between thousands, and exponents of Fortran."""
    if cell.isascii() and " " not in cell and "'" not in cell and "d" not in cell.lower():
        return cell
    return _FORTRAN.sub("e", _BETWEEN_THOUSANDS.sub("", cell.translate(_MINUS)))
