"""Reads YAML; errors name the file, the key, what was expected and what was found."""

from __future__ import annotations

import math
import os
import re
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import yaml

from softhand_common.documents.quoted import listed, quoted, shortened
from softhand_common.documents.yaml_reading import LARGEST_DOCUMENT, read_yaml

NAME_RULE = "a name of letters, digits, _ and -"
# of a measured quantity in SI units: squares of numbers beyond them overflow
SMALLEST_NUMBER, LARGEST_NUMBER = 1e-20, 1e15
TYPO_CUTOFF = 0.8  # similarity by difflib from which on a key is a typo: `protcol`, `protocol`


class DocumentError(ValueError):
    """A file does not hold what its format requires."""


@dataclass(frozen=True)
class Bounds:
    """Range of a quantity: low <= number <= high, both in `unit`."""

    low: float
    high: float
    unit: str


class Node:
    """A value of a document and its place; accessors check the value and return plain data.

    All accessors raise DocumentError for a value that is not what they read.

    Args:
        file, key: the place of the value, for errors.
        value: the value itself.
        source: PyYAML's node of the value, which has its line; None for a value of no file.
    """

    def __init__(self, file: str, key: str, value: Any, source: yaml.Node | None = None) -> None:
        self.file, self.key, self.value, self.source = file, key, value, source

    @property
    def place(self) -> str:
        """File, line if it is known, and key."""
        line = "" if self.source is None else f":{self.source.start_mark.line + 1}"
        return f"{self.file}{line}: {shortened(self.key) or 'document'}"

    def error(self, expected: str, got: str | None = None) -> DocumentError:
        """The DocumentError to raise, with place, `expected` and `got` (None: the value itself)."""
        return DocumentError(
            f"{self.place}: expected {expected}, got {quoted(self.value) if got is None else got}"
        )

    # ---------------------------------------------------------------- mappings and lists
    def mapping(self) -> dict[str, Node]:
        """Children of a mapping by key."""
        if not isinstance(self.value, dict):
            raise self.error("a mapping")
        for key in self.value:
            if not isinstance(key, str):
                raise self.error(
                    "keys that are text",
                    f"the key {shortened(str(key))}, which YAML reads as "
                    f"{type(key).__name__}; write '{shortened(str(key))}'",
                )
        prefix = f"{self.key}." if self.key else ""
        sources = {key.value: value for key, value in self._sources()}
        return {
            key: Node(self.file, prefix + key, value, sources.get(key))
            for key, value in self.value.items()
        }

    def _sources(self) -> list[Any]:
        return [] if self.source is None else self.source.value

    def fields(self, required: Iterable[str] = (), optional: Iterable[str] = ()) -> dict[str, Node]:
        """Children of a mapping that has all required keys and otherwise only optional ones."""
        children, required, optional = self.mapping(), list(required), list(optional)
        missing = [key for key in required if key not in children]
        if missing:
            raise self.error(f"the key {missing[0]}", listed(children))
        unknown = [key for key in children if key not in required + optional]
        if unknown:
            raise self.error(
                f"only the keys {', '.join(required + optional)}", shortened(unknown[0])
            )
        return children

    def require_format(self, name: str) -> None:
        """Raise DocumentError unless the mapping's key `format` has the value `name`."""
        children = self.mapping()
        if "format" not in children:
            raise self.error(f"the key `format` with the value {name}", "none")
        children["format"].choice([name])

    def items(self) -> list[Node]:
        """Children of a list."""
        if not isinstance(self.value, list):
            raise self.error("a list")
        sources = self._sources() or [None] * len(self.value)
        return [
            Node(self.file, f"{self.key}[{index}]", value, source)
            for index, (value, source) in enumerate(zip(self.value, sources, strict=True))
        ]

    # ---------------------------------------------------------------- scalars
    def number(
        self, low: float = -math.inf, high: float = math.inf, above: float = -math.inf
    ) -> float:
        """A number with low <= number <= high, number > above and |number| <= LARGEST_NUMBER."""
        value = self.value
        if not _is_number(value) or not (low <= value <= high and value > above):
            raise self.error(f"a number{_range(low, high, above)}")
        if abs(value) > LARGEST_NUMBER:
            raise self.error(f"a number of at most {LARGEST_NUMBER:g} in size")
        return float(value)

    def positive(self) -> float:
        """A number of at least SMALLEST_NUMBER."""
        if 0.0 < self.number(above=0.0) < SMALLEST_NUMBER:
            raise self.error(f"a number of at least {SMALLEST_NUMBER:g}")
        return float(self.value)

    def whole(self, low: int, high: int, other: str = "") -> int:
        """A whole number with low <= number <= high; `other` is appended to the error's "expected":
        what else the key may hold, such as ` or all`.
        """
        value = self.value
        if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
            raise self.error(f"a whole number from {low} to {high}{other}")
        return value

    def within(self, bounds: Bounds) -> float:
        """A number within bounds; the error names them with their unit.

        >>> Node("a", "d", 3).within(Bounds(0, 1, "m"))  # doctest: +ELLIPSIS
        Traceback (most recent call last):
        softhand_common.documents.yaml_document.DocumentError: a: d: expected ... to 1 m, got 3
        """
        try:
            return self.number(bounds.low, bounds.high)
        except DocumentError:
            raise self.error(
                f"a number from {bounds.low:.4g} to {bounds.high:.4g} {bounds.unit}".rstrip()
            ) from None

    def name(self) -> str:
        """Text that can name a file: letters, digits, _ and -."""
        if not is_name(self.value):
            raise self.error(NAME_RULE)
        return str(self.value)

    def text(self) -> str:
        """Text that is not empty."""
        if not isinstance(self.value, str) or not self.value:
            raise self.error("text that is not empty")
        return self.value

    def choice(self, choices: Iterable[Any]) -> Any:
        """One of the given values."""
        choices = list(choices)
        for choice in choices:  # True is 1 to Python
            if choice == self.value and isinstance(choice, bool) == isinstance(self.value, bool):
                return choice
        raise self.error(f"one of {listed(choices)}")

    # ---------------------------------------------------------------- lists of scalars
    def vector(self, length: int = 3, bounds: Bounds | None = None) -> tuple[float, ...]:
        """`length` finite numbers, each within bounds if there are any."""
        children = self.items()
        if len(children) != length:
            raise self.error(f"{length} numbers")
        return tuple(child.within(bounds) if bounds else child.number() for child in children)

    def names(self) -> tuple[str, ...]:
        """The names in a list of one or more, none of them twice."""
        names = tuple(child.text() for child in self.items())
        if not names or len(set(names)) != len(names):
            raise self.error("a list of one or more names without duplicates")
        return names


