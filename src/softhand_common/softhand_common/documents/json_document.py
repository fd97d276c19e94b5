"""Reads JSON; errors name the file, the key, what was expected and what was found."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import NoReturn

from softhand_common.documents.quoted import quoted, shortened
from softhand_common.documents.yaml_document import DocumentError, Node
from softhand_common.documents.yaml_reading import LONGEST_NUMBER

LARGEST_JSON = 2**26  # [bytes] of a file


def json_node(place: str, text: str | bytes) -> Node:
    """The document of a JSON text; `place` names the text in errors.

    Raises DocumentError for text that is not JSON or has a number that is not finite.
    """
    try:
        value = json.loads(text, parse_float=_finite, parse_int=_whole, parse_constant=_refuse)
    except (ValueError, RecursionError) as reason:
        got = shortened(" ".join(str(reason).split()))
        raise DocumentError(f"{place}: expected JSON, got {got}") from reason
    return Node(place, "", value)


def read_json(path: Path, format_name: str | None = None) -> Node:
    """Read a JSON file. If `format_name` is given, the file's key `format` must have this value.

    Raises DocumentError for a file that cannot be read, is not JSON or has another format.
    """
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST_JSON + 1)
    except OSError as reason:
        raise DocumentError(f"{path}: expected a readable file, got {reason.strerror}") from reason
    if len(content) > LARGEST_JSON:
        raise DocumentError(f"{path}: expected at most {LARGEST_JSON} bytes, got more")
    node = json_node(str(path), content)
    if format_name is not None:
        node.require_format(format_name)
    return node


def _finite(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        _refuse(text)
    return value


def _whole(text: str) -> int:
    if len(text) > LONGEST_NUMBER:
        raise ValueError(f"a number of {len(text)} characters, more than {LONGEST_NUMBER}")
    return int(text)


def _refuse(text: str) -> NoReturn:
    raise ValueError(f"{quoted(text)}, which is not a finite number")
