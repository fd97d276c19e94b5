"""Every criterion of the Kapandji test, with its negative controls.

The test is judged as `python -m thesis run kapandji` has left it in out/thesis.
"""

from __future__ import annotations

from typing import Any

from bench.grasps.maps import rows


def run() -> list[dict[str, Any]]:
    """A row a criterion: 1 where it is met."""
    return rows("kapandji")
