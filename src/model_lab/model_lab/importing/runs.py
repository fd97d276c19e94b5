"""Runs of imported files: which files belong to one run, joined on one clock, with the whole course
of the input.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.polynomial import Polynomial

from model_lab.aliases import Array
from model_lab.importing.clocks import is_newest_first, restarts, spread
from model_lab.importing.meaning import INPUT, TRUE, Meant
from model_lab.importing.tables import Table
from model_lab.measurements.at_rest import white_noise
from model_lab.measurements.rows import check_time
from model_lab.measurements.units import column_unit
from softhand_common.documents.quoted import listed
from softhand_common.documents.yaml_document import DocumentError

MIN_OFFSET_SAMPLES = 3.0  # samples of the output by which clocks must differ to be told
CLEAR_GAIN = 0.5  # unexplained variance that an offset must remove to be told
LARGEST_OFFSET = 0.5  # of the length of a run
OFFSET_STEPS = 200
MIN_SAMPLES = 8  # from which an offset is sought
COPY_SAMPLES, COPY_NOISE = 20, 1e-4  # samples, and their noise over their range
OVERLAP = 0.8  # share of the outputs that must lie within the input's time
CUBIC = 4  # coefficients
FINER_STEPS = 41
SAME_CLOCK = 0.15  # share of an offset by which those of one clock may differ; by hand


@dataclass(frozen=True)
class Source:
    """A file and what its columns mean."""

    table: Table
    meanings: tuple[Meant, ...]

    @property
    def quantities(self) -> set[str]:
        """Quantities of its columns, without time; a strain counts as a stretch."""
        names = {one.quantity for one in self.meanings} - {"time"}
        return {"stretch" if name == "strain" else name for name in names}

    def series(self, quantity: str) -> tuple[Array | None, Array]:
        """(times (k,) [s], values (k,) in the unit of the file) of a quantity, without rows that
        lack either; times are None without a clock.

        A strain is turned into a stretch, and a true stress into a nominal one. Rows written newest
        first are reversed, and rows that share a stamp of a coarse clock are spaced evenly. Raises
        DocumentError for a true stress without a stretch or strain beside it.
        """
        time, values = self._as_written(quantity)
        if time is None:
            return None, values
        if is_newest_first(time):
            time, values = time[::-1], values[::-1]
        return spread(time), values

    def remarks(self, quantity: str) -> list[str]:
        """What was changed in a quantity and its time stamps, as sentences."""
        time, _ = self._as_written(quantity)
        said, file = self._of_true(quantity), self.table.path.name
        if time is None:
            return said
        if is_newest_first(time):
            said.append(f"{file}: its rows begin with the newest, and were reversed")
            time = time[::-1]
        same = len(time) - len(np.unique(time))
        if same and np.all(np.diff(spread(time)) > 0.0):
            said.append(
                f"{file}: {same} of {len(time)} rows have the stamp of the row before; rows that "
                "share a stamp are spread evenly until the next one"
            )
        return said

    def _as_written(self, quantity: str) -> tuple[Array | None, Array]:
        by_quantity = {one.quantity: one for one in self.meanings}
        values = self._as_needed(quantity)
        time = self.values_of(by_quantity["time"]) if "time" in by_quantity else None
        if time is None:
            return None, values[np.isfinite(values)]
        time = time * column_unit("time", by_quantity["time"].unit or "s").scale
        known = np.isfinite(values) & np.isfinite(time)
        return time[known], values[known]

    def _of_true(self, quantity: str) -> list[str]:
        """What became of a true stress or strain, as sentences."""
        done = {
            ("stretch", "strain"): "turned into the stretch, exp(strain)",
            ("stress", "stress"): "divided by the stretch: the nominal stress",
        }
        return [
            f"{self.table.path.name}: {one.column} was {done[quantity, one.quantity]}"
            for one in self.meanings
            if one.kind == TRUE and (quantity, one.quantity) in done
        ]

    def _as_needed(self, quantity: str) -> Array:
        """Values (rows,) of a quantity; of a strain the stretch, of a true stress the nominal."""
        by_quantity = {one.quantity: one for one in self.meanings}
        meant = by_quantity.get(quantity) or by_quantity["strain"]
        values = self.values_of(meant)
        if meant.quantity == "strain":
            strain = values * column_unit("stretch", meant.unit or "").scale
            return np.exp(strain) if meant.kind == TRUE else 1.0 + strain
        if meant.kind != TRUE:
            return values
        if "stretch" not in self.quantities:
            raise DocumentError(
                f"{self.table.path}: {meant.column}: expected a stretch or strain in the same "
                "file, by which a true stress is divided, got none"
            )
        return values / self._as_needed("stretch")

    def values_of(self, meant: Meant) -> Array:
        """Values (rows,) of a column, in the unit of its meaning; NaN where a cell is empty."""
        by_name = {one.name: one for one in self.table.columns}
        return by_name[meant.column].values * meant.scale


@dataclass(frozen=True)
class ImportedRun:
    """An imported run.

    columns (samples,): at the times of its outputs, in the units of the files; time [s] starts at
    0. lead (k,): time and input before the first output. late: file of the outputs, and the time
    [s] by which its clock seems late against that of the inputs.
    """

    name: str
    columns: Mapping[str, Array]
    lead: Mapping[str, Array]
    files: tuple[Path, ...]
    remarks: tuple[str, ...] = ()
    late: tuple[str, float] | None = None


def paired(sources: Sequence[Source], needed: Sequence[str]) -> list[tuple[Source, ...]]:
    """The files of each run: one file with all `needed` quantities, or two, one with the input and
    one with the output.

    Two files belong together if their names are the same apart from words for what they hold; if
    there are only two files, they always do. Raises DocumentError for a file without partner.
    """
    whole: list[tuple[Source, ...]] = [
        (one,) for one in sources if one.quantities.issuperset(needed)
    ]
    parts = [one for one in sources if not one.quantities.issuperset(needed)]
    if not parts:
        return whole
    by_run: dict[str, list[Source]] = {}
    keys = _common_names(parts) if len(parts) > 2 else dict.fromkeys(map(_path, parts), "run")
    for part in parts:
        by_run.setdefault(keys[_path(part)], []).append(part)
    for members in by_run.values():
        have = set().union(*(one.quantities for one in members))
        lacking = [name for name in needed if name not in have]
        if lacking or len(members) != 2:
            names = listed([str(_path(one)) for one in members])
            raise DocumentError(
                f"{names}: expected {' and '.join(needed)} of one run, got "
                f"{'no ' + ' and no '.join(lacking) if lacking else f'{len(members)} files'}; name "
                "the files of a run alike, such as r1_pressure.csv and r1_angle.csv, or say with "
                f"--map {(lacking or needed)[0]}=COLUMN:UNIT which column it is"
            )
    return whole + [tuple(members) for members in by_run.values()]


def _path(source: Source) -> Path:
    return source.table.path


def _common_names(parts: Sequence[Source]) -> dict[Path, str]:
    """By file, the words of its name that also occur in the name of a file of another role."""
    words = {_path(one): re.findall(r"[a-z]+|\d+", _path(one).stem.casefold()) for one in parts}
    found = {}
    for one in parts:
        others = [words[_path(two)] for two in parts if two.quantities != one.quantities]
        shared = [word for word in words[_path(one)] if any(word in other for other in others)]
        found[_path(one)] = "_".join(shared)
    return found


def joined(members: Sequence[Source], experiment: str, needed: Sequence[str]) -> ImportedRun:
    """The run that one or two files hold. Raises DocumentError if two files have no time in
    common.
    """
    driving = INPUT[experiment]
    output = next(name for name in needed if name != driving)
    of_input = next(one for one in members if driving in one.quantities)
    of_output = next(one for one in members if output in one.quantities)
    paths = tuple(dict.fromkeys(map(_path, members)))
    name = run_name(paths)
    check_clock(of_input, driving, driving)
    check_clock(of_output, output, driving)
    if of_input is of_output:
        return _of_one_file(of_input, name, driving, output, paths)
    time, values = of_output.series(output)
    input_time, inputs = of_input.series(driving)
    if time is None or input_time is None:
        lacking = of_output if time is None else of_input
        raise DocumentError(
            f"{_path(lacking)}: expected a column of time, to join it with the other file of "
            "the run, got none; say --map time=COLUMN:UNIT"
        )
    remarks = [*of_input.remarks(driving), *of_output.remarks(output)]
    if min(time[-1], input_time[-1]) <= max(time[0], input_time[0]):
        remarks.append("the clocks of the two files cannot be compared: both begin at 0")
        time, input_time = time - time[0], input_time - input_time[0]
    inside = (time >= input_time[0]) & (time <= input_time[-1])
    if inside.sum() < 3:
        raise DocumentError(
            f"{paths[0]}: expected three or more samples at times within those of {paths[-1]}, got "
            f"{inside.sum()}; --shift FILE=SECONDS shifts the clock of a file"
        )
    if not inside.all():
        remarks.append(
            f"{_path(of_output).name}: {int((~inside).sum())} of {len(inside)} samples are left "
            f"out, as {_path(of_input).name} has none at their times"
        )
    time, values = time[inside], values[inside]
    offset = clock_offset(input_time, inputs, time, values)
    late = (_path(of_output).name, offset) if offset else None
    columns, lead = _at_outputs(input_time, inputs, time, values)
    return ImportedRun(
        name, _named(columns, driving, output), _named(lead, driving), paths, tuple(remarks), late
    )


def remarks_on_clocks(runs: Sequence[ImportedRun]) -> list[str]:
    """What `--shift` would correct. Files whose clocks are late by about the same time share one
    clock, as those of a camera do, and so their median.
    """
    late = dict(run.late for run in runs if run.late)
    if not late:
        return []
    middle = float(np.median(list(late.values())))
    if all(abs(offset - middle) <= SAME_CLOCK * abs(middle) for offset in late.values()):
        late = dict.fromkeys(late, middle)
    return [
        f"{file}: its clock seems {abs(offset):.2f} s {'late' if offset > 0 else 'early'} "
        f"(no times were changed; --shift {file}={-offset:.3g} corrects them)"
        for file, offset in late.items()
    ]


def without_copies(runs: Sequence[ImportedRun]) -> tuple[tuple[ImportedRun, ...], list[str]]:
    """(the runs without those that hold the same noisy numbers as an earlier one, what was left out
    as sentences); readings without noise may well be equal.
    """
    first: dict[bytes, str] = {}
    kept, said = [], []
    for run in runs:
        numbers = b"".join(values.tobytes() for values in run.columns.values())
        if numbers in first and any(map(_is_noisy, run.columns.values())):
            said.append(f"{run.name} holds the same numbers as {first[numbers]} and is left out")
            continue
        first.setdefault(numbers, run.name)
        kept.append(run)
    return tuple(kept), said


def _is_noisy(values: Array) -> bool:
    """Whether there are so many readings, with so much noise, that no others are the same."""
    return len(values) >= COPY_SAMPLES and white_noise(values) > COPY_NOISE * float(np.ptp(values))


def check_clock(source: Source, quantity: str, driving: str) -> None:
    """Raise DocumentError where the times of a quantity do not rise."""
    time, values = source.series(quantity)
    if time is not None:
        anew = restarts(time)
        if len(anew):
            row = int(anew[0])
            raise DocumentError(
                f"{_path(source)}: row {row + 1} of {quantity}: its clock begins anew there, at "
                f"{time[row]:.6g} s after {time[row - 1]:.6g} s; if another run begins with it, "
                "say --split-restarts"
            )
        columns = {"time": time - time[0]} | ({driving: values} if quantity == driving else {})
        check_time(_path(source), columns, lambda index: f"row {index + 1} of {quantity}")


def _of_one_file(
    source: Source, name: str, driving: str, output: str, paths: tuple[Path, ...]
) -> ImportedRun:
    """The run of a file that has all; its rows without output keep their input."""
    time, values = source.series(output)
    input_time, inputs = source.series(driving)
    remarks = tuple(dict.fromkeys([*source.remarks(driving), *source.remarks(output)]))
    if time is None or input_time is None:
        if len(values) != len(inputs):
            raise DocumentError(
                f"{paths[0]}: expected a column of time, which rows with empty cells need, got "
                "none; say --map time=COLUMN:UNIT"
            )
        return ImportedRun(name, {driving: inputs, output: values}, {}, paths, remarks)
    columns, lead = _at_outputs(input_time, inputs, time, values)
    named = _named(columns, driving, output), _named(lead, driving)
    return ImportedRun(name, *named, paths, remarks)


def _named(columns: Sequence[Array], *names: str) -> dict[str, Array]:
    """Columns by name, time first; empty where there are no rows."""
    return dict(zip(("time", *names), columns, strict=True)) if len(columns[0]) else {}


def _at_outputs(
    input_time: Array, inputs: Array, time: Array, values: Array
) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
    """Time, input and output at the stamps of the output, and time and input before its first;
    times begin at 0. The lead has no more samples than the output would have had.
    """
    zero = min(time[0], input_time[0])
    before = input_time[input_time < time[0]]
    usual = float(np.median(np.diff(time))) if len(time) > 1 else 0.0
    if len(before) > 1 and (before[-1] - before[0]) / (len(before) - 1) < usual:
        before = np.arange(before[0], time[0] - usual / 2.0, usual)
    lead = (before - zero, np.interp(before, input_time, inputs))
    return (time - zero, np.interp(time, input_time, inputs), values), lead


def run_name(paths: Sequence[Path]) -> str:
    """Name of a run: its file's, or what the names of its files have in common."""
    if len(paths) == 1:
        return paths[0].stem
    first, second = (re.findall(r"[A-Za-z]+|\d+", path.stem) for path in paths)
    return "_".join(word for word in first if word in second) or "run"


