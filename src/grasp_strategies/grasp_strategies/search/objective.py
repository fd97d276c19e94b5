"""Objectives of searches: marked functions, found by their names.

An objective takes values by variable and the settings of its problem, both plain data, and returns
plain data for JSON with the key `cost`, a finite number; what else it returns is kept in the line.
It must give the same for the same, in any process, in any order.
"""

from __future__ import annotations

import importlib
import math
from collections.abc import Callable, Mapping
from typing import Any

OURS = ("grasp_strategies", "model_lab", "pneuflex_sim", "softhand_model", "thesis")
ALLOW = "--allow-objectives"
COST = "cost"
MARK = "search_objective"

Objective = Callable[[Mapping[str, float], Mapping[str, Any]], dict[str, Any]]


def objective(function: Objective) -> Objective:
    """Mark a function as an objective: no other can be named by a problem."""
    setattr(function, MARK, True)
    return function


def check_name(name: str, allow_any: bool) -> None:
    """Refuse a name that is no `module:function`, or one of a module that is not of this suite
    unless any is allowed; nothing is imported. Raises ValueError.
    """
    module, _, function = name.partition(":")
    if not function.isidentifier() or not all(part.isidentifier() for part in module.split(".")):
        raise ValueError(f"objective: expected module:function, got {name!r}")
    if not allow_any and module.partition(".")[0] not in OURS:
        raise ValueError(
            f"objective: expected a module of {', '.join(OURS)}, got {name}, whose code would be "
            f"run; {ALLOW} runs it"
        )


def find_objective(name: str, allow_any: bool = False) -> Objective:
    """The objective of a name `module:function`; its module is imported. Raises ValueError for one
    that is refused, not there, or not marked.
    """
    check_name(name, allow_any)
    place, _, function = name.partition(":")
    try:
        found = getattr(importlib.import_module(place), function, None)
    except ModuleNotFoundError as reason:
        raise ValueError(f"objective: expected a module that is there: {reason}") from reason
    if not getattr(found, MARK, False):
        raise ValueError(f"objective: expected a function marked as objective, got {name}")
    return found  # type: ignore[no-any-return]


def evaluate(
    name: str, values: Mapping[str, float], settings: Mapping[str, Any], allow_any: bool = False
) -> dict[str, Any]:
    """What an objective returns for these values.

    Raises ValueError when its cost is no finite number.
    """
    found = find_objective(name, allow_any)(values, settings)
    cost = found.get(COST)
    if not isinstance(cost, (int, float)) or not math.isfinite(cost):
        raise ValueError(f"{name}: cost: expected a finite number, got {cost!r}")
    return found
