"""Columns in files of a whole hand: pressures of channels, positions of markers, pose of
the wrist.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from model_lab.importing.cell_words import words
from model_lab.importing.headers import LENGTHS
from model_lab.importing.meaning import WORDS, Meant, is_setpoint, meanings
from model_lab.importing.tables import Column, Table
from model_lab.importing.units import ABSOLUTE, kind_of_pressure, unit_for, usual_unit
from model_lab.measurements.hands import (
    MARKER_AXES,
    default_markers,
    pressure_columns,
)
from model_lab.measurements.units import column_unit
from softhand_common.documents.quoted import listed, shortened
from softhand_common.documents.yaml_document import DocumentError
from softhand_model.hand.hand import HandDescription

Maps = Mapping[str, tuple[str, str]]
"""Column, or the words that the columns of a place have in common, and unit by quantity."""
Groups = dict[tuple[str, ...], dict[str, Column]]
"""Columns by their part (x, qw, roll), of each place or attitude by the words that they share."""

OF_TIME, WRIST, OF_PRESSURE, ALL_PLACES = "time", "wrist", "pressure", "places"
WRIST_TURN = ("qx", "qy", "qz", "qw")  # parts of the wrist's attitude in the world
WRIST_ANGLES = ("roll", "pitch", "yaw")
WRIST_WORDS = {"wrist", "hand", "palm", "base", "flange", "handgelenk", "poignet"}
FINGER_WORDS = {  # of a fingertip, beside its own name
    "thumb": {"daumen", "pouce"},
    "index": {"zeigefinger", "forefinger"},
    "middle": {"mittelfinger", "majeur"},
    "ring": {"ringfinger", "annulaire"},
    "little": {"pinky", "kleiner", "auriculaire"},
}
TURN_WORDS = {"rotation", "orientation", "quat", "quaternion", "rot", "q"}
PLACE_WORDS = {"position", "pos", "place", "translation", "location", "coordinate", "coord"}
LENGTH_WORDS = {"m", "mm", "cm", "meter", "meters", "metre", "metres", "millimeters", "millimetres"}
LEFT_OUT = LENGTH_WORDS | PLACE_WORDS | TURN_WORDS  # of what the names of a position share
USUAL_DISTANCE = (0.5, 2.0)  # of a marker, over the reach of the hand's tips, by hand
REACH = 0.2  # [m] of the tips of a hand from its wrist, in the middle


def hand_meanings(table: Table, hand: HandDescription, given: Maps) -> tuple[Meant, ...]:
    """What the columns of a file mean, with the names in a set of a hand: `time`,
    `pressure.<channel>`, `<marker>.x` ..., `wrist.x` ..., `wrist.qx` ... or `wrist.roll` ...

    given: (column, unit) that the user states, by quantity: `time`, `pressure.a`, a marker or
    `wrist` (with the words that its columns share), `pressure` and `places` (only the unit, for all
    of them). Columns that the file does not have are ignored.

    Raises DocumentError for two columns of one quantity, and for a unit that does not fit.
    """
    places = _places(table, hand, given)
    mine = {one.column for one in places}
    free = tuple(column for column in table.columns if column.name not in mine)
    pressures = _pressures(replace(table, columns=free), hand, given)
    mine |= {one.column for one in pressures}
    free = tuple(column for column in free if column.name not in mine and _may_be_time(column))
    said = {OF_TIME: given[OF_TIME]} if OF_TIME in given else {}
    clock = [one for one in meanings(replace(table, columns=free), said) if one.quantity == OF_TIME]
    return (*clock, *pressures, *places)


def has_markers(table: Table, hand: HandDescription, given: Maps) -> bool:
    """Whether a file has, by the names of its columns, x, y and z of a marker of the hand."""
    whole = [*_triples(table)[0]]
    return any(
        _groups_of(whole, marker, tip, given)
        for marker, tip in zip(default_markers(hand), hand.tips, strict=True)
    )


def partial_markers(table: Table, hand: HandDescription, given: Maps) -> dict[str, list[str]]:
    """Axes that a file has of markers of the hand, by the names of its columns, of which it lacks
    one.
    """
    axes: dict[tuple[str, ...], list[str]] = {}
    for column in table.columns:
        part, rest = _part(words(column.name))
        if part in MARKER_AXES:
            axes.setdefault(rest, []).append(part)
    some = {rest: found for rest, found in axes.items() if len(set(found)) == 2}
    return {
        marker: some[rest]
        for marker, tip in zip(default_markers(hand), hand.tips, strict=True)
        for rest in _groups_of([*some], marker, tip, given)[:1]
    }


def places_in(table: Table) -> list[str]:
    """Names of the columns of x of all positions in a file, but for the wrist."""
    whole = _triples(table)[0].items()
    return [found["x"].name for rest, found in whole if rest and not WRIST_WORDS & set(rest)]


def _may_be_time(column: Column) -> bool:
    return (
        column.is_clock or not usual_unit(column.unit) or unit_for(OF_TIME, column.unit) is not None
    )


# ---------------------------------------------------------------------- places
def _triples(table: Table) -> tuple[Groups, Groups]:
    """Columns of each place, and of each attitude, by the words that they share."""
    places: Groups = {}
    turns: Groups = {}
    for column in table.columns:
        part, rest = _part(words(column.name))
        if part in WRIST_ANGLES or part in WRIST_TURN:
            turns.setdefault(rest, {})[part] = column
        elif part:
            places.setdefault(rest, {})[part] = column
    full = ({*WRIST_TURN}, {*WRIST_ANGLES})
    return (
        {rest: found for rest, found in places.items() if found.keys() == {*MARKER_AXES}},
        {rest: found for rest, found in turns.items() if found.keys() in full},
    )


def _places(table: Table, hand: HandDescription, given: Maps) -> list[Meant]:
    """Columns of places of markers and of the wrist, and of its attitude."""
    whole, turns = _triples(table)
    found: dict[str, dict[str, Column]] = {}
    for name, tip in zip((*default_markers(hand), WRIST), (*hand.tips, ""), strict=True):
        free = [rest for rest in whole if whole[rest] not in found.values()]
        rest = _chosen(table, name, _groups_of(free, name, tip, given))
        if rest is not None:
            found[name] = whole[rest]
    usual = _usual_length(found)
    meant: list[Meant] = []
    for name, columns in found.items():
        said = [given[key][1] for key in (name, ALL_PLACES) if key in given]
        written = [column.unit or _length_in(column.name) for column in columns.values()]
        unit = next((one for one in (*said, *written, usual) if one), "")
        meant += _of_place(table, name, columns, unit)
    rest = _chosen(table, "the attitude of the wrist", _groups_of([*turns], WRIST, "", given))
    if rest is not None:
        meant += [_of_turn(table, part, column) for part, column in turns[rest].items()]
    return meant


def _part(parts: Sequence[str]) -> tuple[str, tuple[str, ...]]:
    """Which part of a place or an attitude a name is, "" for none, and its other words."""
    kept = [word for word in parts if word not in LEFT_OUT]
    turns = any(word in TURN_WORDS for word in parts)
    known = [word for word in kept if word in (*MARKER_AXES, "w", *WRIST_TURN, *WRIST_ANGLES)]
    if len(known) != 1:
        return "", ()
    part = f"q{known[0]}" if turns and known[0] not in (*WRIST_TURN, *WRIST_ANGLES) else known[0]
    return ("" if part == "w" else part), tuple(word for word in kept if word != known[0])


def _groups_of(
    groups: Sequence[tuple[str, ...]], name: str, tip: str, given: Maps
) -> list[tuple[str, ...]]:
    """Groups of columns that are of a marker at a tip, or of the wrist: those of which the user
    says so, else those with its name, of several those that say tip.
    """
    if name in given:
        said = {*words(given[name][0])} - LEFT_OUT
        return [rest for rest in groups if set(rest) == said]
    if name == WRIST:
        if list(groups) == [()]:
            return list(groups)
        return [rest for rest in groups if WRIST_WORDS & set(rest)]
    known = FINGER_WORDS.get(tip, set())
    mine = [rest for rest in groups if set(words(tip)) <= set(rest) or known & set(rest)]
    return [rest for rest in mine if "tip" in rest] or mine


def _chosen(table: Table, name: str, groups: Sequence[tuple[str, ...]]) -> tuple[str, ...] | None:
    if len(groups) > 1:
        raise DocumentError(
            f"{table.path}: {name}: expected the columns of one position, got "
            f"{listed(' '.join(one) for one in groups)}; say which: "
            f"--map '{name}={' '.join(groups[0])}'"
        )
    return groups[0] if groups else None


def _of_place(table: Table, name: str, found: Mapping[str, Column], unit: str) -> list[Meant]:
    if not unit:
        raise DocumentError(
            f"{table.path}: expected the unit of {listed(one.name for one in found.values())}, got "
            f"none; for all positions at once: --map {ALL_PLACES}=:mm"
        )
    try:
        column_unit(f"{name}.x", unit)
    except ValueError as reason:
        raise DocumentError(f"{table.path}: {found['x'].name}: unit: {reason}") from None
    return [Meant(found[axis].name, f"{name}.{axis}", unit) for axis in MARKER_AXES]


def _length_in(name: str) -> str:
    """The unit of length that ends a name, "" for none."""
    last = words(name)[-1]
    return last if last in LENGTHS else ""


def _usual_length(found: Mapping[str, Mapping[str, Column]]) -> str:
    """The unit in which markers lie about as far from the wrist as fingertips do, "" if none is."""
    place = {
        name: np.stack([one[axis].values for axis in MARKER_AXES]) for name, one in found.items()
    }
    wrist = place.pop(WRIST, 0.0)
    if not place:
        return ""
    far = np.linalg.norm(np.stack([at - wrist for at in place.values()]), axis=1)
    middle, (low, high) = np.nanmedian(far) / REACH, USUAL_DISTANCE
    fitting = [unit for unit in LENGTHS if low <= middle * column_unit("a.x", unit).scale <= high]
    return fitting[0] if len(fitting) == 1 else ""


def _of_turn(table: Table, part: str, column: Column) -> Meant:
    if part in WRIST_TURN:
        return Meant(column.name, f"{WRIST}.{part}", "")
    unit = usual_unit(column.unit)
    if unit not in ("deg", "rad"):
        raise DocumentError(
            f"{table.path}: {column.name}: expected deg or rad in the header, got "
            f"{shortened(column.unit) or 'no unit'}"
        )
    return Meant(column.name, f"{WRIST}.{part}", unit)


# ---------------------------------------------------------------------- pressures
def _pressures(table: Table, hand: HandDescription, given: Maps) -> list[Meant]:
    """Columns of the pressures of channels: those with a channel's name; if there are none,
    numbered ones, as many as channels, in their order.
    """
    likely = [column for column in table.columns if _may_be_pressure(column)]
    likely = [column for column in likely if not is_setpoint(column.name)] or likely
    found: dict[str, Column] = {}
    for name, channel in zip(pressure_columns(hand), hand.channels, strict=True):
        if name in given:
            said = table.column(given[name][0])
            mine = [said] if said is not None else []
        else:
            mine = [column for column in likely if _is_of_channel(column.name, channel)]
        if len(mine) > 1:
            raise DocumentError(
                f"{table.path}: expected one column for {name}, got "
                f"{listed(one.name for one in mine)}; say which: --map '{name}={mine[0].name}'"
            )
        if mine:
            found[name] = mine[0]
    if not found:
        numbered = _numbered(likely, len(hand.channels))
        found = dict(zip(pressure_columns(hand), numbered, strict=False))
    return [_of_pressure(table, name, column, given) for name, column in found.items()]


def _may_be_pressure(column: Column) -> bool:
    if column.is_clock:
        return False
    if column.unit:
        return unit_for(OF_PRESSURE, column.unit) is not None
    known = {*WORDS[OF_PRESSURE].split(), "ch", "channel", "kanal", "canal"}
    return bool(known & set(words(column.name)) or re.match("p[a-z]$", column.name.casefold()))


def _is_of_channel(name: str, channel: str) -> bool:
    parts = words(name)
    return channel.casefold() in parts or f"p{channel.casefold()}" in parts


def _numbered(columns: Sequence[Column], channels: int) -> list[Column]:
    """Columns whose names have the numbers 0 or 1 to that of the channels, in their order."""
    numbers = {}
    for column in columns:
        own = [int(word) for word in words(column.name) if word.isdecimal()]
        if len(own) == 1:
            numbers[own[0]] = column
    ordered = sorted(numbers)
    whole = len(columns) == channels and ordered in (
        [*range(channels)],
        [*range(1, channels + 1)],
    )
    return [numbers[number] for number in ordered] if whole else []


def _of_pressure(table: Table, name: str, column: Column, given: Maps) -> Meant:
    unit = given.get(name, ("", ""))[1] or given.get(OF_PRESSURE, ("", ""))[1] or column.unit
    usual = unit_for(OF_PRESSURE, unit) if unit else None
    if usual is None:
        raise DocumentError(
            f"{table.path}: {column.name}: expected a unit of pressure, got "
            f"{shortened(unit) or 'none'}; for all pressures at once: --map {OF_PRESSURE}=:kPa"
        )
    if kind_of_pressure(unit)[1] == ABSOLUTE:
        raise DocumentError(
            f"{table.path}: {column.name}: expected gauge pressures, got {shortened(unit)}; "
            "subtract the pressure of the air"
        )
    return Meant(column.name, name, usual)
