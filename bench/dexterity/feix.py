"""Every criterion of the grasps of the Feix taxonomy, with their negative controls.

They are judged as `python -m thesis run feix` has left them in out/thesis.
"""

from __future__ import annotations

from typing import Any

from bench.grasps.maps import rows


def run() -> list[dict[str, Any]]:
    """A row a criterion: 1 where it is met."""
    return rows("feix")
