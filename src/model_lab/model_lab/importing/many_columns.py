"""Valve pulses, and torques of a held finger on its base: what the many columns of their files
mean, and their runs.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from model_lab.aliases import Array
from model_lab.importing.cell_words import words
from model_lab.importing.derived import TIP_WORDS
from model_lab.importing.derived_columns import Maps
from model_lab.importing.hand_columns import PLACE_WORDS, TURN_WORDS
from model_lab.importing.headers import LENGTHS
from model_lab.importing.meaning import (
    BASE_TORQUE,
    NEEDED,
    VALVE_PULSE,
    Meant,
    meanings,
    meant_as,
    measured,
    quantity_of,
    stated,
)
from model_lab.importing.runs import ImportedRun, Source, check_clock, run_name
from model_lab.importing.tables import Column, Table
from model_lab.importing.units import GAUGE, MASSES, is_length, unit_for, usual_unit
from model_lab.measurements.measurement_set import DEFLATE, INFLATE, OUTPUTS, TIP_POSE
from model_lab.measurements.units import column_unit
from model_lab.rules import RULES
from softhand_common.documents.quoted import listed
from softhand_common.documents.yaml_document import DocumentError

INTEGRALS = ("friction_integral", "injector_integral")  # of pulses, which files may lack
ABSOLUTES = ("p_in", "p_out")  # of pulses
PULSE_NAMES = {
    "direction": r"direction|richtung|^sens$|^dir$|direccion|direzione",
    "duration": r"duration|dauer|pulse?width|pulse?length|opening|offnungszeit|pulslange|^duree|"
    r"^duracion|^durata|ontime",
    "friction_integral": r"friction.*int|reibung.*int",
    "injector_integral": r"injector.*int|injektor.*int",
    "p_in": r"^p(ressure)?e?in$|upstream|inlet|eingang|vordruck|amont|entrada|ingresso",
    "p_out": r"^p(ressure)?(out|aus)$|downstream|outlet|ausgang|nachdruck|hinterdruck|aval|salida"
    r"|uscita",
    "mass": r"^m$|mass|masse|masa",
}  # in the words of a name, joined, without those of its unit
MASS_RATE = re.compile(r"flow|durchfluss|debit|rate")  # of a mass
TORQUE_WORDS = {"torque", "moment", "drehmoment", "momento", "couple", "coppia", "par", "m", "t"}
FORCE_WORDS = {"force", "kraft", "fuerza", "forza", "f"}
AXIS = re.compile(r"(?P<family>[mtfq]?)(?P<axis>[xyzw])")
LACKING = 1  # columns that files may lack and still tell its experiment
FRAME = (
    "the tip is expected in the frame of the base (z along the finger, x towards the side to which "
    "it bends), and the torque as that of the finger on its base"
)


def with_many_columns(tables: Sequence[Table], given: Maps) -> str | None:
    """The experiment, VALVE_PULSE or BASE_TORQUE, of which at most one column is missing in the
    files, by the names of their columns; else None.
    """
    columns = [column for table in tables for column in table.columns]
    for experiment in (VALVE_PULSE, BASE_TORQUE):
        likely = {name for column in columns for name in _likely(experiment, column)}
        likely |= {quantity_of(column) or "" for column in columns} & {"pressure"}
        if len(set(NEEDED[experiment]) - likely - given.keys()) <= LACKING:
            return experiment
    return None


def meanings_of_many(table: Table, experiment: str, given: Maps) -> tuple[Meant, ...]:
    """Meanings of the columns of a file of VALVE_PULSE or BASE_TORQUE, like `meaning.meanings`.

    Raises DocumentError if several columns may be the same quantity, or a unit does not fit.
    """
    found: dict[str, Meant] = {}
    for quantity, (name, unit) in given.items():
        column = table.column(name)
        if column is not None and quantity in (*NEEDED[experiment], *INTEGRALS):
            found[quantity] = stated(table, column, quantity, unit)
    taken = {name.casefold() for name, _ in given.values()}
    free = [column for column in table.columns if column.name.casefold() not in taken]
    for quantity in dict.fromkeys(name for column in free for name in _likely(experiment, column)):
        likely = measured([one for one in free if quantity in _likely(experiment, one)])
        of_tip = [one for one in likely if TIP_WORDS & set(words(one.name))]
        likely = of_tip or likely
        if quantity in given:
            continue
        if len(likely) > 1:
            raise DocumentError(
                f"{table.path}: expected one column for {quantity}, got "
                f"{listed([one.name for one in likely])}; "
                f"say which: --map '{quantity}={likely[0].name}'"
            )
        found[quantity] = meant_as(_with_unit(likely[0], quantity), quantity)
    usual = ("time", "pressure") if experiment == BASE_TORQUE else ()
    rest = tuple(one for one in free if quantity_of(one) in usual and not _likely(experiment, one))
    said = {name: given[name] for name in usual if name in given}
    named = [column for name, _ in said.values() if (column := table.column(name))]
    if rest or named:
        found |= {
            one.quantity: one
            for one in meanings(replace(table, columns=(*rest, *named)), said)
            if one.quantity in usual
        }
    return tuple(found.values())


def _likely(experiment: str, column: Column) -> list[str]:
    """The quantities, none or one, that the name of a column says and its unit does not deny."""
    name = _of_pulses(column) if experiment == VALVE_PULSE else _of_torque(column)
    if name is None:
        return []
    unit = _with_unit(column, name).unit
    denied = bool(unit) and unit_for(name, unit) is None and bool(usual_unit(unit) or _known(unit))
    return [] if denied else [name]


def _known(unit: str) -> bool:
    return is_length(unit) or unit_for("torque_x", unit) is not None


def _of_pulses(column: Column) -> str | None:
    plain = "".join(_name(column))
    if MASS_RATE.search(plain):
        return None
    return next((name for name, pattern in PULSE_NAMES.items() if re.search(pattern, plain)), None)


def _of_torque(column: Column) -> str | None:
    parts = _name(column)
    axes = [found for one in parts if (found := AXIS.fullmatch(one))]
    if len(axes) != 1:
        return None
    named, axis = {*parts, axes[0]["family"]}, axes[0]["axis"]
    unit = _with_unit(column, "torque_x").unit
    if named & FORCE_WORDS:
        return None
    is_torque = unit_for("torque_x", unit) is not None or (not unit and named & TORQUE_WORDS)
    if is_torque:
        return f"torque_{axis}" if axis != "w" else None
    if named & TURN_WORDS:
        return f"tip_q{axis}"
    if axis == "w":
        return None
    placed = named & (PLACE_WORDS | TIP_WORDS) or parts == [axis] or is_length(unit)
    return f"tip_{axis}" if placed else None


def _name(column: Column) -> list[str]:
    """The words of the name of a column, without a unit at its end."""
    last = re.split(r"[\s_/]+", column.name)[-1]
    whole = [one for one in words(column.name) if not one.isdecimal()]
    of_unit = len(words(last)) if last != column.name and _is_written_unit(last) else 0
    return whole[: len(whole) - of_unit]


def _is_written_unit(text: str) -> bool:
    return text in (*LENGTHS, *MASSES) or (
        len(text) > 1 and any(unit_for(name, text) for name in ("torque_x", *INTEGRALS))
    )


def _with_unit(column: Column, quantity: str) -> Column:
    """The column with the unit at the end of its name, if it has no other: `Mx_Nmm`."""
    last = re.split(r"[\s_/]+", column.name)[-1]
    if column.unit or last == column.name or len(last) < 2 or not unit_for(quantity, last):
        return column
    return replace(column, unit=last)


def open_absolutes(sources: Sequence[Source]) -> dict[str, str]:
    """Questions about pressures of pulses that are too low to be absolute, but not called gauge."""
    every = [
        (source, one) for source in sources for one in source.meanings if one.quantity in ABSOLUTES
    ]
    sure = [(source, one) for source, one in every if one.unit and not one.kind]
    low = any(
        np.nanmin(column_unit(one.quantity, one.unit or "").to_si(source.values_of(one)))
        < RULES.atmosphere[0]
        for source, one in sure
    )
    if not low:
        return {}
    return {
        f"whether {one.quantity} is absolute": f"--map '{one.quantity}={one.column}:{one.unit}(a)' "
        f"if it is, else --map '{one.quantity}={one.column}:{one.unit}(g)'"
        for _, one in sure
    }


# ---------------------------------------------------------------------- runs
def run_of_many(members: Sequence[Source], experiment: str) -> ImportedRun:
    """The run that one or two files hold: of pulses one row for each; of torques all columns at the
    times of the torques.

    Raises DocumentError for pulses in two files, for a direction other than INFLATE and DEFLATE,
    and for torques without times in common with the rest.
    """
    paths = tuple(dict.fromkeys(one.table.path for one in members))
    if experiment == BASE_TORQUE:
        return _of_torques(members, paths)
    source = members[0]
    if len(members) > 1:
        raise DocumentError(
            f"{listed(map(str, paths))}: expected {listed(NEEDED[VALVE_PULSE])} of each pulse in "
            "one row of one file, got them in several files; join these to one table"
        )
    present = [name for name in (*NEEDED[VALVE_PULSE], *INTEGRALS) if name in source.quantities]
    by_name = {one.quantity: one for one in source.meanings}
    columns = {name: source.values_of(by_name[name]) for name in present}
    _check_direction(paths[0], by_name["direction"].column, columns["direction"])
    return _of_whole_rows(columns, paths)


def _check_direction(path: Path, column: str, values: Array) -> None:
    wrong = np.isfinite(values) & ~np.isin(values, (INFLATE, DEFLATE))
    if wrong.any():
        raise DocumentError(
            f"{path}: column {column}, direction of the pulses: expected words such as inflate and "
            f"deflate, or {INFLATE:g} (inflate) and {DEFLATE:g} (deflate), got "
            f"{values[int(np.argmax(wrong))]:g}"
        )


def _of_torques(members: Sequence[Source], paths: tuple[Path, ...]) -> ImportedRun:
    outputs = OUTPUTS[BASE_TORQUE]
    remarks: list[str] = []
    series: dict[str, tuple[Array, Array]] = {}
    for name in NEEDED[BASE_TORQUE]:
        source = next(one for one in members if name in one.quantities)
        check_clock(source, name, "pressure")
        time, values = source.series(name)
        if time is None:
            raise DocumentError(
                f"{source.table.path}: expected a column of time, which {BASE_TORQUE} needs, "
                "got none; --map time=COLUMN:UNIT"
            )
        series[name] = time, values
        remarks += source.remarks(name)
    series |= _smooth_turn({name: series[name] for name in TIP_POSE[3:]})
    stamps = [times for times, _ in series.values()]
    time = series[outputs[0]][0]
    first, last = max(one[0] for one in stamps), min(one[-1] for one in stamps)
    inside = time[(time >= first) & (time <= last)]
    if len(inside) < 3:
        raise DocumentError(
            f"{listed(map(str, paths))}: expected some time in common of torque, pose and "
            f"pressure, got none: {time[0]:.6g} to {time[-1]:.6g} s, and {first:.6g} to "
            f"{last:.6g} s; --shift FILE=SECONDS shifts a clock"
        )
    columns = {name: np.interp(inside, *one) for name, one in series.items()}
    lost = len(time) - len(inside)
    if lost:
        remarks.append(
            f"{paths[0].name}: {lost} of {len(time)} samples are left out, as not all columns have "
            "values at their times"
        )
    found = _of_whole_rows({"time": inside - inside[0]} | columns, paths)
    return replace(found, remarks=(*dict.fromkeys(remarks), *found.remarks, FRAME))


def _smooth_turn(parts: Mapping[str, tuple[Array, Array]]) -> dict[str, tuple[Array, Array]]:
    """Components (k,) of quaternions whose sign does not jump: q and -q are the same attitude, but
    not what lies between them.
    """
    if len({len(times) for times, _ in parts.values()}) > 1:
        return dict(parts)
    turn = np.stack([values for _, values in parts.values()])
    jumps = np.sum(turn[:, 1:] * turn[:, :-1], axis=0) < 0.0
    sign = np.cumprod(np.where(np.concatenate([[False], jumps]), -1.0, 1.0))
    return {name: (times, sign * values) for name, (times, values) in parts.items()}


def _of_whole_rows(columns: Mapping[str, Array], paths: tuple[Path, ...]) -> ImportedRun:
    """The run of the rows that have all values."""
    known = np.isfinite(np.stack([*columns.values()]))
    whole = np.all(known, axis=0)
    lost = int((~whole).sum())
    said = (f"{paths[0].name}: {lost} of {len(whole)} rows lack a value and are left out",)
    kept = {name: values[whole] for name, values in columns.items()}
    return ImportedRun(run_name(paths), kept, {}, paths, said if lost else ())


def gauge_entries(sources: Iterable[Source]) -> dict[str, str]:
    """The pressures of pulses that the files call gauge, each with its unit.

    Raises DocumentError if only some of the files call them so.
    """
    found: dict[str, str] = {}
    for name in ABSOLUTES:
        meant = [one for source in sources for one in source.meanings if one.quantity == name]
        kinds = {one.kind == GAUGE for one in meant}
        if len(kinds) > 1:
            raise DocumentError(
                f"{name}: expected absolute pressures in all files, or gauge pressures in all, got "
                f"both; mark gauge pressures by --map '{name}=COLUMN:UNIT(g)', or import the files "
                "one by one"
            )
        if kinds == {True}:
            found[name] = meant[0].unit or ""
    return found
