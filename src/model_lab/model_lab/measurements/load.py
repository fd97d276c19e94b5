"""Loading of measurement sets: `experiment.yaml` with one CSV file or rosbag2 folder per run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

import numpy as np

from model_lab.aliases import Array, Mask, Tell, tell_nobody
from model_lab.measurements.bag import MessageField, Source, read_bag_columns
from model_lab.measurements.csv_file import read_columns
from model_lab.measurements.measurement_set import (
    DEFLATE,
    FORMAT,
    INFLATE,
    INPUTS,
    MODES,
    OUTPUTS,
    ROOM_TEMPERATURE,
    MeasurementSet,
    Run,
    Specimen,
)
from model_lab.measurements.specimens import document_of, read_specimens
from model_lab.measurements.units import COLUMN_UNITS, Unit, column_unit, largest
from softhand_model.documents.quoted import listed, shortened
from softhand_model.documents.yaml_document import (
    DocumentError,
    Node,
    open_fields,
    read_document,
)
from softhand_model.model_file import FREE

Units = dict[str, Unit]
Told = Callable[[float], None]  # with the part of a bag that has been read

TOP_KEYS = ("format", "experiment", "specimens", "runs")
RUN_KEYS = ("temperature", "protocol", "file", "bag", "topics", "virgin", "initial")
TEMPERATURES = (200.0, 500.0)  # [K] between which a run is believed
STRETCHES = (0.1, 50.0)  # what could be one: strains start at 0, per cent end above
WORDS = {"direction": {"inflate": INFLATE, "deflate": DEFLATE}}
# by column: which values (in SI units) are wrong, what was expected, the mend
_RANGES: dict[str, tuple[Callable[[Array], Mask], str, str]] = {
    "stretch": (
        lambda values: (values < STRETCHES[0]) | (values > STRETCHES[1]),
        f"a number from {STRETCHES[0]:g} to {STRETCHES[1]:g}",
        "stretch is 1 at rest, that is strain + 1",
    ),
    "p_in": (lambda values: values <= 0.0, "a number above 0", "pulses need absolute pressures"),
    "p_out": (lambda values: values <= 0.0, "a number above 0", "pulses need absolute pressures"),
    "duration": (lambda values: values <= 0.0, "a number above 0", "take the row out"),
    "direction": (
        lambda values: np.abs(values) != 1.0,
        "1 (inflate) or -1 (deflate)",
        "take the row out",
    ),
}


def load_measurements(path: str | Path, tell: Tell = tell_nobody) -> MeasurementSet:
    """The measurement set of a folder (or of its experiment.yaml), all in SI units.

    Runs keep the order of the document. The columns of a run are those that the experiment needs
    and whatever else `columns` or `topics` name; `direction` is 1 (inflate) or -1 (deflate). A run
    without `protocol` is its own, one without `temperature` was at 293.15 K.

    Args:
        path: the folder.
        tell: is told what is read.

    Raises:
        DocumentError (a ValueError): with file, row or key, expected, got, and the mend.
    """
    document = document_of(Path(path))
    fields = open_fields(
        read_document(document, FORMAT), TOP_KEYS, ("title", "columns", "noise", "calibration")
    )
    experiment = fields["experiment"].choice(OUTPUTS)
    title = fields["title"].text() if "title" in fields else ""
    specimens = read_specimens(fields["specimens"])
    units = _units(fields["columns"]) if "columns" in fields else {}
    reader = _RunReader(document.parent, experiment, specimens, units)
    runs = reader.runs(fields["runs"], tell)
    noise = _noise(fields["noise"], {**reader.bag_units, **units}) if "noise" in fields else {}
    free = "calibration" in fields and _free_modulus(fields["calibration"])
    return MeasurementSet(experiment, title, specimens, runs, noise, document.parent, free)


def _free_modulus(node: Node) -> bool:
    """Whether `calibration: {modulus: free}` stands in the document."""
    entries = open_fields(node, optional=["modulus"])
    return "modulus" in entries and bool(entries["modulus"].choice([FREE]))


def _units(node: Node) -> Units:
    return {
        name: _unit(open_fields(entry, ["unit"])["unit"], name)
        for name, entry in node.mapping().items()
    }


def _unit(node: Node, column: str) -> Unit:
    if not isinstance(node.value, str):
        raise node.error("a unit as text ('' for none)")
    try:
        return column_unit(column, node.value)
    except ValueError as reason:
        raise DocumentError(f"{node.place}: {reason}") from reason


def _noise(node: Node, units: Mapping[str, Unit]) -> dict[str, float]:
    """One sigma by column in SI units, given in the unit of the column."""
    entries = node.mapping()
    for name, entry in entries.items():
        if name not in units:
            raise entry.error(f"a column ({listed(units)})", shortened(name))
    return {
        name: entry.number(above=0.0, high=units[name].largest) * units[name].scale
        for name, entry in entries.items()
    }


class _RunReader:
    """Reads the runs of one document; `bag_units` holds the units of columns met in bags."""

    def __init__(
        self, folder: Path, experiment: str, specimens: Mapping[str, Specimen], units: Units
    ) -> None:
        self._folder, self._experiment = folder, experiment
        self._specimens, self._units = specimens, units
        self._files: dict[Path, str] = {}
        self.bag_units: Units = {}

    def runs(self, node: Node, tell: Tell) -> tuple[Run, ...]:
        """The runs of the document, in its order."""
        entries = node.mapping()
        if not entries:
            raise node.error("at least one run")
        runs = []
        for number, (name, entry) in enumerate(entries.items(), 1):
            tell(name, number, len(entries))
            told = partial(_tell_part, tell, name, number, len(entries))
            runs.append(self._run(name, entry, told))
        return tuple(runs)

    def _run(self, name: str, node: Node, told: Told) -> Run:
        of_rubber = self._experiment == "rubber"
        fields = open_fields(node, ["specimen"], [*RUN_KEYS, "mode"] if of_rubber else RUN_KEYS)
        mode = _mode(node, fields) if of_rubber else ""
        specimen = fields["specimen"].choice(self._specimens)
        temperature = _temperature(fields)
        protocol = fields["protocol"].text() if "protocol" in fields else name
        virgin = "virgin" in fields and fields["virgin"].choice([True, False])
        initial = fields["initial"].choice(["rest", "steady"]) if "initial" in fields else "rest"
        columns = self._columns(node, fields, told)
        steady = initial == "steady"
        return Run(name, specimen, protocol, temperature, columns, virgin, steady, mode)

    def _columns(self, node: Node, fields: Mapping[str, Node], told: Told) -> dict[str, Array]:
        if ("file" in fields) == ("bag" in fields):
            got = "both" if "file" in fields else "neither"
            raise node.error("either file (CSV) or bag (rosbag2)", got)
        if "file" in fields:
            path = self._folder / fields["file"].text()
            columns = self._csv(fields["file"], path)
            check_rows(path, columns)
            return columns
        if "topics" not in fields:
            raise node.error(
                "the key topics beside bag", "none; add topics: {column: {topic: ..., field: ...}}"
            )
        path = self._folder / fields["bag"].text()
        columns = self._bag(path, fields["topics"], told)
        check_rows(path, columns)
        return columns

    # ---------------------------------------------------------------- CSV
    def _csv(self, node: Node, path: Path) -> dict[str, Array]:
        names = self._csv_columns(node)
        other = self._files.setdefault(path.resolve(), node.key)
        if other != node.key:
            raise node.error(
                "a file of its own",
                f"{shortened(node.value)} as in {shortened(other)}; a run that is given twice "
                "looks like a perfect repeat",
            )
        columns = read_columns(path, names, WORDS)
        return {
            name: self._units[name].to_si(values) if name in self._units else values
            for name, values in columns.items()
        }

    def _csv_columns(self, node: Node) -> list[str]:
        """Columns to read from a CSV file; those that the experiment needs must have a unit."""
        for name in self._needed():
            if name not in self._units and name not in WORDS:
                raise DocumentError(
                    f"{node.file}: columns: expected the column {name}, which {self._experiment} "
                    f"needs, got {listed(self._units)}; "
                    f"add {name}: {{unit: {COLUMN_UNITS[name] or repr('')}}}, or the unit it has"
                )
        words = [name for name in self._needed() if name in WORDS and name not in self._units]
        return [*self._units, *words]

    def _needed(self) -> tuple[str, ...]:
        return (*INPUTS[self._experiment], *OUTPUTS[self._experiment])

    # ---------------------------------------------------------------- bags
    def _bag(self, path: Path, node: Node, told: Told) -> dict[str, Array]:
        topics = node.mapping()
        for name in self._needed():
            if name not in topics and name != "time":
                raise node.error(
                    f"the column {name}, which {self._experiment} needs", listed(topics)
                )
        if "time" in topics:
            raise node.error("no time", "time; it is that of the messages, take it out")
        entries = {
            name: open_fields(entry, ["topic", "field"], ["unit"]) for name, entry in topics.items()
        }
        units = {
            name: _unit(entry["unit"], name) if "unit" in entry else Unit()
            for name, entry in entries.items()
        }
        sources = {name: _source(topics[name], entry) for name, entry in entries.items()}
        columns = read_bag_columns(path, sources, OUTPUTS[self._experiment][0], told)
        self.bag_units.update(units)
        return {
            name: units[name].to_si(values) if name in units else values
            for name, values in columns.items()
        }


def _tell_part(tell: Tell, name: str, number: int, total: int, part: float) -> None:
    tell(f"{name} ({part:.0%})", number, total)


def _source(node: Node, entry: Mapping[str, Node]) -> Source:
    try:
        field = MessageField.parse(entry["field"].text())
    except ValueError as reason:
        raise DocumentError(f"{entry['field'].place}: {reason}") from reason
    topic = entry["topic"].text()
    return Source(f"/{topic.lstrip('/')}", field, node.place)


def _mode(node: Node, fields: Mapping[str, Node]) -> str:
    """In which mode a run of rubber was stretched."""
    if "mode" not in fields:
        raise node.error(f"the key mode ({listed(MODES)})", listed(fields))
    return str(fields["mode"].choice(MODES))


def _temperature(fields: Mapping[str, Node]) -> float:
    if "temperature" not in fields:
        return ROOM_TEMPERATURE
    node = fields["temperature"]
    value = node.number()
    if not TEMPERATURES[0] <= value <= TEMPERATURES[1]:
        low, high = TEMPERATURES
        raise node.error(
            f"a temperature in K from {low:g} to {high:g}", f"{value:g}; 20 degC are 293.15"
        )
    return value


def row_name(index: int) -> str:
    """How a row is called in errors, given its index from 0 in a file without blank lines.

    >>> row_name(0)
    'row 1 (line 2 of the file)'
    """
    return f"row {index + 1} (line {index + 2} of the file)"


def check_rows(path: Path, columns: Mapping[str, Array]) -> None:
    """Raise DocumentError where time does not rise or a column leaves its range.

    Args:
        path: the file, for the error.
        columns: (rows,) in SI units by name.
    """
    for name, values in columns.items():
        most = largest(COLUMN_UNITS.get(name))
        _refuse_wrong(path, name, values, np.abs(values) > most, f"{most:g} at most in size")
    if "time" in columns:
        _check_time(path, columns["time"])
    for name in columns.keys() & _RANGES.keys():
        is_wrong, expected, mend = _RANGES[name]
        values = columns[name]
        _refuse_wrong(path, name, values, is_wrong(values), expected, f"; {mend}")


def _refuse_wrong(
    path: Path, name: str, values: Array, wrong: Mask, expected: str, mend: str = ""
) -> None:
    if wrong.any():
        index = int(np.argmax(wrong))
        raise DocumentError(
            f"{path}: {row_name(index)}, column {shortened(name)}: expected {expected} in SI "
            f"units, got {values[index]:g}{mend}"
        )


def _check_time(path: Path, time: Array) -> None:
    wrong = np.diff(time) <= 0.0
    if wrong.any():
        index = int(np.argmax(wrong)) + 1
        same = time[index] == time[index - 1]
        mend = "keep one row for each time" if same else "sort the rows, one run in each file"
        raise DocumentError(
            f"{path}: {row_name(index)}, column time: expected a time after "
            f"{time[index - 1]:.9g} s, got {time[index]:.9g} s{' again' if same else ''}; {mend}"
        )
