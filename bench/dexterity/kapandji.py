"""Every criterion of the Kapandji test, with its negative controls.

A test that has been made (`python -m thesis run kapandji`) is judged as it is in out/thesis; else
it is made first, which takes half an hour.
"""

from __future__ import annotations

from typing import Any

from bench.grasps.maps import rows


def run() -> list[dict[str, Any]]:
    """A row a criterion: 1 where it is met."""
    return rows("kapandji")
