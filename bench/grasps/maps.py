"""Every criterion of the maps of chapters 8 and 9, with their negative controls.

A map that has been made (`python -m thesis run NAME`) is judged as it is in out/thesis; others are
made first, which takes hours.
"""

from __future__ import annotations

from typing import Any

from bench.row import at_least
from thesis import frame
from thesis.__main__ import OUT, main

MAPS = ("push_map", "surface_map", "edge_map", "wall_success")


def run() -> list[dict[str, Any]]:
    """A row a criterion: 1 where it is met."""
    return [row for name in MAPS for row in criteria(name)]


def criteria(name: str) -> list[dict[str, Any]]:
    """Those of one experiment, which is run if it has not been."""
    folder, module = OUT / name, frame.experiment(name)
    if not (folder / frame.RESULT).exists():
        main(["run", name])
    parameters, results = frame.read_result(folder, module)
    return [
        at_least(f"{name}: {found.what}: {found.ours}", found.met, "", 1)
        for found in module.report(results, parameters).findings
        if found.met is not None
    ]
