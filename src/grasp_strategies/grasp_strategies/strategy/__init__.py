"""Strategies as data: files, the scenes they were tried in, variants, and matching objects."""

from grasp_strategies.strategy.description import (
    Condition,
    HeldOut,
    Phase,
    Strategy,
    Success,
    Vector,
    Waypoint,
)
from grasp_strategies.strategy.reading import (
    STRATEGY_FOLDER,
    load_strategy,
    read_strategy,
    strategy_names,
)

__all__ = [
    "STRATEGY_FOLDER",
    "Condition",
    "HeldOut",
    "Phase",
    "Strategy",
    "Success",
    "Vector",
    "Waypoint",
    "load_strategy",
    "read_strategy",
    "strategy_names",
]
