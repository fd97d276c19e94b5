"""Reading YAML with errors that name file, key, what was expected and what was found."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from importlib import resources
from pathlib import Path
from typing import Any

import yaml

NAME_RULE = "a name of letters, digits, _ and -"
ALIKE = 0.8  # of difflib: `protcol` is one slip from `protocol`


class DocumentError(ValueError):
    """A file that does not hold what its format asks for."""


@dataclass(frozen=True)
class Bounds:
    """What a quantity can be: low <= number <= high, both in `unit`."""

    low: float
    high: float
    unit: str


class Node:
    """A value in a document with its place; accessors check it and return plain data."""

    def __init__(self, file: str, key: str, value: Any) -> None:
        self.file, self.key, self.value = file, key, value

    def error(self, expected: str) -> DocumentError:
        """The error to raise: file, key, expected, got."""
        return DocumentError(
            f"{self.file}: {self.key or 'document'}: expected {expected}, got {_shown(self.value)}"
        )

    # ---------------------------------------------------------------- mappings and lists
    def mapping(self) -> dict[str, Node]:
        """Children of a mapping by name."""
        if not isinstance(self.value, dict) or not all(isinstance(key, str) for key in self.value):
            raise self.error("a mapping")
        prefix = f"{self.key}." if self.key else ""
        return {key: Node(self.file, prefix + key, value) for key, value in self.value.items()}

    def fields(self, required: Iterable[str] = (), optional: Iterable[str] = ()) -> dict[str, Node]:
        """Children of a mapping with all the required keys, and no others but the optional."""
        children, required, optional = self.mapping(), list(required), list(optional)
        missing = [key for key in required if key not in children]
        if missing:
            raise DocumentError(
                f"{self.file}: {self.key or 'document'}: expected the key {missing[0]}, "
                f"got {', '.join(children) or 'nothing'}"
            )
        unknown = [key for key in children if key not in required + optional]
        if unknown:
            raise DocumentError(
                f"{self.file}: {self.key or 'document'}: expected only the keys "
                f"{', '.join(required + optional)}, got {unknown[0]}"
            )
        return children

    def items(self) -> list[Node]:
        """Children of a list."""
        if not isinstance(self.value, list):
            raise self.error("a list")
        return [
            Node(self.file, f"{self.key}[{index}]", value) for index, value in enumerate(self.value)
        ]

    # ---------------------------------------------------------------- scalars
    def number(
        self, low: float = -math.inf, high: float = math.inf, above: float = -math.inf
    ) -> float:
        """A finite number with low <= number <= high and number > above."""
        value = self.value
        good = (
            isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
        )
        if not good or not (low <= value <= high and value > above):
            raise self.error(f"a number{_range(low, high, above)}")
        return float(value)

    def positive(self) -> float:
        """A finite number above 0."""
        return self.number(above=0.0)

    def within(self, bounds: Bounds) -> float:
        """A number within bounds, which the error names with their unit.

        >>> Node("a", "wall", 3).within(Bounds(0, 1, "m"))
        Traceback (most recent call last):
        softhand_model.yaml_document.DocumentError: a: wall: expected a number from 0 to 1 m, got 3
        """
        try:
            return self.number(bounds.low, bounds.high)
        except DocumentError:
            raise self.error(
                f"a number from {bounds.low:.4g} to {bounds.high:.4g} {bounds.unit}"
            ) from None

    def name(self) -> str:
        """Text that can name a file: letters, digits, _ and -."""
        if not is_name(self.value):
            raise self.error(NAME_RULE)
        return str(self.value)

    def text(self) -> str:
        """A string that is not empty."""
        if not isinstance(self.value, str) or not self.value:
            raise self.error("text")
        return self.value

    def choice(self, choices: Iterable[Any]) -> Any:
        """One of the given values."""
        choices = list(choices)
        if self.value not in choices:
            raise self.error("one of " + ", ".join(str(choice) for choice in choices))
        return self.value

    # ---------------------------------------------------------------- lists of scalars
    def vector(self, length: int = 3, bounds: Bounds | None = None) -> tuple[float, ...]:
        """`length` finite numbers, each within bounds if there are any."""
        children = self.items()
        if len(children) != length:
            raise self.error(f"{length} numbers")
        return tuple(child.within(bounds) if bounds else child.number() for child in children)

    def names(self) -> tuple[str, ...]:
        """At least one name, none twice."""
        names = tuple(child.text() for child in self.items())
        if not names or len(set(names)) != len(names):
            raise self.error("a list of different names")
        return names


class _Loader(yaml.SafeLoader):
    """The safe loader that reads `1e-6` as a number, as YAML 1.2 does and PyYAML does not, and
    refuses a key given twice, which YAML forbids and PyYAML lets pass.
    """

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        """A mapping; raises a YAMLError for a repeated key."""
        keys = [self.construct_object(key, deep=True) for key, _ in node.value]
        for key in keys:
            if keys.count(key) > 1:
                raise yaml.constructor.ConstructorError(
                    None, None, f"the key {key} twice", node.start_mark
                )
        return super().construct_mapping(node, deep=deep)


_Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float",
    re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)[eE][-+]?[0-9]+$"),
    list("-+.0123456789"),
)


def read_document(path: Path, format_name: str | None = None) -> Node:
    """The YAML document of a file; its key `format`, if asked for, must have the given value.

    Raises DocumentError (a ValueError) when the file cannot be read, is no YAML or has another
    format.
    """
    try:
        value = yaml.load(path.read_text(encoding="utf-8"), Loader=_Loader)
    except OSError as reason:
        raise DocumentError(f"{path}: expected a readable file, got {reason.strerror}") from reason
    except (yaml.YAMLError, UnicodeDecodeError) as reason:
        raise DocumentError(
            f"{path}: expected YAML, got {' '.join(str(reason).split())}"
        ) from reason
    node = Node(str(path), "", value)
    if format_name is not None:
        children = node.mapping()
        if "format" not in children:
            raise DocumentError(
                f"{path}: document: expected the key format: {format_name}, got none"
            )
        children["format"].choice([format_name])
    return node


def data_file(*parts: str) -> Path:
    """Path of a file that the package ships under data/."""
    return Path(str(resources.files("softhand_model"))).joinpath("data", *parts)


def shipped_names(folder: str) -> list[str]:
    """Names of the YAML files shipped in a folder of data/."""
    return sorted(path.stem for path in data_file(folder).glob("*.yaml"))


def find_document(name: str | Path, folder: str, kind: str) -> Path:
    """The shipped file of that name in data/<folder>, or else the file at that path.

    Raises ValueError with the names that exist.
    """
    if str(name) in shipped_names(folder):
        return data_file(folder, f"{name}.yaml")
    path = Path(name)
    if path.suffix in (".yaml", ".yml") and path.is_file():
        return path
    raise ValueError(
        f"{kind}: expected one of {', '.join(shipped_names(folder))} or the path of a YAML file, "
        f"got {name}"
    )


def is_name(value: Any) -> bool:
    """Whether a value can name a file: letters, digits, _ and - alone.

    >>> is_name("hand_2"), is_name("../hand")
    (True, False)
    """
    return isinstance(value, str) and re.fullmatch(r"[A-Za-z0-9_-]+", value) is not None


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def _range(low: float, high: float, above: float) -> str:
    parts = [f"above {above:g}"] if math.isfinite(above) else []
    parts += [f"at least {low:g}"] if math.isfinite(low) else []
    parts += [f"at most {high:g}"] if math.isfinite(high) else []
    return " " + " and ".join(parts) if parts else ""


def named_entries(node: Node) -> dict[str, Node]:
    """Children of a mapping by name; raises DocumentError also for names that are no text."""
    if isinstance(node.value, dict):
        for key in node.value:
            if not isinstance(key, str):
                raise DocumentError(
                    f"{node.file}: {node.key or 'document'}: expected names as text, got {key!r}; "
                    "put it into quotes"
                )
    return node.mapping()


def open_fields(
    node: Node, required: Iterable[str] = (), optional: Iterable[str] = ()
) -> dict[str, Node]:
    """Children of a mapping with all the required keys; unknown keys are kept.

    Raises DocumentError for a missing key and for an unknown one that is nearly a known one that is
    not there.
    """
    children = named_entries(node)
    absent = [key for key in (*required, *optional) if key not in children]
    for key in children:
        meant = get_close_matches(key, absent, n=1, cutoff=ALIKE)
        if meant and key not in required and key not in optional:
            raise DocumentError(
                f"{node.file}: {node.key or 'document'}: expected the key {meant[0]}, got {key}; "
                f"write {meant[0]}"
            )
    for key in required:
        if key not in children:
            raise DocumentError(
                f"{node.file}: {node.key or 'document'}: expected the key {key}, "
                f"got {', '.join(children) or 'nothing'}"
            )
    return children
