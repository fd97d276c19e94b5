"""Objectives of searches: functions with the decorator `objective`, found by their names.

An objective takes values by variable and the settings of its problem, both plain data, and returns
plain data for JSON with the key `cost`, a finite number; the record keeps whatever else it returns.
Its result must depend on these values and settings alone.
"""

from __future__ import annotations

import importlib
import math
from collections.abc import Callable, Mapping
from importlib.metadata import entry_points
from typing import Any

GROUP = "softhand.objectives"  # of entry points, by which packages register objectives
ALLOW = "--allow-objectives"
COST = "cost"
MARK = "search_objective"

Objective = Callable[[Mapping[str, float], Mapping[str, Any]], dict[str, Any]]


def objective(function: Objective) -> Objective:
    """Decorator that marks a function as an objective; a problem can only name such functions."""
    setattr(function, MARK, True)
    return function


def check_name(name: str, allow_any: bool) -> None:
    """Refuse a name that is not of the form `module:function`, and, unless `allow_any`, one that no
    installed package registers as an entry point of the group `softhand.objectives`. Nothing is
    imported.

    Raises ValueError.
    """
    module, _, function = name.partition(":")
    if not function.isidentifier() or not all(part.isidentifier() for part in module.split(".")):
        raise ValueError(f"objective: expected module:function, got {name!r}")
    if not allow_any and name not in {point.value for point in entry_points(group=GROUP)}:
        raise ValueError(
            f"objective: expected one that an installed package registers, got {name}; if you "
            f"trust the code of its module, run it with {ALLOW}"
        )


def find_objective(name: str, allow_any: bool = False) -> Objective:
    """The objective of a name `module:function`; its module is imported. Raises ValueError for a
    name that is refused, a function that does not exist, and one that is not marked.
    """
    check_name(name, allow_any)
    place, _, function = name.partition(":")
    try:
        found: Objective | None = getattr(importlib.import_module(place), function, None)
    except ModuleNotFoundError as reason:
        raise ValueError(f"objective: expected a module that can be imported: {reason}") from reason
    if found is None or not getattr(found, MARK, False):
        raise ValueError(
            f"objective: expected a function with the decorator `objective`, got {name}"
        )
    return found


def evaluate(
    name: str, values: Mapping[str, float], settings: Mapping[str, Any], allow_any: bool = False
) -> dict[str, Any]:
    """The result of an objective for these values.

    Raises ValueError when the key `cost` of the result is not a finite number.
    """
    found = find_objective(name, allow_any)(values, settings)
    cost = found.get(COST)
    if not isinstance(cost, (int, float)) or not math.isfinite(cost):
        raise ValueError(f"{name}: cost: expected a finite number, got {cost!r}")
    return found
