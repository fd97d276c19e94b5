"""Import of measurement files into a set: what the columns are proposed to mean, what is still
open, and the set.
"""

from __future__ import annotations

import fnmatch
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeVar

import numpy as np
import yaml

from model_lab.importing.cell_words import mode_in
from model_lab.importing.derived_columns import Maps, as_derived, with_derived
from model_lab.importing.geometry import finger_of_hand
from model_lab.importing.levels import one_row_a_level
from model_lab.importing.lost_tracking import without_lost_tracking
from model_lab.importing.many_columns import (
    meanings_of_many,
    run_of_many,
    with_many_columns,
)
from model_lab.importing.meaning import (
    BASE_TORQUE,
    INPUT,
    NEEDED,
    RUBBER_TEST,
    VALVE_PULSE,
    experiment_of,
    meanings,
)
from model_lab.importing.open_questions import open_questions
from model_lab.importing.order import as_recorded, by_dates
from model_lab.importing.remarks import (
    remarks_on_files,
    remarks_on_new,
    remarks_on_repeats,
    remarks_on_specimens,
)
from model_lab.importing.runs import (
    ImportedRun,
    Source,
    joined,
    paired,
    remarks_on_clocks,
    without_copies,
)
from model_lab.importing.runs_apart import parted_at_restarts, runs_apart
from model_lab.importing.set_columns import (
    KELVIN,
    columns_of,
    in_one_unit,
    remarks_on_air,
    temperatures_in_names,
    temperatures_of,
    with_temperatures,
)
from model_lab.importing.specimens import (
    Assigned,
    assigned,
    new_specimens,
    protocols_by_drive,
    protocols_of,
)
from model_lab.importing.stated_noise import stated_noise
from model_lab.importing.strips import moduli_words, own_moduli, strip_modulus
from model_lab.importing.tables import Table, read_tables
from model_lab.measurements.drives import drive_of
from model_lab.measurements.measurement_set import SET_FORMAT, TEMPERATURE
from model_lab.measurements.units import column_unit
from softhand_common.documents.output_file import write_files
from softhand_common.documents.quoted import listed, shortened
from softhand_common.documents.yaml_document import DocumentError
from softhand_model.model_file import FREE_VALUE

SPECIMEN = "finger"  # where no hand says what was measured
T = TypeVar("T")
STRIPS = {
    "uniaxial": "strip",
    RUBBER_TEST: "sheet",
    VALVE_PULSE: "channel",
}  # likewise, by experiment
DIGITS = 9  # of the numbers of a set


@dataclass(frozen=True)
class Proposal:
    """The content of files, as determined before anything is written.

    sources: files with the meaning of their columns. experiment: its name; None if the columns do
    not tell. unsure: what the user still has to say, each with the text to add to the command.
    modes: of a test of rubber, the mode of each file by its name.
    """

    sources: tuple[Source, ...]
    experiment: str | None
    unsure: Mapping[str, str]
    modes: Mapping[str, str] = field(default_factory=dict)

    @property
    def rows(self) -> list[tuple[str, str, str, str, str]]:
        """(file, column, unit as written, quantity, unit in the set) of every column."""
        return [row for source in self.sources for row in _rows(source)]


def _rows(source: Source) -> Iterable[tuple[str, str, str, str, str]]:
    meant = {one.column: one for one in source.meanings}
    for column in source.table.columns:
        found = meant.get(column.name)
        quantity = found.quantity if found else "-"
        unit = "?" if found and found.unit is None else (found.unit or "") if found else ""
        yield source.table.path.name, column.name, column.unit, quantity, unit


