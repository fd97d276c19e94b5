"""Mappings that may hold more than their format names, but nothing that looks like a slip."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

from softhand_model.document import DocumentError, Node

ALIKE = 0.8  # of difflib: `protcol` is one slip from `protocol`


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
