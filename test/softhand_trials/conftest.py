"""Fixtures: a strategy with times and ways that tests know in closed form."""

from strategy_files import make_strategy, write_strategy  # noqa: F401