@dataclass(frozen=True)
class ImportedSet:
    """A measurement set that is ready to be written.

    document: content of experiment.yaml. runs: their tables. remarks: what the user should know
    about the import. sized: whether the specimens have the dimensions that the base model needs.
    """

    document: Mapping[str, object]
    runs: tuple[ImportedRun, ...]
    remarks: tuple[str, ...]
    sized: bool = True

    def files(self, folder: Path) -> dict[Path, str]:
        """What `write` writes, by path: the text of experiment.yaml and of one CSV file per run."""
        text = yaml.safe_dump(dict(self.document), sort_keys=False, allow_unicode=True, width=120)
        tables = {folder / f"{run.name}.csv": csv_of(run) for run in self.runs}
        return {folder / "experiment.yaml": text} | tables

    def write(self, folder: Path) -> None:
        """Write the set into a folder."""
        write_files(self.files(folder))


def propose(
    paths: Sequence[Path],
    experiment: str | None = None,
    maps: Maps | None = None,
    messages: Path | None = None,
    decimal: str = "",
    sheets: Mapping[str, str] | None = None,
    modes: Mapping[str, str] | None = None,
    split_restarts: bool = False,
) -> Proposal:
    """Propose the meaning of the columns of measurement files, from their names, units and numbers.

    Args:
        paths: CSV or text files in any dialect, spreadsheets, MAT files, or bags.
        experiment: free_bending, blocked_tip, uniaxial, rubber, valve_pulse or base_torque; None:
            found out from the columns.
        maps: (column, unit) that the user states, by quantity; for the tip angle, a function of
            columns may take the place of the column, see `derived`.
        messages: folder of definitions of message types that a bag does not define; None: no
            folder.
        decimal: decimal sign in text files; "": found out from their numbers.
        sheets: name of the sheet of a spreadsheet, by the name of its file; "" for all others.
        modes: uniaxial, pure_shear or equibiaxial, by the name of the file of a test of rubber; ""
            for all others. Files without are taken as their names say.
        split_restarts: whether a new run begins where the clock of a file begins anew or
            pauses.

    Raises DocumentError for a file that cannot be read or is ambiguous, and for a unit that does
    not fit its quantity.
    """
    if experiment is not None and experiment not in NEEDED:
        raise DocumentError(
            f"experiment: expected one of {listed(NEEDED)}, got {shortened(experiment)}"
        )
    given = maps or {}
    tables = by_dates(_tables(as_recorded(paths), given, messages, decimal, sheets or {}))
    _check_maps(tables, given)
    given = {quantity: as_derived(name, unit) for quantity, (name, unit) in given.items()}
    many = experiment if experiment in (VALVE_PULSE, BASE_TORQUE) else None
    many = many or (None if experiment else with_many_columns(tables, given))
    every = tuple(
        Source(
            table,
            meanings_of_many(table, many, given) if many else meanings(table, given, experiment),
        )
        for table in tables
    )
    if split_restarts:
        every = tuple(part for source in every for part in parted_at_restarts(source))
    sources = tuple(source for source in every if source.quantities) or every
    found = (
        experiment
        or many
        or experiment_of(set().union(*(one.quantities for one in sources)), stated=given)
    )
    known = _modes(sources, modes or {})
    if found == "uniaxial" and not experiment and set(known.values()) - {"", "uniaxial"}:
        found = RUBBER_TEST
    if modes and found not in (None, RUBBER_TEST):
        raise DocumentError(
            f"--mode: expected a test of rubber (--experiment {RUBBER_TEST}), got the columns of "
            f"{found}"
        )
    known = known if found == RUBBER_TEST else {}
    found, unsure = open_questions(every, sources, found, known)
    return Proposal(every if unsure else sources, found, unsure, known)


def _tables(
    paths: Sequence[Path],
    given: Maps,
    messages: Path | None,
    decimal: str,
    sheets: Mapping[str, str],
) -> list[Table]:
    """The tables of the runs in the files, with derived columns."""
    names = told_apart(paths)
    sheets = of_files("--sheet", sheets, [name.name for name in names])
    tables: list[Table] = []
    for path, name in zip(paths, names, strict=True):
        before = name.name.removesuffix(path.name)
        for table in read_tables(
            path, messages, decimal, sheets.get(name.name, sheets.get("", ""))
        ):
            named = replace(table, path=table.path.with_name(before + table.path.name))
            named = one_row_a_level(named)
            tables += [with_derived(without_lost_tracking(run), given) for run in runs_apart(named)]
    return tables


