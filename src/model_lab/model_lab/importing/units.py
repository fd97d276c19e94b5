"""Units as people write them in headers, and the name that the lab has for each."""

from __future__ import annotations

import re

from model_lab.measurements.measurement_set import OUTPUTS, TIP_POSE
from model_lab.measurements.units import column_unit

SPELLINGS = {
    "°": "deg",
    "º": "deg",
    "grad": "deg",
    "grados": "deg",
    "degre": "deg",
    "degres": "deg",
    "degree": "deg",
    "degrees": "deg",
    "gradi": "deg",
    "turns": "turn",
    "revolutions": "turn",
    "umdrehung": "turn",
    "umdrehungen": "turn",
    "tours": "turn",
    "radian": "rad",
    "radians": "rad",
    "sek": "s",
    "sec": "s",
    "secs": "s",
    "second": "s",
    "seconds": "s",
    "sekunden": "s",
    "secondes": "s",
    "segundos": "s",
    "msec": "ms",
    "millisec": "ms",
    "millisecond": "ms",
    "millis": "ms",
    "milliseconds": "ms",
    "secondi": "s",
    "minutes": "min",
    "kgf/cm2": "kgf/cm**2",
    "kgf/cm^2": "kgf/cm**2",
    "kgf/cm²": "kgf/cm**2",
    "n/mm2": "N/mm**2",
    "n/mm²": "N/mm**2",
    "n/mm^2": "N/mm**2",
    "kpa": "kPa",
    "mpa": "MPa",
    "hpa": "hPa",
    "pa": "Pa",
    "newton": "N",
    "n": "N",
    "mn": "mN",
    "gf": "gram_force",
    "inh2o": "inH2O",
    "cmh2o": "cmH2O",
    "mmhg": "mmHg",
    "°c": "degC",
    "celsius": "degC",
}
PERCENT, PERCENT_WORDS = "percent", ("%", "percent", "pct", "prozent")
MASS_UNITS = {"g": "gf", "kg": "kgf", "lb": "lbf", "lbs": "lbf", "oz": "ozf"}
"""Units of mass that stand for the weight of it in a column of forces, as scales show it."""
MASSES = ("kg", "g", "mg", "µg", "ug")
TORQUE_UNITS = {"nm": "N m", "ncm": "N cm", "nmm": "N mm", "mnm": "mN m"}
"""By their letters; `nm` alone is a length to pint, and `mNm` is no unit."""
ABSOLUTE, GAUGE = "absolute", "gauge"
DIMENSIONLESS = ("-", "1", "mm/mm", "m/m")
PRESSURE_QUANTITIES = ("pressure", "p_in", "p_out")
TORQUE_COLUMNS = OUTPUTS["base_torque"]
QUANTITIES = ("time", "pressure", "tip_angle", "tip_force", "temperature")
_BRACKETS = re.compile(r"^(?P<name>.*?)\s*[\[(](?P<unit>[^\[\]()]*(?:\([^\[\]()]*\))?)[\])]\s*$")
_KIND = re.compile(
    r"(?P<unit>.*?)[\s_,.(]*(?:(?P<absolute>abs(?:olut\w*)?|a)|gauge|rel(?:ativ\w*)?|g)\.?\)?$",
    re.I,
)  # of a pressure: psia, kPa abs, bar(g)
_SEPARATED = re.compile(r"^(?P<name>.+?)(?:\s*/\s*|\s+in\s+|[_ ]+)(?P<unit>[^\s_]+)$")
_PRODUCT = re.compile(r"(?P<first>.+?)[\s.*·⋅]*s")  # such as kPa*s
_OVER = re.compile(r"^(?P<name>.+)\s*/\s*(?P<unit>[^\s_/]+)$")  # by ISO 80000-1: p_abs/hPa


def usual_unit(text: str) -> str:
    """The unit that a text stands for, as experiment.yaml writes it; "" if the text is no unit.

    >>> usual_unit("Grad"), usual_unit("Umdrehungen"), usual_unit("mbar"), usual_unit("thumb")
    ('deg', 'turn', 'mbar', '')
    """
    plain = text.strip()
    if plain.isdecimal():
        return ""
    lower = plain.lower()
    for candidate in dict.fromkeys((SPELLINGS.get(lower, plain), plain.replace("²", "**2"), lower)):
        if any(_measures(quantity, candidate) for quantity in QUANTITIES):
            return candidate
    return PERCENT if lower in PERCENT_WORDS else ""