def clock_offset(input_time: Array, inputs: Array, time: Array, values: Array) -> float | None:
    """Time [s] by which the clock of the outputs is late (positive) against the clock of the
    inputs; None unless a shift brings the two together clearly better. The arguments are times [s]
    and values of the inputs, and of the outputs.

    The shift is the one at which a cubic function of the input leaves least of the output.
    """
    length = min(float(np.ptp(time)), float(np.ptp(input_time)))
    usual = float(np.median(np.diff(time)))
    shifts = np.linspace(-LARGEST_OFFSET, LARGEST_OFFSET, 2 * OFFSET_STEPS + 1) * length
    left = np.array([_unexplained(input_time, inputs, time - shift, values) for shift in shifts])
    best = int(np.argmin(left))
    far = abs(shifts[best]) >= MIN_OFFSET_SAMPLES * usual
    if not far or left[best] >= CLEAR_GAIN * left[OFFSET_STEPS]:
        return None
    finer = shifts[best] + np.linspace(-1.0, 1.0, FINER_STEPS) * (shifts[1] - shifts[0])
    return float(
        min(finer, key=lambda shift: _unexplained(input_time, inputs, time - shift, values))
    )


def _unexplained(input_time: Array, inputs: Array, time: Array, values: Array) -> float:
    """Share of the variance of an output that a cubic function of the input leaves."""
    inside = (time >= input_time[0]) & (time <= input_time[-1])
    if inside.sum() < max(MIN_SAMPLES, OVERLAP * len(time)):
        return 1.0
    seen, measured = np.interp(time[inside], input_time, inputs), values[inside]
    if np.ptp(seen) == 0.0 or np.ptp(measured) == 0.0:
        return 1.0
    curve = Polynomial.fit(seen, measured, CUBIC - 1)
    left = np.sum((measured - curve(seen)) ** 2) / (len(seen) - CUBIC)
    return float(left / np.var(values))
