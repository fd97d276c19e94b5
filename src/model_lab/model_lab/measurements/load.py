"""Loading of measurement sets: `experiment.yaml` with one CSV file or bag per run."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from model_lab.aliases import Array, Tell, tell_nobody
from model_lab.measurements.bags.columns import Source, read_bag_columns
from model_lab.measurements.bags.fields import MessageField
from model_lab.measurements.csv_file import TableError, read_columns
from model_lab.measurements.hands import (
    GRASP,
    HAND_MOTION,
    HAND_POSE,
    OBJECT_PLACE,
    OF_HANDS,
    PRESS,
    WITH_WRENCH,
    WRENCH_COLUMNS,
    WRIST_POSE,
    default_markers,
    marker_columns,
    mass_columns,
    pressure_columns,
    read_grasped,
    read_markers,
    read_plate,
    the_hand,
)
from model_lab.measurements.held_input import DRIVING_COLUMN
from model_lab.measurements.lead import parted
from model_lab.measurements.limited_input import within_limit
from model_lab.measurements.meanings import (
    AMBIENT,
    ATMOSPHERE,
    MEANINGS,
    as_expected,
    meanings_of,
)
from model_lab.measurements.measurement_set import (
    DEFLATE,
    INFLATE,
    INPUTS,
    MODES,
    OUTPUTS,
    ROOM_TEMPERATURE,
    SET_FORMAT,
    STRETCHED,
    TEMPERATURE,
    MeasurementSet,
    Run,
    Specimen,
)
from model_lab.measurements.rows import STRETCHES, TEMPERATURES, check_rows
from model_lab.measurements.specimens import (
    bent_length,
    document_of,
    known_fields,
    read_specimens,
)
from model_lab.measurements.units import Unit, column_unit, unit_of
from softhand_common.documents.quoted import listed, shortened
from softhand_common.documents.yaml_document import (
    DocumentError,
    Node,
    read_document,
)
from softhand_model.model_file import FREE_VALUE

Units = dict[str, Unit]
Told = Callable[[float], None]  # with the part of a bag that has been read

TOP_KEYS = ("format", "experiment", "specimens", "runs")
HAND_KEYS = ("markers", "plate", "object", "scene")
MORE_KEYS = ("title", "description", "columns", "noise", "calibration")
RUN_KEYS = ("temperature", "protocol", "file", "bag", "topics", "virgin", "initial")
STRETCHED_TO = "stretched_to"  # key of a run
LIMIT = "limit"  # key of a column: the largest reading of its sensor
COLUMN_WORDS = {"direction": {"inflate": INFLATE, "deflate": DEFLATE}}
LONGEST_PATH, LONGEST_NAME = 500, 255  # characters


def load_measurements(path: str | Path, tell: Tell = tell_nobody) -> MeasurementSet:
    """The measurement set of a folder (or of its experiment.yaml), all in SI units.

    Runs keep the order of the document. The columns of a run are those that the experiment needs,
    and all others that `columns` or `topics` name; `direction` is 1 (inflate) or -1 (deflate). A
    run without `protocol` counts as a protocol of its own, one without `temperature` was at 293.15
    K.

    Args:
        path: the folder, or experiment.yaml in it.
        tell: called with each file that is read, for a progress bar.

    Raises:
        DocumentError (a ValueError): the set is not valid; the message names file, row or key, what
            was expected, what came, and how to correct it.
    """
    document = document_of(Path(path))
    if not document.exists():
        raise DocumentError(
            f"{document}: expected a readable file, got No such file or directory; `model-lab "
            "import FILE... -o SET` begins a set from CSV files, tables or bags"
        )
    fields = known_fields(read_document(document, SET_FORMAT), TOP_KEYS, [*MORE_KEYS, *HAND_KEYS])
    experiment = fields["experiment"].choice(OUTPUTS)
    plate = read_plate(fields["plate"]) if "plate" in fields else None
    grasped = read_grasped(fields["object"], fields.get("scene")) if "object" in fields else None
    title = fields["title"].text() if "title" in fields else ""
    of_hands = experiment in OF_HANDS
    specimens = read_specimens(fields["specimens"], of_hands)
    markers, columns = {}, (INPUTS[experiment], OUTPUTS[experiment])
    if experiment in WITH_WRENCH:
        hand = the_hand({name: one.hand for name, one in specimens.items()}, str(document))
        columns = (*INPUTS[PRESS], *pressure_columns(hand)), OUTPUTS[PRESS]
    if experiment == GRASP:
        measured = (*WRENCH_COLUMNS, *pressure_columns(hand), *OBJECT_PLACE)
        columns = (*INPUTS[GRASP], *mass_columns(hand)), measured
    if of_hands and experiment not in WITH_WRENCH:
        hand = the_hand({name: one.hand for name, one in specimens.items()}, str(document))
        stated_markers = "markers" in fields
        markers = read_markers(fields["markers"], hand) if stated_markers else default_markers(hand)
        columns = (*INPUTS[experiment], *pressure_columns(hand)), marker_columns(markers)
    stated = _stated(fields["columns"]) if "columns" in fields else {}
    units = {name: column.unit for name, column in stated.items()}
    reader = _RunReader(document.parent, experiment, specimens, stated, columns)
    runs = reader.runs(fields["runs"], tell)
    noise = _noise(fields["noise"], {**reader.bag_units, **units}) if "noise" in fields else {}
    free = "calibration" in fields and _free_modulus(fields["calibration"])
    data = MeasurementSet(
        experiment,
        title,
        specimens,
        runs,
        noise,
        document.parent,
        free,
        units={**reader.texts, **{name: column.text for name, column in stated.items()}},
        bags=frozenset(reader.bags),
        doubts=tuple(reader.doubts),
        markers=markers,
        plate=plate,
        grasped=grasped,
    )
    limits = [stated[name].limit for name in columns[0] if name in stated] + reader.limits
    return within_limit(data, min(limits, default=float(np.inf)))


def _free_modulus(node: Node) -> bool:
    """Whether the document has `calibration: {modulus: free}`."""
    entries = known_fields(node, (), ["modulus"])
    return "modulus" in entries and bool(entries["modulus"].choice([FREE_VALUE]))


@dataclass(frozen=True)
class _Column:
    """What a set states of a column: its unit, also as text, the name of the column in the files,
    what it is in place of what is expected (a word of `MEANINGS`; empty: just that), the pressure
    of the air [Pa], and the largest reading of its sensor in SI units.
    """

    unit: Unit
    text: str
    source: str
    meaning: str
    ambient: float
    limit: float = np.inf


def _stated(node: Node) -> dict[str, _Column]:
    """What is stated under `columns`."""
    found = {}
    for name, entry in node.mapping().items():
        fields = known_fields(entry, ["unit"], ["is", "from", AMBIENT, LIMIT])
        source = fields["from"].text() if "from" in fields else name
        unit = _unit(fields["unit"], name)
        meaning, ambient = _meaning(fields, name), _ambient(fields, unit)
        text, limit = fields["unit"].value, _limit(fields, name, unit)
        found[name] = _Column(unit, text, source, meaning, ambient, limit)
    return found


def _limit(fields: Mapping[str, Node], name: str, unit: Unit) -> float:
    """Largest reading of a column's sensor in SI units, stated in the unit of the column, but as
    what is expected of it, such as a gauge pressure.
    """
    if LIMIT not in fields:
        return float(np.inf)
    if name not in DRIVING_COLUMN.values():
        known = listed(sorted(set(DRIVING_COLUMN.values())))
        raise fields[LIMIT].error(f"the key `limit` only for {known}", f"this key for {name}")
    return float(unit.to_si(np.array(fields[LIMIT].number())))


def _ambient(fields: Mapping[str, Node], unit: Unit) -> float:
    """Pressure of the air [Pa], stated in the unit of the column."""
    if AMBIENT not in fields:
        return ATMOSPHERE
    return fields[AMBIENT].number(above=0.0, high=unit.largest) * unit.scale


def _meaning(fields: Mapping[str, Node], column: str) -> str:
    """What a column is in place of what is expected; empty if nothing is said."""
    if "is" not in fields:
        return ""
    if not meanings_of(column):
        known = f"{listed(MEANINGS)}, channels and markers of a hand"
        raise fields["is"].error(f"the key `is` only for {known}", f"this key for {column}")
    return fields["is"].choice(meanings_of(column))


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
    """Reads the runs of one document; `bag_units` holds the units of columns met in bags, `texts`
    the same as they were written, `bags` the names of runs read from them, and `doubts` what is
    kept although it cannot be what its column is named; `limits` holds the largest readings of
    sensors that bags state.
    """

    def __init__(
        self,
        folder: Path,
        experiment: str,
        specimens: Mapping[str, Specimen],
        stated: Mapping[str, _Column],
        columns: tuple[tuple[str, ...], tuple[str, ...]],
    ) -> None:
        self._folder, self._experiment = folder, experiment
        self._specimens, self._stated = specimens, stated
        self._inputs, self._outputs = columns
        self._units = {name: column.unit for name, column in stated.items()}
        self._files: dict[Path, str] = {}
        self.bag_units: Units = {}
        self.texts: dict[str, str] = {}
        self.bags: set[str] = set()
        self.doubts: list[str] = []
        self.limits: list[float] = []

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
        more = [*RUN_KEYS, "description", *(["mode"] if of_rubber else [])]
        more += [STRETCHED_TO] if self._experiment in STRETCHED else []
        more += ["wrist_rpy"] if self._experiment in OF_HANDS else []
        fields = known_fields(node, ["specimen"], more)
        mode = _mode(node, fields) if of_rubber else ""
        specimen = fields["specimen"].choice(self._specimens)
        protocol = fields["protocol"].text() if "protocol" in fields else name
        virgin = "virgin" in fields and fields["virgin"].choice([True, False])
        initial = fields["initial"].choice(["rest", "steady"]) if "initial" in fields else "rest"
        columns, lead = self._columns(node, fields, told, self._specimens[specimen])
        temperature = _temperature(fields, columns)
        if "bag" in fields:
            self.bags.add(name)
        steady = initial == "steady"
        pulled = _stretched_to(fields, virgin)
        held: tuple[float, ...] = (0.0, 0.0, 0.0)
        if "wrist_rpy" in fields:
            held = fields["wrist_rpy"].vector()
        elif self._experiment in (HAND_POSE, HAND_MOTION) and WRIST_POSE[-1] not in columns:
            raise node.error(
                "the key wrist_rpy, roll, pitch and yaw [rad] of the wrist in the world (weight "
                "bends the fingers)",
                "none; fingers up is wrist_rpy: [0.0, 0.0, 0.0]",
            )
        return Run(
            name, specimen, protocol, temperature, columns, virgin, steady, mode, lead, pulled, held
        )

    def _columns(
        self, node: Node, fields: Mapping[str, Node], told: Told, specimen: Specimen
    ) -> tuple[dict[str, Array], dict[str, Array]]:
        """Columns (samples,) of a run in SI units by name, and its lead."""
        if ("file" in fields) == ("bag" in fields):
            got = "both" if "file" in fields else "neither"
            raise node.error(
                "one of the keys `file` (a CSV file) and `bag` (a rosbag2 folder or a ROS 1 file)",
                got,
            )
        if "file" in fields:
            path = self._path(fields["file"])
            columns = self._csv(fields["file"], path, specimen)
            self.doubts += check_rows(path, columns)
            return parted(columns, self._outputs_that_begin())
        if "topics" not in fields:
            raise node.error(
                "the key topics beside bag", "none; add topics: {column: {topic: ..., field: ...}}"
            )
        path = self._path(fields["bag"])
        try:
            columns, lead = self._bag(path, fields["topics"], told, specimen)
        except DocumentError as reason:
            if self._is_own(path) or str(reason).startswith(node.file):
                raise
            raise DocumentError(f"{fields['bag'].place}: {reason}") from reason
        self.doubts += check_rows(path, columns)
        check_rows(path, lead)
        return columns, lead

    def _path(self, node: Node) -> Path:
        """The path that the document names, which has no more than a file system takes."""
        name = node.text()
        longest = max(map(len, name.split("/")))
        if "\0" in name or len(name) > LONGEST_PATH or longest > LONGEST_NAME:
            raise node.error(
                f"a path of at most {LONGEST_PATH} characters, {LONGEST_NAME} between slashes, "
                "without null characters"
            )
        return self._folder / name

    def _is_own(self, path: Path) -> bool:
        """Whether a file or folder lies below that of the document, links followed."""
        inside = Path(os.path.realpath(path)).is_relative_to(os.path.realpath(self._folder))
        return inside and path.exists()

    # ---------------------------------------------------------------- CSV
    def _csv(self, node: Node, path: Path, specimen: Specimen) -> dict[str, Array]:
        names = self._csv_columns(node)
        other = self._files.setdefault(Path(os.path.realpath(path)), node.key)
        if other != node.key:
            raise node.error(
                "a file that no other run has",
                f"{shortened(node.value)} as in {shortened(other)}; the same run given twice "
                "would count as a perfect repeat",
            )
        sources = {
            name: self._stated[name].source if name in self._stated else name for name in names
        }
        try:
            begin = [sources[name] for name in self._outputs_that_begin()]
            wanted = list(dict.fromkeys(sources.values()))
            read = read_columns(path, wanted, COLUMN_WORDS, begin)
        except TableError as reason:
            if self._is_own(path):
                raise
            got = "other content, which is not shown as the file is outside the set's folder"
            raise DocumentError(f"{node.place}: {reason.without_content}, got {got}") from None
        except DocumentError as reason:
            raise DocumentError(f"{node.place}: {reason}") from reason
        columns = {name: read[source] for name, source in sources.items()}
        meanings = {name: column.meaning for name, column in self._stated.items() if column.meaning}
        air = [self._stated[name].ambient for name in meanings] or [ATMOSPHERE]
        length = bent_length(node, specimen, meanings.values())
        return as_expected(_in_si(columns, self._units), meanings, air[0], length)

    def _csv_columns(self, node: Node) -> list[str]:
        """Columns to read from a CSV file; those that the experiment needs must have a unit."""
        for name in self._needed():
            if name not in self._units and name not in COLUMN_WORDS:
                tracked = self._experiment in (HAND_POSE, HAND_MOTION) and name in self._outputs
                instead = ", or name under `markers` only those that were tracked"
                raise DocumentError(
                    f"{node.file}: columns: expected the column {name}, which {self._experiment} "
                    f"needs, got {listed(self._units)}; "
                    f"add `{name}: {{unit: {unit_of(name) or repr('')}}}` with your own unit"
                    f"{instead if tracked else ''}"
                )
        words = [
            name for name in self._needed() if name in COLUMN_WORDS and name not in self._units
        ]
        return [*self._units, *words]

    def _needed(self) -> tuple[str, ...]:
        return (*self._inputs, *self._outputs)

    def _outputs_that_begin(self) -> tuple[str, ...]:
        """Outputs that may begin after the inputs."""
        return self._outputs if self._experiment in DRIVING_COLUMN else ()

    # ---------------------------------------------------------------- bags
    def _bag(
        self, path: Path, node: Node, told: Told, specimen: Specimen
    ) -> tuple[dict[str, Array], dict[str, Array]]:
        topics = node.mapping()
        for name in self._needed():
            if name not in topics and name != "time":
                raise node.error(
                    f"the column {name}, which {self._experiment} needs", listed(topics)
                )
        if "time" in topics:
            raise node.error(
                "no time", "time; bags use the times of their messages, so remove this column"
            )
        entries = {
            name: known_fields(entry, ["topic", "field"], ["unit", "is", "from", AMBIENT, LIMIT])
            for name, entry in topics.items()
        }
        units = {
            name: _unit(entry["unit"], name) if "unit" in entry else Unit()
            for name, entry in entries.items()
        }
        origins = {
            name: str(entry["from"].choice(entries)) if "from" in entry else name
            for name, entry in entries.items()
        }
        sources = {
            name: _source(topics[origin], entries[origin], name) for name, origin in origins.items()
        }
        columns, lead = read_bag_columns(path, sources, self._outputs[0], told)
        if not (self._outputs_that_begin() and lead.keys() >= set(self._inputs)):
            lead = {}
        self.bag_units.update(units)
        self.texts.update(
            {name: entry["unit"].text() for name, entry in entries.items() if "unit" in entry}
        )
        meanings = {n: word for n, entry in entries.items() if (word := _meaning(entry, n))}
        air = [_ambient(entries[name], units[name]) for name in meanings] or [ATMOSPHERE]
        self.limits += [_limit(entry, name, units[name]) for name, entry in entries.items()]
        length = bent_length(node, specimen, meanings.values())
        in_si = (_in_si(read, units) for read in (columns, lead))
        of_run, before = (as_expected(read, meanings, air[0], length) for read in in_si)
        return of_run, before


def _in_si(columns: Mapping[str, Array], units: Units) -> dict[str, Array]:
    return {
        name: units[name].to_si(values) if name in units else values
        for name, values in columns.items()
    }


def _tell_part(tell: Tell, name: str, number: int, total: int, part: float) -> None:
    tell(f"{name} ({part:.0%})", number, total)


def _source(node: Node, entry: Mapping[str, Node], column: str) -> Source:
    try:
        field = MessageField.parse(entry["field"].text())
    except ValueError as reason:
        raise DocumentError(f"{entry['field'].place}: {reason}") from reason
    topic = entry["topic"].text()
    return Source(f"/{topic.lstrip('/')}", field, node.place, unit_of(column) == "rad")


def _stretched_to(fields: Mapping[str, Node], virgin: bool) -> float:
    """Largest stretch [-] of a specimen before a run."""
    if STRETCHED_TO not in fields:
        return 1.0
    node = fields[STRETCHED_TO]
    value = node.number()
    low, high = 1.0, STRETCHES[1]
    if not low <= value <= high:
        mend = "; it is a stretch, 1 at rest: strain + 1"
        raise node.error(f"the largest stretch before the run, {low:g} to {high:g}{mend}")
    if virgin and value > 1.0:
        raise node.error(
            "no `stretched_to` above 1 in a run that is `virgin` (never stretched before)"
        )
    return value


def _mode(node: Node, fields: Mapping[str, Node]) -> str:
    """In which mode a run of rubber was stretched."""
    if "mode" not in fields:
        raise node.error(f"the key mode ({listed(MODES)})", listed(fields))
    return str(fields["mode"].choice(MODES))


def _temperature(fields: Mapping[str, Node], columns: Mapping[str, Array]) -> float:
    """Temperature [K] of a run: as stated, else the mean of its column, else that of a room."""
    if "temperature" not in fields:
        return float(np.mean(columns.get(TEMPERATURE, ROOM_TEMPERATURE)))
    node = fields["temperature"]
    value = node.number()
    if not TEMPERATURES[0] <= value <= TEMPERATURES[1]:
        low, high = TEMPERATURES
        raise node.error(
            f"a temperature in K from {low:g} to {high:g}", f"{value:g}; 20 degC are 293.15"
        )
    return value