def _modes(sources: Sequence[Source], stated: Mapping[str, str]) -> dict[str, str]:
    """The mode of a test of rubber, by the name of each file: as stated, or as its name says; "" if
    neither says it.
    """
    names = [source.table.path.name for source in sources]
    stated = of_files("--mode", stated, names)
    said = stated.get("", "")
    return {name: stated.get(name) or mode_in(Path(name).stem) or said for name in names}


def told_apart(paths: Sequence[Path]) -> list[Path]:
    """The paths by which files are known: files of the same name get their folder's in front.

    >>> [path.name for path in told_apart([Path("thin/r.csv"), Path("thick/r.csv")])]
    ['thin_r.csv', 'thick_r.csv']
    """
    names = [path.name for path in paths]
    return [
        path.with_name(f"{path.resolve().parent.name}_{path.name}")
        if names.count(path.name) > 1
        else path
        for path in paths
    ]


def of_files(option: str, given: Mapping[str, T], files: Iterable[str]) -> dict[str, T]:
    """What an option says of files, by their names; patterns such as `fast_*` stand for the files
    that they match, and "" for all. Raises DocumentError for a file that is not there.
    """
    known, found = list(dict.fromkeys(files)), dict[str, T]()
    for name, value in given.items():
        meant = [name] if name in (*known, "") else fnmatch.filter(known, name)
        if not meant:
            raise DocumentError(
                f"{option}: expected one of the files {listed(known)}, got {shortened(name)}"
            )
        found |= dict.fromkeys(meant, value)
    return found


def _check_maps(tables: Sequence[Table], maps: Maps) -> None:
    """Raise DocumentError for a column that no file has."""
    for quantity, (name, _) in maps.items():
        if not any(table.column(name) for table in tables):
            known = dict.fromkeys(column.name for table in tables for column in table.columns)
            raise DocumentError(
                f"--map {quantity}: expected a column of the files ({listed(known)}), "
                f"got {shortened(name)}"
            )


