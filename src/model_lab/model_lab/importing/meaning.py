"""What the columns of a file mean, from their names in English, German or French and from their
units.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from model_lab.importing.cell_words import words
from model_lab.importing.clocks import DAY
from model_lab.importing.tables import SHORT_CLOCK, Column, Table
from model_lab.importing.units import (
    ABSOLUTE,
    PRESSURE_QUANTITIES,
    is_length,
    kind_of_pressure,
    unit_for,
    usual_unit,
)
from model_lab.measurements.measurement_set import INPUTS, OUTPUTS
from model_lab.rules import RULES
from softhand_common.documents.quoted import listed, shortened
from softhand_common.documents.yaml_document import DocumentError

RUBBER_TEST, VALVE_PULSE, BASE_TORQUE = "rubber", "valve_pulse", "base_torque"
WORDS = {
    "time": "time zeit temps tiempo tempo t millis micros stamp timestamp zeitstempel uhrzeit "
    "heure hora sec seconds elapsed clock datetime prufzeit messzeit versuchszeit",
    "pressure": "pressure druck pression presion pressione p press innendruck kammerdruck "
    "luftdruck",
    "tip_angle": "angle winkel angulo angolo theta phi alpha bend bending biegung biegewinkel "
    "spitzenwinkel flexion",
    "tip_force": "force kraft fuerza forza fz fn blockierkraft spitzenkraft effort load",
    "stretch": "stretch lambda streckung etirement estiramiento",
    "strain": "strain dehnung deformation deformacion deformazione epsilon allongement",
    "stress": "stress spannung contrainte tension sforzo sigma",
    "temperature": "temperature temperatur temp",
}  # of each quantity; long ones are also found inside of other words
SETPOINT_WORDS = (
    "set",
    "setpoint",
    "target",
    "command",
    "commanded",
    "cmd",
    "ref",
    "reference",
) + (
    "desired",
    "demand",
    "consigne",
    "consigna",
)  # of values that were asked of a controller, not measured
ELSEWHERE_WORDS = (
    "supply",
    "source",
    "tank",
    "reservoir",
    "compressor",
    "ambient",
    "atmospher",
    "barometr",
    "versorgung",
    "vordruck",
    "umgebung",
    "alimenta",
    "amb",
)  # how words of pressures begin that were not measured in the actuator
RAW_WORDS = ("raw", "adc", "count", "counts", "volt", "volts", "voltage")
"""Words of what a sensor gave before its calibration."""
SPREAD_WORDS = ("sd", "std", "stdev", "sem", "sigma", "error", "err", "deviation")
"""Words of how much repeats differ."""
TRUE_WORDS = (
    *("true", "cauchy", "log", "logarithmic", "hencky", "wahr", "wahre", "logarithmische"),
    *("vrai", "vraie", "verdadera", "vera", "reale"),
)
"""Words of a stress over the area as it is then, and of a logarithmic strain."""
TRUE = "true"  # kind of such a stress or strain
HEADER_STAMP = "header.stamp"  # of a ROS message: when it was measured
TELLING_UNITS = {
    "pressure": ("Pa", "hPa", "kPa", "mbar", "bar", "psi", "mmHg", "inH2O", "cmH2O"),
    "tip_angle": ("deg", "rad"),
    "tip_force": ("N", "mN", "kN"),
    "temperature": ("degC",),
}  # units that say what a column without a telling name is
QUATERNION_PART = re.compile(r"(?:orientation|rotation|quat\w*)[._ ]?[xyzw]$|^q_?[xyzw]$", re.I)
TIME_UNITS = {"millis": "ms", "milliseconds": "ms", "ms": "ms", "micros": "us", "us": "us"}
"""Units that names of columns of time stand for, as microcontrollers write them."""
CAMERA_RATE = re.compile(r"(\d+(?:\.\d+)?)\s*(?:Hz|fps)$", re.I)  # of a column that counts frames
EVEN = 0.01  # by which steps of a column of time may differ, as a share; times are rounded
COUNT_WORDS = {"step", "schritt", "point", "punkt", "nr", "no"}  # of readings taken by hand
LETTERS_INSIDE = 5  # letters from which on a word is found inside of another
EPOCH_UNITS = (1.0, 1e-3, 1e-6, 1e-9)  # [s] of 1 in numbers since 1970
SERIAL_DAYS = (2e4, 8e4)  # [days] since 1900 as spreadsheets count them: 1954 to 2119
EPOCH_SECONDS = (9e8, 4e9)  # [s] between which a number since 1970 is believed: 1998 to 2096
WHOLE_STEP = 5.0  # between whole numbers, from which on they may as well be milliseconds
BY_COLUMNS = {
    "free_bending": ("pressure", "tip_angle"),
    "blocked_tip": ("pressure", "tip_force"),
    "uniaxial": ("stretch", "stress"),
}  # beside time; stretch may be given as a strain
INPUT = {"free_bending": "pressure", "blocked_tip": "pressure"} | dict.fromkeys(
    ("uniaxial", RUBBER_TEST), "stretch"
)
NEEDED = {
    **BY_COLUMNS,
    RUBBER_TEST: ("stretch", "stress"),
    VALVE_PULSE: (*INPUTS[VALVE_PULSE], *OUTPUTS[VALVE_PULSE]),
    BASE_TORQUE: (*INPUTS[BASE_TORQUE][1:], *OUTPUTS[BASE_TORQUE]),
}  # beside time, of each experiment that is imported


CLOCK_SCALES = {"h": 60.0, "min": 1.0}  # by unit of the first part of a clock of two parts


@dataclass(frozen=True)
class Meant:
    """What a column of a file means.

    column: its name in the file. quantity: its name in a set, or `strain`. unit: as experiment.yaml
    writes it; "" if the quantity has none, None if it is not known. scale: factor that brings the
    numbers of the file to that unit where the unit does not (clocks in seconds). kind: `absolute`
    for a pressure whose name or unit says so, `true` for a true stress or strain; else "".
    """

    column: str
    quantity: str
    unit: str | None
    scale: float = 1.0
    kind: str = ""

    @property
    def is_sure(self) -> bool:
        """Whether the unit is known, so that the user need not be asked."""
        return self.unit is not None


def meanings(
    table: Table, given: Mapping[str, tuple[str, str]], experiment: str | None = None
) -> tuple[Meant, ...]:
    """Meanings of the columns of a file; each quantity occurs at most once.

    Args:
        table: the file.
        given: (column, unit) that the user states for all files, by quantity. A unit of "" stands
            for the one in the file; the unit of time may be a frame rate such as 30Hz. Columns that
            this file does not have are ignored.
        experiment: its name; None: not stated.

    Raises DocumentError if several columns may be the same quantity and it may be needed, or a unit
    does not fit its quantity.
    """
    found: dict[str, Meant] = {}
    possible = possible_experiments(given, experiment)
    taken = {name.casefold() for name, _ in given.values()}
    for quantity, (name, unit) in given.items():
        column = table.column(name)
        if column is not None:
            found[quantity] = stated(table, column, quantity, unit)
    for quantity in WORDS:
        filled = [one for one in table.columns if np.isfinite(one.values).any()]
        free = [one for one in filled if one.name.casefold() not in taken]
        likely = [one for one in free if _quantity(one) == quantity]
        if not likely:
            likely = [one for one in free if not _quantity(one) and _by_unit(one) == quantity]
        elsewhere = quantity in given and quantity != "time"  # each file has times of its own
        if quantity in found or elsewhere or not likely:
            continue
        likely = _with_unit(measured(likely), quantity)
        if len(likely) > 1:
            without = [name for name in possible if not needs(name, quantity)]
            if len(without) == len(possible):
                continue
            instead = f", or --experiment {' or '.join(without)}" if without else ""
            raise DocumentError(
                f"{table.path}: expected one column for {quantity}, got "
                f"{listed([one.name for one in likely])}; "
                f"say which: --map '{quantity}={likely[0].name}'{instead}"
            )
        found[quantity] = meant_as(likely[0], quantity)
    if "time" not in found and not found.keys() & {"stretch", "strain", "stress"}:
        named = {one.column for one in found.values()}
        counting = [
            one
            for one in free
            if one.name not in named and _quantity(one) is None and _counts_evenly(one)
        ]
        if len(counting) == 1:
            (clock,) = counting
            spelt = unit_for("time", clock.unit) if clock.unit else None
            found["time"] = Meant(clock.name, "time", spelt)
    return tuple(found.values())


def possible_experiments(stated: Iterable[str], experiment: str | None) -> list[str]:
    """Names of the experiments with all stated quantities; `experiment` alone where it is stated.

    >>> possible_experiments(["time", "tip_angle"], None), possible_experiments([], "uniaxial")
    (['free_bending'], ['uniaxial'])
    """
    if experiment is not None:
        return [experiment]
    every = [one for one in stated if one not in ("time", "temperature")]
    return [name for name in BY_COLUMNS if all(needs(name, one) for one in every)] or list(NEEDED)


def needs(experiment: str, quantity: str) -> bool:
    """Whether an experiment has a column of this quantity; a stretch may be given as a strain."""
    return quantity == "time" or {"strain": "stretch"}.get(quantity, quantity) in NEEDED[experiment]


def measured(columns: list[Column]) -> list[Column]:
    """The columns that were measured on the specimen: without set-points, pressures of the supply
    or the air, readings before calibration and standard deviations, and true stresses and strains;
    of several time stamps those of the measurement. If none would remain, nothing is left out.
    """
    for is_other in (is_setpoint, _is_elsewhere, _is_raw_or_spread, _is_true):
        columns = [one for one in columns if not is_other(one.name)] or columns
    return [one for one in columns if HEADER_STAMP in one.name] or columns


def _is_elsewhere(name: str) -> bool:
    """Whether a pressure is that of the supply or of the air around."""
    return any(word.startswith(ELSEWHERE_WORDS) for word in re.split(r"[^a-z]+", name.casefold()))


def _is_raw_or_spread(name: str) -> bool:
    """Whether a name says that a reading is not calibrated, or how much readings differ."""
    words = re.split(r"[^a-z]+", name.casefold())
    return any(word in RAW_WORDS + SPREAD_WORDS for word in words)


def _is_true(name: str) -> bool:
    """Whether a name is that of a true stress or of a logarithmic strain."""
    words = set(re.split(r"[^a-z]+", name.casefold()))
    kinds = {*WORDS["stress"].split(), *WORDS["strain"].split()}
    return bool(words & set(TRUE_WORDS) and words & kinds)


def _with_unit(columns: list[Column], quantity: str) -> list[Column]:
    """The columns without those whose unit is none of the quantity, such as counts, if others have
    one that is.
    """
    fits = [unit_for(quantity, one.unit) is not None for one in columns]
    kept = [one for one, good in zip(columns, fits, strict=True) if good or not one.unit]
    return kept if any(fits) else columns


def is_setpoint(name: str) -> bool:
    """Whether the name of a column says that its values were commanded, not measured.

    >>> is_setpoint("Solldruck"), is_setpoint("p_set [kPa]"), is_setpoint("p_sensor")
    (True, True, False)
    """
    words = re.split(r"[^a-z]+", name.casefold())
    return any(word in SETPOINT_WORDS or word.startswith("soll") for word in words)


def _counts_evenly(column: Column) -> bool:
    """Whether a column with a name rises by equal steps, as one of time or frames does."""
    steps = np.diff(column.values)
    even = len(steps) > 1 and bool(np.all(np.abs(steps - steps[0]) <= EVEN * np.abs(steps[0])))
    unnamed = column.name.startswith("column ") or COUNT_WORDS & set(words(column.name))
    return even and steps[0] > 0.0 and not unnamed


def stated(table: Table, column: Column, quantity: str, unit: str) -> Meant:
    """The meaning of a column as the user states it. Raises DocumentError for a component of a
    quaternion in the place of an angle, and for a unit that does not fit the quantity.
    """
    if quantity == "tip_angle" and QUATERNION_PART.search(column.name):
        whole = column.name[:-1].rstrip("._ ")
        raise DocumentError(
            f"{table.path}: expected an angle, got {column.name}, one of the four numbers of a "
            f"quaternion; compute the angle by --map 'tip_angle=quaternion({whole})'"
        )
    if column.unit == SHORT_CLOCK and unit in CLOCK_SCALES:
        return Meant(column.name, quantity, "s", CLOCK_SCALES[unit])
    if not unit or column.is_clock:
        return meant_as(column, quantity)
    rate = CAMERA_RATE.match(unit)
    if rate and quantity == "time" and float(rate[1]) > 0.0:
        return Meant(column.name, "time", "s", 1.0 / float(rate[1]))
    usual = unit_for(quantity, unit)
    if usual is None:
        raise DocumentError(
            f"{table.path}: expected a unit of {quantity}, got {shortened(unit)} "
            f"(--map {quantity}={shortened(column.name)}:{shortened(unit)})"
        )
    return Meant(column.name, quantity, usual, kind=_kind(quantity, column.name, unit))


def quantity_of(column: Column) -> str | None:
    """The quantity that the name of a column says, or else its unit alone; None if neither does."""
    return _quantity(column) or _by_unit(column)


def _quantity(column: Column) -> str | None:
    """The quantity that the name of a column says, None if it says none or its unit another."""
    plain = unicodedata.normalize("NFKD", column.name.casefold())
    plain = "".join(letter for letter in plain if not unicodedata.combining(letter))
    words = [word for word in re.split(r"[^a-z]+", plain) if word]
    for quantity, known in WORDS.items():
        names = known.split()
        inside = [name for name in names if len(name) >= LETTERS_INSIDE]
        named = any(word in names for word in words) or any(name in plain for name in inside)
        if named and _fits(quantity, column):
            return quantity
    return "time" if column.is_clock else None


def _by_unit(column: Column) -> str | None:
    """The quantity that the unit of a column alone says."""
    unit = usual_unit(column.unit) if column.unit and not column.is_clock else ""
    return next((name for name, units in TELLING_UNITS.items() if unit in units), None)


def _fits(quantity: str, column: Column) -> bool:
    """Whether the unit that the file writes, if any, is one of the quantity."""
    if column.is_clock or not column.unit:
        return quantity == "time" or not column.is_clock
    if unit_for(quantity, column.unit) is not None:
        return True
    return not usual_unit(column.unit) and not is_length(column.unit)


def meant_as(column: Column, quantity: str) -> Meant:
    """The meaning of a column that is this quantity, in the unit that the file writes."""
    if quantity == "time":
        return _time(column)
    unit, kind = unit_for(quantity, column.unit), _kind(quantity, column.name, column.unit)
    if quantity == "strain" and not column.unit:
        unit = "percent" if np.nanmax(np.abs(column.values)) > RULES.largest_strain else ""
    return Meant(column.name, quantity, unit, kind=kind)


def _kind(quantity: str, name: str, unit: str) -> str:
    """`absolute` of a pressure whose unit says so, or whose name does and its unit nothing; of
    pressures that are expected to be absolute also `gauge`; `true` of such a stress or strain.
    """
    if quantity in ("stress", "strain"):
        return TRUE if _is_true(name) else ""
    if quantity not in PRESSURE_QUANTITIES:
        return ""
    said = kind_of_pressure(unit)[1]
    words = re.split(r"[^a-z]+", name.casefold())
    named = any(word == "abs" or word.startswith(("absol", "assol")) for word in words)
    if said == ABSOLUTE or (named and not said):
        return ABSOLUTE
    return said if quantity != "pressure" else ""


def _time(column: Column) -> Meant:
    """Time in the unit that the file writes, else since 1970 in the unit in which it is about
    today, in seconds if that makes a run of usual length and steps, or in days if only that does
    and they are dates of a spreadsheet.
    """
    if column.is_clock:
        return Meant(column.name, "time", None if column.unit == SHORT_CLOCK else "s")
    if column.unit:
        return Meant(column.name, "time", unit_for("time", column.unit))
    if column.name.casefold() in TIME_UNITS:
        return Meant(column.name, "time", TIME_UNITS[column.name.casefold()])
    for scale in EPOCH_UNITS:
        if EPOCH_SECONDS[0] <= float(np.nanmin(column.values)) * scale <= EPOCH_SECONDS[1]:
            return Meant(column.name, "time", "s", scale)
    known = column.values[np.isfinite(column.values)]
    low, high = RULES.durations
    usual = low < float(np.ptp(known)) < high
    dated = SERIAL_DAYS[0] < known.min() <= known.max() < SERIAL_DAYS[1]
    if dated and not usual and low < DAY * float(np.ptp(known)) < high:
        return Meant(column.name, "time", "s", DAY)
    steps = np.diff(known)
    whole = bool(np.all(known == np.round(known))) and float(np.median(steps)) >= WHOLE_STEP
    return Meant(column.name, "time", "s" if usual and not whole else None)


def experiment_of(quantities: Iterable[str], stated: Iterable[str] = ()) -> str | None:
    """The experiment all of whose columns are among these quantities; None if that holds for none,
    or for several.

    stated: quantities that the user named. Of several experiments, the one that needs most of them
    is taken.
    """
    have, said = (
        {"stretch" if name == "strain" else name for name in names}
        for names in (quantities, stated)
    )
    fitting = [name for name, needed in BY_COLUMNS.items() if have.issuperset(needed)]
    most = max((len(said & set(NEEDED[name])) for name in fitting), default=0)
    fitting = [name for name in fitting if len(said & set(NEEDED[name])) == most]
    return fitting[0] if len(fitting) == 1 else None
