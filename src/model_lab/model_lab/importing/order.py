"""The order in which runs were recorded, as their dates or the numbers in the names of their files
tell it.

The largest stretch so far, ageing and drifts depend on it; a shell lists `run_10` before `run_2`,
and `fast_3` before `slow_1`.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from model_lab.importing.tables import CLOCK, Table

YEAR = 3.2e7  # [s]; a time of a day is less, a date more
LAST_NUMBER = re.compile(r"(\d+)\D*$")


def as_recorded(paths: Sequence[Path]) -> list[Path]:
    """Files in the order of recording: by the last number of their names if that counts all of
    them, or all runs of several fingers or with several files each; else by all numbers in their
    names. Files that do not come in the order of a shell, by their letters, stay as they are, as
    then somebody chose the order.

    >>> [path.name for path in as_recorded([Path("fast_3"), Path("slow_1"), Path("slow_2")])]
    ['slow_1', 'slow_2', 'fast_3']
    >>> [path.name for path in as_recorded([Path("r1"), Path("r10"), Path("r2")])]
    ['r1', 'r2', 'r10']
    >>> [path.name for path in as_recorded([Path("b_1"), Path("a_2")])]
    ['b_1', 'a_2']
    >>> names = ["A_ramp_2", "A_stairs_1", "A_stairs_3", "B_ramp_2", "B_stairs_1", "B_stairs_3"]
    >>> [path.name for path in as_recorded(list(map(Path, names)))]
    ['A_stairs_1', 'B_stairs_1', 'A_ramp_2', 'B_ramp_2', 'A_stairs_3', 'B_stairs_3']
    """
    given = [str(path) for path in paths]
    if given not in (sorted(given), sorted(given, key=str.casefold)):
        return list(paths)
    found = [LAST_NUMBER.search(path.stem) for path in paths]
    numbers = [int(match[1]) for match in found if match]
    span = max(numbers) - min(numbers) + 1 if numbers else 0
    unique = len(paths) == len(set(numbers))
    whole = len(paths) == len(numbers) and span == len(set(numbers))
    if whole and (unique or _count_runs(paths, numbers)):
        return [path for _, path in sorted(zip(numbers, paths, strict=True))]
    return sorted(paths, key=_by_numbers)


def _count_runs(paths: Sequence[Path], numbers: Sequence[int]) -> bool:
    """Whether each number stands for one kind of run, such as a ramp, of which there are several
    kinds; words that occur beside every number name a finger or a device.
    """
    words: dict[int, list[frozenset[str]]] = {}
    for path, number in zip(paths, numbers, strict=True):
        found = frozenset(re.findall(r"[^\W\d_]+", path.stem.casefold()))
        words.setdefault(number, []).append(found)
    everywhere = frozenset.intersection(*(frozenset.union(*found) for found in words.values()))
    kinds = [{found - everywhere for found in of_number} for of_number in words.values()]
    return all(len(kind) == 1 for kind in kinds) and len(set(map(frozenset, kinds))) > 1


def by_dates(tables: Sequence[Table]) -> list[Table]:
    """Tables by the first date and time that each holds; as they are, if one holds none."""
    begun = [
        float(np.nanmin(column.values))
        for table in tables
        for column in [next((one for one in table.columns if one.unit == CLOCK), None)]
        if column is not None and np.nanmin(column.values) > YEAR
    ]
    if len(begun) < len(tables):
        return list(tables)
    return [tables[place] for place in np.argsort(begun, kind="stable")]


def _by_numbers(path: Path) -> list[tuple[int, str]]:
    """A key by which names are sorted, whose numbers count as numbers."""
    parts = re.split(r"(\d+)", str(path).casefold())
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in parts]