def make_set(
    proposal: Proposal,
    hand: str | None = None,
    shifts: Mapping[str, float] | None = None,
    title: str = "",
    specimens: Mapping[str, str] | None = None,
    stretched_to: Mapping[str, float] | None = None,
) -> ImportedSet:
    """Make the measurement set of a proposal that leaves nothing open.

    Args:
        proposal: what the files hold.
        hand: name or file of the hand, or HAND:ACTUATOR, of which the specimen is a finger; None:
            the specimen is not known.
        shifts: time [s] to add to the clock of a file, by its name.
        title: title of the set; "": made from the name of a file.
        specimens: name of the specimen of a run, by the name of its file; "" for all others. Those
            of files without are taken from the file names.
        stretched_to: largest stretch [-] that the specimen had seen before a run, by the name of
            the file of the run; "" for all others.

    Raises DocumentError if something is still open, or files do not belong together.
    """
    experiment = proposal.experiment
    if proposal.unsure or experiment is None:
        missing = "; ".join(f"{what} ({how})" for what, how in proposal.unsure.items())
        raise DocumentError(f"expected an answer to these questions: {missing}")
    needed = NEEDED[experiment]
    names = [one.table.path.name for one in proposal.sources]
    shifted = of_files("--shift", shifts or {}, names)
    sources = [_shifted(source, shifted) for source in proposal.sources]
    sources, converted = in_one_unit(sources)
    many = experiment in (VALVE_PULSE, BASE_TORQUE)
    runs = _with_own_names(
        [
            run_of_many(members, experiment) if many else joined(members, experiment, needed)
            for members in paired(sources, needed)
        ]
    )
    runs, copied = without_copies(runs)
    if experiment == RUBBER_TEST:  # which is not driven before its first stress
        runs = tuple(replace(run, lead={}) for run in runs)
    runs = runs if many else with_temperatures(runs, sources, needed)
    modes = {run.name: proposal.modes[run.files[0].name] for run in runs if proposal.modes}
    name, entry = finger_of_hand(hand, runs) if hand else (SPECIMEN, {})
    name = name if hand else STRIPS.get(experiment, SPECIMEN)
    names = [run.name for run in runs]
    found = assigned(names, telling_mode=experiment == RUBBER_TEST)
    said = _by_run("--specimen", specimens or {}, runs)
    if len(said) == len(runs) or len(found.names) < 2:
        protocols = protocols_of(names)
        found = replace(found, specimens=dict.fromkeys(names, name), protocols=protocols)
    found = replace(found, specimens={**found.specimens, **said})
    by_name = found
    if not many:
        driving = INPUT[experiment]
        drives = {run.name: drive_of(run.columns, run.lead, driving) for run in runs}
        protocols = protocols_by_drive(found, drives, modes)
        found = replace(found, protocols=protocols)
    pulled = _pulled(runs, stretched_to or {}, experiment)
    stretched = INPUT.get(experiment) == "stretch"
    new = new_specimens(names) if stretched and not said and not pulled else []
    columns = columns_of(sources, runs)
    noise = _noise(sources, needed, experiment)
    strips = stretched and not hand
    modulus = strip_modulus(runs, columns, modes) if strips else None
    if modulus is not None:
        entry = {"shear_modulus": modulus}
    of_strips = own_moduli(runs, found.specimens, columns, modes) if strips else {}
    measured = temperatures_of(runs, sources)
    temperatures = measured or temperatures_in_names(names)
    document = {
        "format": SET_FORMAT,
        "experiment": experiment,
        "title": title or f"imported from {runs[0].files[0].name}"[:80],
        "specimens": {one: of_strips.get(one, dict(entry)) for one in found.names},
        "columns": columns,
        **({"noise": noise} if noise else {}),
        **(
            {"calibration": {"modulus": FREE_VALUE}}
            if (modulus or of_strips) and experiment != RUBBER_TEST
            else {}
        ),
        "runs": {
            run.name: _run_entry(run.name, found, pulled)
            | ({"virgin": True} if run.name in new else {})
            | ({"temperature": temperatures[run.name]} if run.name in temperatures else {})
            | ({"mode": modes[run.name]} if modes else {})
            for run in runs
        },
    }
    remarks = [*(remark for run in runs for remark in run.remarks), *remarks_on_clocks(runs)]
    remarks += [
        *copied,
        *converted,
        *remarks_on_air(columns, runs),
        *remarks_on_files(sources),
        *remarks_on_specimens(found, entry, experiment, bool(said)),
        *remarks_on_repeats(found, by_name, modes),
        *remarks_on_new(new),
    ]
    if names != sorted(names) and len({path for run in runs for path in run.files}) > 1:
        remarks.append(
            f"taken as recorded in this order: {listed(names)}; the largest stretch so far, ageing "
            "and drifts depend on it (in experiment.yaml: the order of runs)"
        )
    if temperatures:
        low, high = (end(temperatures.values()) - KELVIN for end in (min, max))
        remarks.append(
            "temperature: "
            + _source_of_temperatures(runs, bool(measured))
            + f", {low:.1f} to {high:.1f} degC (in "
            "experiment.yaml in K); runs more than 1 K apart are no repeats"
        )
    remarks += [
        f"noise: {level:g} {columns[name]['unit']} of {name}, the median of the stated standard "
        "deviations (in experiment.yaml: noise)"
        for name, level in noise.items()
    ]
    if modulus is not None or of_strips:
        remarks.append(
            f"the shear modulus is not stated: {moduli_words(modulus, of_strips)}, from the first "
            "part of the pull, is a start, and the modulus is fitted freely (in experiment.yaml: "
            "shear_modulus"
            + (
                ")"
                if experiment == RUBBER_TEST
                else ", and calibration, which goes if it is known)"
            )
        )
    sized = bool(entry) or experiment == VALVE_PULSE
    return ImportedSet(document, runs, tuple(dict.fromkeys(remarks)), sized)


