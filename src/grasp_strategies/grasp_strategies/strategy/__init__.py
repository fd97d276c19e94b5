"""Strategies as data: their files, the world they were tried in, variants, what they fit."""

from grasp_strategies.strategy.description import (
    Condition,
    HeldOut,
    Phase,
    Strategy,
    Success,
    Vector,
    Waypoint,
)
from grasp_strategies.strategy.reading import DATA, load_strategy, read_strategy, strategy_names

__all__ = [
    "DATA",
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
