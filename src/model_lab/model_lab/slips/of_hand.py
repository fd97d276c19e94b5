"""Slips that a set of a hand may have: columns exchanged, another unit, another frame."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from typing import Any

from model_lab.experiments.hand_pose import turned_frame
from model_lab.measurements.hand_frame import WristFrame
from model_lab.measurements.hands import (
    FORCES,
    HAND_MOTION,
    MARKER_AXES,
    TORQUES,
    WITH_WRENCH,
    Plate,
)
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.slips.columns import (
    Candidate,
    column_mend,
    factors_of,
    is_rare,
    one_line,
    stated_unit,
    with_meaning,
    with_renamed,
    with_units,
)

ALL_PRESSURES, ALL_MARKERS = "all pressures", "all markers"
ALL_FORCES, ALL_TORQUES = "all forces", "all torques"


def candidates_of_hand(data: MeasurementSet) -> Iterator[Candidate]:
    """All slips that a set of a hand may have."""
    measured: dict[str, Sequence[str]] = {ALL_MARKERS: data.outputs}
    if data.experiment in WITH_WRENCH:
        measured = {ALL_FORCES: FORCES, ALL_TORQUES: TORQUES}
    for words, columns in ((ALL_PRESSURES, data.pressures), *measured.items()):
        yield from _units(data, words, columns)
    yield _absolute(data)
    for first, second in combinations(data.pressures, 2):
        yield _exchanged(data, (first, second), {first: second, second: first})
    if data.plate is not None and not data.plate.tared:
        yield _tared(data, data.plate)
    if data.experiment in WITH_WRENCH:
        return
    for one, other in combinations(data.markers, 2):
        pairs = {f"{one}.{axis}": f"{other}.{axis}" for axis in MARKER_AXES}
        yield _exchanged(data, (one, other), {**pairs, **{b: a for a, b in pairs.items()}})
    yield from _mirrored(data)
    moves = data.experiment == HAND_MOTION
    frame = None if data.free_frame or moves else turned_frame(data)
    if frame is not None:
        yield _turned(data, frame)


def _turned(data: MeasurementSet, frame: WristFrame) -> Candidate:
    """Places in the frame of a tracked body, not in that of the wrist."""
    free = {
        name: replace(one, hand=replace(one.hand, free_frame=True))
        for name, one in data.specimens.items()
        if one.hand is not None
    }
    entries = {name: {**one.hand.entry()} for name, one in free.items() if one.hand is not None}
    return Candidate(
        "turned",
        ALL_MARKERS,
        "in that of the wrist",
        f"in a frame that is {frame.said}",
        one_line({"specimens": entries}),
        replace(data, specimens=free),
    )


def _units(data: MeasurementSet, words: str, columns: Sequence[str]) -> Iterator[Candidate]:
    """All columns of a quantity in each other usual unit."""
    said = stated_unit(data, columns[0])
    if any(stated_unit(data, column) != said for column in columns):
        return
    for unit, factor in factors_of(data, columns[0]):
        yield Candidate(
            "unit",
            words,
            said,
            unit,
            column_mend(data, {column: {"unit": unit} for column in columns}),
            with_units(data, columns, unit, factor),
            rare=is_rare(columns[0], unit),
        )


def _absolute(data: MeasurementSet) -> Candidate:
    """Absolute pressures in place of gauge pressures."""
    entries = {
        column: {"unit": stated_unit(data, column), "is": "absolute"} for column in data.pressures
    }
    mended = with_meaning(data, data.pressures, "absolute")
    words = ("gauge pressure", "absolute pressure")
    return Candidate("absolute", ALL_PRESSURES, *words, column_mend(data, entries), mended)


def _tared(data: MeasurementSet, plate: Plate) -> Candidate:
    """A force sensor that was set to zero with the fingers bent."""
    tared = replace(plate, tared=True)
    return Candidate(
        "tared",
        ALL_FORCES,
        "without the weight of the unbent hand",
        "zero at the beginning of each run (tared)",
        one_line({"plate": tared.entry()}),
        replace(data, plate=tared),
    )


def _exchanged(
    data: MeasurementSet, names: tuple[str, str], sources: Mapping[str, str]
) -> Candidate:
    """Two channels, or two markers, exchanged; sources: column from which each one is."""
    first, second = names
    entries: dict[str, dict[str, Any]] = {
        column: {"unit": stated_unit(data, column), "from": source}
        for column, source in sources.items()
    }
    return Candidate(
        "exchanged",
        f"{first}, {second}",
        f"{first} and {second}",
        f"{second} and {first}, exchanged",
        column_mend(data, entries),
        with_renamed(data, sources),
    )


def _mirrored(data: MeasurementSet) -> Iterator[Candidate]:
    """A frame of the markers with an axis the other way round, or with two axes exchanged."""
    for axis in MARKER_AXES:
        columns = [f"{marker}.{axis}" for marker in data.markers]
        entries = {
            column: {"unit": stated_unit(data, column), "is": "negative"} for column in columns
        }
        mended = with_meaning(data, columns, "negative")
        fits = f"in a frame whose {axis} is the other way round"
        yield _of_frame(data, fits, entries, mended)
    for first, second in combinations(MARKER_AXES, 2):
        sources = {
            f"{marker}.{axis}": f"{marker}.{other}"
            for marker in data.markers
            for axis, other in ((first, second), (second, first))
        }
        from_others: dict[str, dict[str, Any]] = {
            column: {"unit": stated_unit(data, column), "from": source}
            for column, source in sources.items()
        }
        fits = f"in a frame whose {first} and {second} are exchanged"
        yield _of_frame(data, fits, from_others, with_renamed(data, sources))


def _of_frame(
    data: MeasurementSet,
    fits: str,
    entries: Mapping[str, Mapping[str, Any]],
    mended: MeasurementSet,
) -> Candidate:
    said = "in that of the wrist"
    return Candidate("mirrored", ALL_MARKERS, said, fits, column_mend(data, entries), mended)
