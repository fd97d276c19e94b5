"""Tables of a MAT file: one of its variables, and one more for every structure in it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import scipy.io

from model_lab.aliases import Array
from model_lab.importing.tables import Column, Table, labelled
from model_lab.importing.units import unit_in_header
from softhand_common.documents.yaml_document import DocumentError

FEWEST_ROWS = 3


def read_matlab(path: Path) -> tuple[Table, ...]:
    """The tables of a MAT file up to version 7. Columns are vectors of equal length and columns of
    matrices. Structures with the same columns are runs, each with the name of its structure.

    Raises DocumentError for a file of another kind, or without two such vectors.
    """
    try:
        content = scipy.io.loadmat(path, squeeze_me=True, struct_as_record=False)
    except NotImplementedError as reason:
        raise DocumentError(
            f"{path}: expected a MAT file up to version 7, got version 7.3; "
            "save it in MATLAB with save(..., '-v7')"
        ) from reason
    # scipy raises what damaged bytes happen to make it raise
    except Exception as reason:
        said = " ".join(str(reason).split())
        raise DocumentError(f"{path}: expected a MAT file, got {said}") from reason
    variables = {name: value for name, value in content.items() if not name.startswith("__")}
    tables = [(name, _table(path, vectors)) for name, vectors in _structures("", variables)]
    named = [(name, table) for name, table in tables if table is not None]
    columns = {tuple(column.name for column in table.columns) for _, table in named}
    found = tuple(
        replace(table, path=labelled(path, name)) if len(named) > len(columns) == 1 else table
        for name, table in named
    )
    if not found:
        raise DocumentError(
            f"{path}: expected two vectors of equal length at least, got "
            f"{', '.join(variables) or 'nothing'}"
        )
    return found


def _structures(of: str, variables: Mapping[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Names of the structure and of each structure within it, each with its vectors and columns
    (rows,) by name.
    """
    vectors: dict[str, Any] = {}
    labels = [names for value in variables.values() if (names := _names(value))]
    for name, value in variables.items():
        if _names(value):
            continue
        if hasattr(value, "_fieldnames"):
            yield from _structures(
                f"{of} {name}".strip(), {key: getattr(value, key) for key in value._fieldnames}
            )
        elif isinstance(value, np.ndarray) and value.dtype.kind in "iuf" and value.ndim == 1:
            vectors[name] = value
        elif isinstance(value, np.ndarray) and value.dtype.kind in "iuf" and value.ndim == 2:
            vectors |= _columns(name, value, labels)
        elif isinstance(value, np.ndarray) and value.dtype == object:
            inside = {f"{name} {place + 1}": one for place, one in enumerate(value.flat)}
            yield from _structures(of, inside)
    yield of, vectors


def _names(value: Any) -> list[str]:
    """The texts of a cell array, or of rows of letters; empty for what is none."""
    texts = np.atleast_1d(value).tolist() if isinstance(value, np.ndarray) else []
    return [text.strip() for text in texts] if all(isinstance(t, str) for t in texts) else []


def _columns(name: str, matrix: Array, labels: Sequence[list[str]]) -> dict[str, Array]:
    """Columns of a matrix by name, or its rows if as many names as these are beside it."""
    for names in labels:
        for vectors in (matrix.T, matrix):
            if len(names) == len(vectors) == len(set(names)):
                return dict(zip(names, vectors, strict=True))
    return {f"{name} {place + 1}": column for place, column in enumerate(matrix.T)}


def _table(path: Path, vectors: Mapping[str, Any]) -> Table | None:
    """The vectors that are as long as most of them."""
    lengths = Counter(len(values) for values in vectors.values() if len(values) >= FEWEST_ROWS)
    if not lengths or max(lengths.values()) < 2:
        return None
    rows = lengths.most_common(1)[0][0]
    columns = [
        Column(*unit_in_header(name), values.astype(float))
        for name, values in vectors.items()
        if len(values) == rows
    ]
    return Table(path, tuple(columns))