def _source_of_temperatures(runs: Sequence[ImportedRun], measured: bool) -> str:
    """Where the temperatures of runs are from, in words."""
    if any(TEMPERATURE in run.columns for run in runs):
        return "its column, which changes within runs; means"
    return "the mean of its column in each run" if measured else "as in the names of the runs"


def _noise(sources: Sequence[Source], needed: Sequence[str], experiment: str) -> dict[str, float]:
    """The noise of the output of an experiment with one, as the files state it."""
    outputs = [name for name in needed if name != INPUT.get(experiment)]
    level = stated_noise(sources, outputs[0]) if len(outputs) == 1 else None
    return {outputs[0]: level} if level else {}


def _run_entry(name: str, found: Assigned, pulled: Mapping[str, float]) -> dict[str, object]:
    entry: dict[str, object] = {
        "specimen": found.specimens[name],
        "protocol": found.protocols[name],
        "file": f"{name}.csv",
    }
    return entry | ({"stretched_to": pulled[name]} if name in pulled else {})


def _pulled(
    runs: Sequence[ImportedRun], stretched_to: Mapping[str, float], experiment: str
) -> dict[str, float]:
    """Largest stretch before each run, by its name. Raises DocumentError for a file of no run."""
    if stretched_to and INPUT.get(experiment) != "stretch":
        raise DocumentError(
            f"--stretched-to: expected an experiment whose input is the stretch, got {experiment}; "
            "if the specimen was loaded before, import that loading as a run of its own"
        )
    return _by_run("--stretched-to", stretched_to, runs)


def _by_run(option: str, said: Mapping[str, T], runs: Sequence[ImportedRun]) -> dict[str, T]:
    """What an option says of each run, by its name, from what it says of files ("": of all others).
    Raises DocumentError for a file of no run.
    """
    of_run = [(run.name, path.name) for run in runs for path in run.files]
    known = of_files(option, said, [file for _, file in of_run])
    every = {run.name: known[""] for run in runs} if "" in known else {}
    return every | {run: known[file] for run, file in of_run if file in known}


def _shifted(source: Source, shifts: Mapping[str, float]) -> Source:
    """The file with its clock shifted as the user said."""
    shift = shifts.get(source.table.path.name)
    times = {one.column: one for one in source.meanings if one.quantity == "time"}
    if not shift:
        return source
    if not times:
        raise DocumentError(
            f"--shift {source.table.path.name}: expected a file with a column of time, got none"
        )
    columns = []
    for column in source.table.columns:
        meant = times.get(column.name)
        if meant is None:
            columns.append(column)
            continue
        unit = column_unit("time", meant.unit or "s").scale * meant.scale
        columns.append(replace(column, values=column.values + shift / unit))
    return replace(source, table=replace(source.table, columns=tuple(columns)))


def _with_own_names(runs: Iterable[ImportedRun]) -> tuple[ImportedRun, ...]:
    """The runs, each with a name of its own."""
    seen: dict[str, int] = {}
    found = []
    for run in runs:
        seen[run.name] = number = seen.get(run.name, 0) + 1
        found.append(run if number == 1 else replace(run, name=f"{run.name}_{number}"))
    return tuple(found)


def csv_of(run: ImportedRun) -> str:
    """A run as the text of a CSV file: first its lead, with empty cells for outputs, then its
    samples.
    """
    names = list(run.columns)
    lines = [",".join(names)]
    for index in range(len(run.lead.get("time", ()))):
        lines.append(
            ",".join(_text(run.lead[name][index]) if name in run.lead else "" for name in names)
        )
    rows = np.stack([run.columns[name] for name in names], axis=1)
    lines += [",".join(map(_text, row)) for row in rows]
    return "\n".join(lines) + "\n"


def _text(value: float) -> str:
    return f"{value:.{DIGITS}g}"
