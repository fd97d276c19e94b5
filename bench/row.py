"""One measured figure, as it is printed and written to bench.json."""

from __future__ import annotations

from typing import Any


def at_least(name: str, value: float, unit: str, target: float) -> dict[str, Any]:
    """A figure that must not fall below its target.

    >>> at_least("real-time factor", 1.2, "", 1.0)["met"]
    True
    """
    return _row(name, value, unit, f">= {target:g}", bool(value >= target))


def at_most(name: str, value: float, unit: str, target: float) -> dict[str, Any]:
    """A figure that must not exceed its target.

    >>> import numpy as np
    >>> at_most("drift in 1 s", np.float64(2.0), "mm", 1.0)["met"]
    False
    """
    return _row(name, value, unit, f"<= {target:g}", bool(value <= target))


def stated(name: str, value: float, unit: str) -> dict[str, Any]:
    """A figure without a target, for comparison.

    >>> stated("contacts", 40, "")["met"] is None
    True
    """
    return _row(name, value, unit, None, None)


def _row(
    name: str, value: float, unit: str, target: str | None, met: bool | None
) -> dict[str, Any]:
    return {"name": name, "value": float(value), "unit": unit, "target": target, "met": met}
