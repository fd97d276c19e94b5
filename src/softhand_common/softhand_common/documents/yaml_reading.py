"""Reads YAML text within limits of size and depth, so that no text can exhaust the reader.

Numbers are those of YAML 1.2 (`1e-6` is a number); dates are text. Tags are refused, as no format
needs them. Errors are those of PyYAML, with the place.
"""

from __future__ import annotations

import re
from typing import Any

import yaml
from yaml.constructor import ConstructorError

from softhand_common.documents.quoted import quoted, shortened

LARGEST_DOCUMENT = 2**20  # [bytes]; a calibration of eight outlets has 25,000
DEEPEST = 32  # levels of lists and mappings
MOST_VALUES = 100_000  # an alias counts as the values that it repeats
LONGEST_KEY = 200  # characters
LONGEST_NUMBER = 60  # characters

_FLOAT = "tag:yaml.org,2002:float"
_NUMBERS = ("tag:yaml.org,2002:int", _FLOAT)
_DATE = "tag:yaml.org,2002:timestamp"
_FASTEST: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


class _Loader(_FASTEST):
    """The safe loader with the numbers of YAML 1.2, and without dates."""

    yaml_implicit_resolvers = {  # noqa: RUF012 (as in the base class)
        first: [(tag, rule) for tag, rule in rules if tag != _DATE]
        for first, rules in yaml.SafeLoader.yaml_implicit_resolvers.items()
    }


_Loader.add_implicit_resolver(
    _FLOAT, re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)[eE][-+]?[0-9]+$"), list("-+.0123456789")
)


def read_yaml(text: str) -> tuple[Any, yaml.Node | None]:
    """The value of a text, and PyYAML's node of it with the lines; both None for an empty text.

    Raises yaml.YAMLError for text that is not YAML, has tags or exceeds the limits of this module.
    """
    _check_extent(text)
    loader = _Loader(text)
    try:
        node = loader.get_single_node()
        return (None if node is None else _value(loader, node, {})), node
    finally:
        loader.dispose()


def _check_extent(text: str) -> None:
    """Refuse too many levels or values before any of them is built."""
    values = 0
    begun: list[tuple[str | None, int]] = []  # open collections: anchor, values before its content
    extents: dict[str | None, int] = {}  # values by anchor
    for event in yaml.parse(text, Loader=_Loader):
        if isinstance(event, yaml.CollectionEndEvent):
            anchor, before = begun.pop()
            extents[anchor] = values - before
        elif isinstance(event, yaml.AliasEvent):
            if event.anchor not in extents:
                raise _error(
                    event, f"an anchor before its alias, got *{shortened(str(event.anchor))}"
                )
            values += extents[event.anchor]
        elif isinstance(event, yaml.CollectionStartEvent | yaml.ScalarEvent):
            if event.tag is not None:
                raise _error(event, f"a value without tag, got {quoted(event.tag)}")
            values += 1
            if isinstance(event, yaml.CollectionStartEvent):
                begun.append((event.anchor, values))
            else:
                extents[event.anchor] = 1
        if len(begun) > DEEPEST:
            raise _error(event, f"at most {DEEPEST} levels of lists and mappings, got more")
        if values > MOST_VALUES:
            raise _error(event, f"at most {MOST_VALUES} values, aliases written out, got more")


def _value(loader: Any, node: yaml.Node, known: dict[int, Any]) -> Any:
    """Plain data of a node; `known` holds those of lists and mappings, which aliases share."""
    if isinstance(node, yaml.ScalarNode):
        return _scalar(loader, node)
    if id(node) not in known:
        if isinstance(node, yaml.MappingNode):
            known[id(node)] = _mapping(loader, node, known)
        else:
            known[id(node)] = [_value(loader, entry, known) for entry in node.value]
    return known[id(node)]


def _mapping(loader: Any, node: yaml.MappingNode, known: dict[int, Any]) -> dict[Any, Any]:
    found: dict[Any, Any] = {}
    for entry, value in node.value:
        key = _key(loader, entry)
        if key in found:
            raise _error(entry, f"every key once, got the key {shortened(str(key))} twice")
        found[key] = _value(loader, value, known)
    return found


def _key(loader: Any, node: yaml.Node) -> Any:
    if not isinstance(node, yaml.ScalarNode):
        raise _error(node, "a plain key, got a list or a mapping")
    if len(node.value) > LONGEST_KEY:
        raise _error(node, f"a key of at most {LONGEST_KEY} characters, got {quoted(node.value)}")
    return _scalar(loader, node)


def _scalar(loader: Any, node: yaml.ScalarNode) -> Any:
    if node.tag in _NUMBERS and len(node.value) > LONGEST_NUMBER:
        raise _error(
            node, f"a number of at most {LONGEST_NUMBER} characters, got {quoted(node.value)}"
        )
    try:
        return loader.construct_object(node)
    except ValueError:  # `0x_` looks like a number
        raise _error(node, f"a number, got {quoted(node.value)}") from None


def _error(place: Any, expected: str) -> ConstructorError:
    return ConstructorError(None, None, f"expected {expected}", place.start_mark)
