"""Where a number is in a ROS message, such as `effort[a]` or `pose.x`."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, is_dataclass
from typing import Any

import numpy as np

from softhand_common.documents.quoted import quoted

SHOWN_FIELDS = 24  # of those a message has, in an error
_STEP = re.compile(r"\.?([A-Za-z_]\w*)|\[([^\[\]]+)\]")


@dataclass(frozen=True)
class MessageField:
    """The path of a number in a message.

    `[key]` selects an element of an array by its name in the field `name` of the message, as in a
    JointState, or else by its index from 0.
    """

    text: str
    steps: tuple[tuple[str, bool], ...]  # (name or key, whether it is a key)

    @classmethod
    def parse(cls, text: str) -> MessageField:
        """The field that a text names; raises ValueError if it names none."""
        steps: list[tuple[str, bool]] = []
        place = 0
        while place < len(text) or not steps:
            step = _STEP.match(text, place)
            if step is None or (place == 0 and not step.group(1)):
                raise ValueError(
                    f"expected a field such as effort[a] or pose.x, got {quoted(text)}"
                )
            steps.append((step.group(1) or step.group(2), step.group(1) is None))
            place = step.end()
        return cls(text, tuple(steps))

    def value(self, message: Any) -> float:
        """The number in a message, in the unit of the message; raises LookupError if it has no
        number there.
        """
        value = _walked(message, self.steps)
        if not isinstance(value, int | float | np.number | np.bool_):
            raise LookupError("no single number")
        return float(value)

    def is_of_quaternion(self, message: Any) -> bool:
        """Whether the number is a component of a quaternion; raises LookupError if the message does
        not have it.
        """
        holder = _walked(message, self.steps[:-1])
        return str(getattr(holder, "__msgtype__", "")).endswith("/Quaternion")


def _walked(message: Any, steps: Sequence[tuple[str, bool]]) -> Any:
    """What stands in a message after some steps of a field."""
    holder = value = message
    for name, is_key in steps:
        if is_key:
            value = value[_index(holder, name, len(value))]
        else:
            holder, value = value, getattr(value, name, None)
        if value is None:
            raise LookupError(f"no {name}")
    return value


def number_fields(message: Any) -> list[str]:
    """Names of the fields of a message that hold a number, at most SHOWN_FIELDS."""
    shown: list[str] = []
    for text in fields_of(message):
        if len(shown) == SHOWN_FIELDS:
            return [*shown, "..."]
        shown.append(text)
    return shown


def _index(holder: Any, key: str, length: int) -> int:
    names = list(getattr(holder, "name", ()))
    if key in names:
        index = names.index(key)
    elif key.isdecimal():
        index = int(key)
    else:
        raise LookupError(f"no {key}")
    if index >= length:
        raise LookupError(f"{length} values")
    return index


def fields_of(message: Any, prefix: str = "") -> Iterator[str]:
    """Names of the fields of a message that hold a number, each after the prefix."""
    for entry in fields(message):
        value = getattr(message, entry.name)
        path = prefix + entry.name
        if entry.name in ("header", "name", "__msgtype__") or isinstance(value, str):
            continue
        if is_dataclass(value):
            yield from fields_of(value, path + ".")
        elif isinstance(value, list | np.ndarray):
            yield from _elements(message, path, value)
        else:
            yield path


def _elements(message: Any, path: str, values: Any) -> Iterator[str]:
    names = list(getattr(message, "name", ()))
    for index, value in enumerate(values):
        element = f"{path}[{names[index] if index < len(names) else index}]"
        if is_dataclass(value):
            yield from fields_of(value, element + ".")
        elif not isinstance(value, str):
            yield element
