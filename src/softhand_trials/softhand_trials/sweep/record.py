"""Checks of records that are read from a file of results: what each field can be."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import fields
from typing import Any

from softhand_common.documents.quoted import listed
from softhand_common.documents.yaml_document import Bounds, Node
from softhand_trials.sweep.task import Record
from softhand_trials.trials import Placement, TrialSettings

LONGEST_SETTING = 500  # characters
RECORDED_PLACE = Bounds(-10.0, 10.0, "m")  # of an object from where it belongs
FACTOR, RECORDED_ANGLE = Bounds(1e-6, 1e6, ""), Bounds(-10.0, 10.0, "rad")
TIME = Bounds(0.0, 1e9, "s")
LARGEST_REPLICATE = 10**6


def check_record(node: Node, needed: Iterable[str] = (), result: str = "") -> Record:
    """The record in a line of results. The types of known fields are checked; unknown fields are
    kept.

    Raises DocumentError that names file, line and field; `needed` and `result` are those of
    `read_results`.
    """
    found = node.mapping()
    wanted = ["key", *needed, *([result] if result and "error" not in found else [])]
    for name in wanted:
        if name not in found:
            raise node.error(f"the field {name}", listed(found))
    # fields of other names and meanings are those of an objective, or of a grasp pattern
    of_trial = {"object", "settings"} & found.keys() if "placement" in found else set()
    for name, check in (FIELDS | {name: OF_TRIAL[name] for name in of_trial}).items():
        if name in found:
            check(found[name])
    if found.get("cause") and found["cause"].value and "phase" not in found:
        raise node.error("the field `phase` beside the field `cause`", listed(found))
    record: Record = node.value
    return record


def _name(node: Node) -> str:
    if len(node.text()) > LONGEST_SETTING or not node.text().isprintable():
        raise node.error(f"text of at most {LONGEST_SETTING} printable characters")
    return node.text()


def _text(node: Node) -> None:
    if not isinstance(node.value, str):
        raise node.error("text")


def _texts(node: Node) -> None:
    for child in node.mapping().values():
        _text(child)


def _numbers(node: Node) -> None:
    for child in node.mapping().values():
        child.number()


def _number(node: Node) -> None:
    if isinstance(node.value, bool) or not isinstance(node.value, int | float):
        raise node.error("a number")


def _time_or_none(node: Node) -> None:
    if node.value is not None:
        node.within(TIME)


def _versions(node: Node) -> None:
    _texts(node)
    if "code" not in node.value:
        raise node.error("the field code", listed(node.value))


def _check_settings(node: Node) -> None:
    """Settings of a trial; names that this version does not know are kept."""
    for name, child in node.mapping().items():
        if name in SETTING_TYPES:
            read_setting(name, child)


def read_setting(name: str, node: Node) -> Any:
    """The value of the trial's setting `name`, as a record has it; the trial itself checks whether
    it can be simulated.
    """
    kind = SETTING_TYPES[name]
    if node.value is None and "None" in kind:
        return None
    if kind.startswith("bool"):
        return node.choice([True, False])
    if kind.startswith("int"):
        return node.whole(1, 1000)
    if kind.startswith("float"):
        return node.number()
    if kind.startswith("tuple[str"):
        return tuple(_name(item) for item in node.items())
    return node.vector(3) if kind.startswith("tuple") else _name(node)


SETTING_TYPES = {field.name: str(field.type) for field in fields(TrialSettings)}
OFFSETS = {
    "offset": lambda node: node.vector(2, RECORDED_PLACE),
    "yaw": lambda node: node.within(RECORDED_ANGLE),
}


def _placement(node: Node) -> None:
    names = [field.name for field in fields(Placement)]
    for name, child in node.fields(["offset"], names).items():
        OFFSETS.get(name, lambda other: other.within(FACTOR))(child)


FIELDS: dict[str, Callable[[Node], Any]] = {
    "key": _name,
    "digest": _name,
    "outcome": _name,
    "error": _text,
    "cause": _text,
    "phase": _text,
    "cell": lambda node: node.vector(2, RECORDED_PLACE),
    "replicate": lambda node: node.whole(0, LARGEST_REPLICATE),
    "placement": _placement,
    "failed_at": _time_or_none,
    "wall_time": lambda node: node.within(TIME),
    "cpu_time": lambda node: node.within(TIME),
    "cost": _number,
    "values": _numbers,
    "versions": _versions,
}
OF_TRIAL: Mapping[str, Callable[[Node], Any]] = {"object": _name, "settings": _check_settings}
