"""Bags that this suite recorded of a hand that touched something, as a set `press` or `grasp`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from model_lab.aliases import Array
from model_lab.importing.air_in_channels import hanging_air, lead_of_masses
from model_lab.importing.bag_tables import TopicTable
from model_lab.importing.hand_bags import (
    LOAD_TOPIC,
    POSE_OF_WRIST,
    STATE_OF_AIR,
    columns_of,
    interpolated,
    topics_of_hand,
)
from model_lab.importing.hand_courses import (
    KPA,
    MM,
    names_of_runs,
    remarks_on,
    spans_of,
    without_jumps,
)
from model_lab.importing.hand_poses import FREE_LOAD
from model_lab.importing.importing import ImportedSet
from model_lab.importing.runs import ImportedRun
from model_lab.measurements.bags.messages import messages_of, opened
from model_lab.measurements.hands import (
    GRASP,
    OBJECT_POSE,
    PRESS,
    WRENCH_COLUMNS,
    WRIST_POSE,
    Grasped,
    HandSpecimen,
    Plate,
    mass_columns,
    pressure_columns,
)
from model_lab.measurements.measurement_set import SET_FORMAT
from softhand_common.documents.quoted import listed
from softhand_common.documents.yaml_document import DocumentError

POSE_OF_OBJECT = "scene/object_pose"
RESULT_TOPIC = "grasp/result"  # of the sequencer; its first status is "NODE: STRATEGY"
PLACE_FIELDS = tuple(f"pose.position.{axis}" for axis in "xyz")
TURN_FIELDS = tuple(f"pose.orientation.{axis}" for axis in "xyzw")
WRENCH_FIELDS = tuple(f"wrench.{part}.{axis}" for part in ("force", "torque") for axis in "xyz")
MG, N_MM = 1e6, 1e3  # units of the set over those of ROS
PART_UNITS = {"wrist": "m", "object": "mm", "pressure": "kPa", "mass": "mg"}  # of columns of a part
# by hand
SET_RATES = {PRESS: 25.0, GRASP: 20.0}  # [Hz] of the set; readings between two samples are averaged
FREE_BEFORE = 0.5  # [s] before the first contact, and that part two presses
TOUCHED_FOR = 0.2  # [s] that a press lasts at least
MOVED = 1e-3  # [m] way of an object that was touched
HELD_UP = 2e-3  # [m] below its highest place, at which the wrist still holds up


Touched = Grasped | Plate
"""What a hand touches in a grasp, or in a press."""


def kind_of(touched: Touched) -> str:
    """The experiment in which this is touched."""
    return GRASP if isinstance(touched, Grasped) else PRESS


@dataclass(frozen=True)
class _Recorded:
    """What a bag tells at times (k,) [s]: pose (k, 7) of the wrist, air mass in the channels above
    that of the unbent hand [kg] and gauge pressure [Pa] (k, channels), wrench (k, 6) [N and N m],
    and pose (k, 7) of the object, if it was recorded. Wrench and pressures are means over what is
    nearest to each time.
    """

    bag: Path
    time: Array
    wrist: Array
    mass: Array
    pressure: Array
    wrench: Array
    thing: Array | None

    @property
    def is_touched(self) -> Array:
        """Whether (k,) something bears on the wrist, or the object has been moved."""
        load = np.linalg.norm(self.wrench[:, :3], axis=1) > FREE_LOAD
        if self.thing is None:
            return load
        way = np.linalg.norm(self.thing[:, :3] - self.thing[0, :3], axis=1)
        return np.asarray(load | (way > MOVED))


def set_of_contacts(bags: Sequence[Path], specimen: HandSpecimen, touched: Touched) -> ImportedSet:
    """The set of all grasps of an object, or of all presses on a plate.

    A bag holds one grasp, which is one run, from `FREE_BEFORE` [s] before the hand touches
    something until the wrist comes down from its highest place; its protocol is the strategy that
    the sequencer ran. Or a bag may hold several presses, each from and to a free hand, which are
    protocols by order: the n-th press of each bag repeats those of the others.

    Raises DocumentError for a bag without a topic or field that is needed, with several grasps, or
    in which the hand touches nothing.
    """
    kind = kind_of(touched)
    runs: list[ImportedRun] = []
    entries: dict[str, dict[str, object]] = {}
    parts = [
        (bag, recorded, number, span)
        for bag in bags
        for recorded in [_recorded(bag, specimen, kind)]
        for number, span in enumerate(_SPANS[kind](recorded))
    ]
    names = names_of_runs([(bag,) for bag, *_ in parts])
    for name, (bag, recorded, number, span) in zip(names, parts, strict=True):
        protocol = _strategy(bag) or GRASP if kind == GRASP else f"press_{number + 1}"
        entries[name] = {"specimen": "hand", "protocol": protocol, "file": f"{name}.csv"}
        columns = _columns(recorded, span, specimen, kind)
        runs.append(ImportedRun(name, columns, {}, (bag,)))
    if isinstance(touched, Plate):
        where: dict[str, object] = {"plate": touched.entry()}
    else:
        where = {key: _stated(name) for key, name in asdict(touched).items()}
    document = {
        "format": SET_FORMAT,
        "experiment": kind,
        "title": f"imported from {bags[0].name}"[:80],
        "specimens": {"hand": specimen.entry()},
        **where,
        "columns": {name: {"unit": _unit(name)} for name in runs[0].columns},
        "runs": entries,
    }
    protocols = len({str(entry["protocol"]) for entry in entries.values()})
    remarks = remarks_on(len(runs), protocols, specimen.segments)
    return ImportedSet(document, tuple(runs), tuple(remarks))


def _recorded(bag: Path, specimen: HandSpecimen, kind: str) -> _Recorded:
    hand = specimen.description
    topics = topics_of_hand(bag, hand)
    needed = (STATE_OF_AIR, POSE_OF_WRIST, LOAD_TOPIC, *([POSE_OF_OBJECT] if kind == GRASP else []))
    missing = [name for name in needed if name not in topics]
    if missing:
        raise DocumentError(
            f"{bag}: expected the topics {listed(needed)} of a {kind}, lacks {listed(missing)}"
        )
    begin = max(topics[name].time[0] for name in needed)
    ended = topics[RESULT_TOPIC].time if RESULT_TOPIC in topics else np.zeros(0)
    if kind == GRASP and (ends := int(np.sum(ended > begin))) > 1:  # an earlier one is latched
        raise DocumentError(
            f"{bag}: expected one grasp, got the results of {ends}; record each grasp in a bag of "
            "its own"
        )
    end = min(topics[name].time[-1] for name in needed)
    time = np.arange(begin, end, 1.0 / SET_RATES[kind])
    masses, pressures = (
        columns_of(topics[STATE_OF_AIR], [f"{part}[{name}]" for name in hand.channels], bag)
        for part in ("position", "effort")
    )
    known, wrist = topics[STATE_OF_AIR].time, _pose(topics[POSE_OF_WRIST], time, bag)
    later = known + lead_of_masses(known, masses, pressures)
    return _Recorded(
        bag,
        time,
        wrist,
        interpolated(time, later, masses) + hanging_air(hand, wrist[0, 3:], specimen.segments),
        _mean(time, known, pressures),
        _mean(time, topics[LOAD_TOPIC].time, columns_of(topics[LOAD_TOPIC], WRENCH_FIELDS, bag)),
        _pose(topics[POSE_OF_OBJECT], time, bag) if kind == GRASP else None,
    )


def _pose(topic: TopicTable, time: Array, bag: Path) -> Array:
    turn = without_jumps(columns_of(topic, TURN_FIELDS, bag))
    found = interpolated(time, topic.time, np.hstack([columns_of(topic, PLACE_FIELDS, bag), turn]))
    found[:, 3:] /= np.linalg.norm(found[:, 3:], axis=1)[:, None]
    return found


def _mean(time: Array, known: Array, values: Array) -> Array:
    """Means (k, n) of the values (m, n) at known times (m,) that are nearest to each time (k,) [s];
    where there are none, straight between them.
    """
    nearest = np.searchsorted(0.5 * (time[1:] + time[:-1]), known)
    within = (known >= 1.5 * time[0] - 0.5 * time[1]) & (known <= 1.5 * time[-1] - 0.5 * time[-2])
    counts = np.bincount(nearest[within], minlength=len(time))
    sums = [np.bincount(nearest[within], column[within], len(time)) for column in values.T]
    means = np.stack(sums, axis=1) / np.maximum(counts, 1)[:, None]
    return np.where(counts[:, None] > 0, means, interpolated(time, known, values))


def _of_grasp(recorded: _Recorded) -> list[slice]:
    touched = np.flatnonzero(recorded.is_touched)
    if not len(touched):
        raise DocumentError(
            f"{recorded.bag}: expected contact of the hand with the object, got none"
        )
    time, height = recorded.time, recorded.wrist[:, 2]
    first = int(np.searchsorted(time, time[touched[0]] - FREE_BEFORE))
    lowest = first + int(np.argmin(height[first:]))
    held_up = height >= height[lowest:].max() - HELD_UP
    return [slice(first, next(end for _, end in spans_of(held_up) if end > lowest))]


def _of_presses(recorded: _Recorded) -> list[slice]:
    time = recorded.time
    spans: list[tuple[int, int]] = []
    for first, last in spans_of(recorded.is_touched):
        if spans and time[first] - time[spans[-1][1] - 1] <= FREE_BEFORE:
            spans[-1] = (spans[-1][0], last)
        else:
            spans.append((first, last))
    kept = [(a, b) for a, b in spans if time[b - 1] - time[a] >= TOUCHED_FOR]
    if not kept:
        raise DocumentError(
            f"{recorded.bag}: expected contact of the hand with the plate, got none"
        )
    return [slice(int(np.searchsorted(time, time[a] - FREE_BEFORE)), b) for a, b in kept]


_SPANS: Mapping[str, Callable[[_Recorded], list[slice]]] = {GRASP: _of_grasp, PRESS: _of_presses}


def _columns(
    recorded: _Recorded, span: slice, specimen: HandSpecimen, kind: str
) -> dict[str, Array]:
    hand, time = specimen.description, recorded.time[span]
    names = (*WRIST_POSE, *pressure_columns(hand), *WRENCH_COLUMNS)
    wrench = recorded.wrench[span] * np.repeat([1.0, N_MM], 3)
    values = [recorded.wrist[span], KPA * recorded.pressure[span], wrench]
    if kind == GRASP and recorded.thing is not None:
        names += (*mass_columns(hand), *OBJECT_POSE)
        thing = recorded.thing[span] * np.repeat([MM, 1.0], [3, 4])
        values += [MG * recorded.mass[span], thing]
    return {"time": time - time[0], **dict(zip(names, np.hstack(values).T, strict=True))}


def _stated(name: str) -> str:
    """The name of an object or scene, or where its file is, for a set in another folder."""
    return str(Path(name).resolve()) if Path(name).is_file() else name


def _unit(column: str) -> str:
    part, _, name = column.partition(".")
    if name.startswith("q"):
        return ""
    if part == "wrench":
        return "N mm" if name.startswith("t") else "N"
    return {"time": "s", **PART_UNITS}[part]


def _strategy(bag: Path) -> str:
    """Name of the last strategy that the sequencer ran; "" if the bag does not tell."""
    with opened(bag) as reader:
        topic = next((name for name in reader.topics if name.endswith(RESULT_TOPIC)), None)
        told = [message.status for _, message in messages_of(bag, reader, topic)] if topic else []
    return told[-1][0].name.partition(": ")[2] if told and told[-1] else ""