def read_document(path: Path, format_name: str | None = None) -> Node:
    """The YAML document of a file; with `format_name`, its key `format` must have that value.

    Raises DocumentError (a ValueError) when the file cannot be read, is not YAML, exceeds the
    limits of `yaml_reading` or has another format.
    """
    text = _text(path)
    try:
        value, source = read_yaml(text)
    except yaml.YAMLError as reason:
        raise DocumentError(_refusal(path, text, reason)) from reason
    node = Node(str(path), "", value, source)
    if format_name is not None:
        node.require_format(format_name)
    return node


def _text(path: Path) -> str:
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST_DOCUMENT + 1)
    except (OSError, ValueError) as reason:  # a ValueError: a name with a null character
        got = getattr(reason, "strerror", None) or reason
        raise DocumentError(f"{path}: expected a readable file, got {got}") from reason
    if len(content) > LARGEST_DOCUMENT:
        raise DocumentError(f"{path}: expected at most {LARGEST_DOCUMENT} bytes, got more")
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError as reason:
        line = content.count(b"\n", 0, reason.start) + 1
        raise DocumentError(
            f"{path}:{line}: expected text in UTF-8, got byte {content[reason.start]:#04x}"
        ) from reason


def _refusal(path: Path, text: str, reason: yaml.YAMLError) -> str:
    mark, position = (getattr(reason, name, None) for name in ("problem_mark", "position"))
    before = text.count("\n", 0, position or 0) if mark is None else mark.line
    parts = [getattr(reason, part, None) for part in ("context", "problem")]
    got = " ".join(filter(None, parts)) or " ".join(str(reason).split())
    message = got if got.startswith("expected") else f"expected YAML, got {got}"
    return f"{path}:{before + 1}: {message}"


def is_document(name: str | Path) -> bool:
    """Whether a path is that of an existing YAML file."""
    return Path(name).suffix in (".yaml", ".yml") and os.path.isfile(name)


def is_name(value: Any) -> bool:
    """Whether a value can name a file: letters, digits, _ and - alone.

    >>> is_name("hand_2"), is_name("../hand")
    (True, False)
    """
    return isinstance(value, str) and re.fullmatch(r"[A-Za-z0-9_-]+", value) is not None


def _is_number(value: Any) -> bool:
    plain = isinstance(value, int | float) and not isinstance(value, bool)
    return plain and abs(value) <= sys.float_info.max  # an int may be larger than any float


def _range(low: float, high: float, above: float) -> str:
    parts = [f"above {above:g}"] if math.isfinite(above) else []
    parts += [f"at least {low:g}"] if math.isfinite(low) else []
    parts += [f"at most {high:g}"] if math.isfinite(high) else []
    return " " + " and ".join(parts) if parts else ""


def open_fields(
    node: Node, required: Iterable[str] = (), optional: Iterable[str] = ()
) -> dict[str, Node]:
    """Children of a mapping that has all required keys; keys that are neither required nor optional
    are returned, too.

    Raises DocumentError for a missing required key, and for an unknown key that looks like a typo
    of a known key that is missing.
    """
    children = node.mapping()
    absent = [key for key in (*required, *optional) if key not in children]
    for key in children:
        meant = get_close_matches(key, absent, n=1, cutoff=TYPO_CUTOFF)
        if meant and key not in required and key not in optional:
            raise node.error(f"the key {meant[0]}", f"{shortened(key)}; write {meant[0]}")
    for key in required:
        if key not in children:
            raise node.error(f"the key {key}", listed(children))
    return children
