"""Every criterion of the maps of chapters 8 and 9 and of shape adaptability, with their controls.

They are judged as they lie in out/thesis (`python -m thesis run NAME` makes one, in hours, and
goes on with one that was stopped or that lacks objects or checks); nothing is run here.
"""

from __future__ import annotations

from collections.abc import Iterator
from types import ModuleType
from typing import Any

from bench.row import at_least
from thesis import frame
from thesis.__main__ import OUT

TAKES = "seconds"
MAPS = ("push_map", "surface_map", "edge_map", "wall_success", "shape_adaptability")


def run() -> list[dict[str, Any]]:
    """A row a criterion: 1 where it is met, 0 where it is missed or was not run."""
    return [row for name in MAPS for row in rows(name)]


def rows(name: str) -> list[dict[str, Any]]:
    """Those of one experiment."""
    found = criteria(name, frame.experiment(name))
    return [at_least(f"{name}: {what}", met, "", 1) for what, met in found]


def criteria(name: str, module: ModuleType) -> Iterator[tuple[str, bool]]:
    """Criteria of a map and whether they are met; what is left out of the usual map is not."""
    folder = OUT / name
    if not (folder / frame.RESULT).exists():
        yield f"not made, python -m thesis run {name}", False
        return
    parameters, results = frame.read_result(folder, module)
    for found in module.report(results, parameters).findings:
        if found.met is not None:
            yield f"{found.what}: {found.ours}", found.met
    for kind in ("objects", "checks", "types", "cases"):
        for usual in getattr(type(parameters)(), kind, ()):
            if usual not in getattr(parameters, kind):
                yield f"{kind}: {usual} was not run", False