def kind_of_pressure(written: str) -> tuple[str, str]:
    """(unit, `absolute` or `gauge`) of a pressure unit as written; the unit is without the part
    that says which of the two it is. The second is "" if there is no such part.

    >>> kind_of_pressure("psia"), kind_of_pressure("bar(g)"), kind_of_pressure("kPa")
    (('psi', 'absolute'), ('bar', 'gauge'), ('kPa', ''))
    """
    found = None if usual_unit(written) else _KIND.match(written.strip())
    if found is None or not usual_unit(found["unit"]):
        return written, ""
    return found["unit"], ABSOLUTE if found["absolute"] else GAUGE


def unit_in_header(cell: str) -> tuple[str, str]:
    """(name, unit as written) in a cell of a header; the unit is "" if there is none.

    >>> unit_in_header("Druck [mbar]"), unit_in_header("p_kPa"), unit_in_header("tip angle")
    (('Druck', 'mbar'), ('p', 'kPa'), ('tip angle', ''))
    >>> unit_in_header("p_abs/hPa"), unit_in_header("gyro_deg/s"), unit_in_header("Dehnung in %")
    (('p_abs', 'hPa'), ('gyro_deg/s', ''), ('Dehnung', '%'))
    """
    found = _BRACKETS.match(cell)
    if found:
        return found["name"].strip() or cell, found["unit"].strip()
    found = _SEPARATED.match(cell.strip())
    if found and _stands_alone(found["unit"]):
        return found["name"], found["unit"]
    found = _OVER.match(cell.strip())
    if found and _stands_alone(found["unit"]) and not unit_in_header(found["name"])[1]:
        return found["name"], found["unit"]  # and not a rate, such as gyro_deg/s
    return cell.strip(), ""


def _stands_alone(written: str) -> bool:
    """Whether a word at the end of a header is a unit: one letter may be part of the name."""
    unit = kind_of_pressure(written)[0]
    return written in ("s", "N", "°", "%") or bool(len(unit) > 1 and usual_unit(unit))


def is_unit(written: str) -> bool:
    """Whether a text is a unit of any column of a set.

    >>> is_unit("N mm"), is_unit("kPa*s"), is_unit("mbar"), is_unit("torque")
    (True, True, True, False)
    """
    if usual_unit(kind_of_pressure(written)[0]):
        return True
    if written in MASSES:
        return True
    return any(unit_for(name, written) for name in ("torque_x", "friction_integral"))


def unit_for(quantity: str, written: str) -> str | None:
    """How experiment.yaml spells a unit that a file has written for a column of this quantity, such
    as percent for %; None if it is not a unit of the quantity.

    >>> unit_for("torque_x", "N·mm"), unit_for("friction_integral", "mbar.s"), unit_for("mass", "s")
    ('N mm', 'mbar s', None)
    """
    if quantity in _SPELLED:
        return _SPELLED[quantity](quantity, written)
    if quantity in ("stretch", "strain"):
        return "" if written in (*DIMENSIONLESS, "") else usual_unit(written) or None
    if quantity in PRESSURE_QUANTITIES:
        written = kind_of_pressure(written)[0]
    if quantity == "tip_force":
        written = MASS_UNITS.get(written.strip().lower(), written)
    if quantity == "time":
        written = written.split(" since ")[0]  # midnight, or a date
    unit = usual_unit(written)
    if unit == "" and quantity == "stress":
        return None
    measured = "pressure" if quantity == "stress" else quantity
    return unit if unit and _measures(measured, unit) else None


def _number(quantity: str, written: str) -> str | None:
    return "" if written in (*DIMENSIONLESS, "") else None


def _torque(quantity: str, written: str) -> str | None:
    return TORQUE_UNITS.get(re.sub(r"[\s.*·⋅-]", "", written).lower()) or _plain(quantity, written)


def _pressure_times_time(quantity: str, written: str) -> str | None:
    found = _PRODUCT.fullmatch(written.strip())
    return _plain(quantity, f"{usual_unit(found['first'])} s" if found else written)


def _plain(quantity: str, written: str) -> str | None:
    """The unit as written, if it is one of the quantity."""
    return written if written.strip() and _measures(quantity, written) else None


_SPELLED = {
    **dict.fromkeys(("direction", *TIP_POSE[3:]), _number),
    **dict.fromkeys(TORQUE_COLUMNS, _torque),
    **dict.fromkeys(("friction_integral", "injector_integral"), _pressure_times_time),
    **dict.fromkeys(("mass", *TIP_POSE[:3]), _plain),
}


def is_length(written: str) -> bool:
    """Whether a unit is one of length: of a displacement or a coordinate, of which no quantity of a
    set is made without a function.

    >>> is_length("mm"), is_length("MPa")
    (True, False)
    """
    return _measures("displacement", written)


def _measures(quantity: str, unit: str) -> bool:
    try:
        column_unit(quantity, unit)
    except ValueError:
        return False
    return True
