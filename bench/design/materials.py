"""Tables 3.1 and 3.2 and the choice of a rubber, against brute force."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from bench.row import at_least, at_most
from softhand_design.rubber_choice import Choice, choose
from softhand_model.hand.rubber import Rubber
from thesis.chapter_3_and_5 import materials
from thesis.frame import Job, NoParameters

TAKES = "seconds"
REQUESTS = 50
GRID = 20_000  # heights of the brute force


def run(seed: int = 0) -> list[dict[str, Any]]:
    """Rows of the group."""
    return [*_tables(), *_choices(seed)]


def _tables() -> Iterator[dict[str, Any]]:
    given = NoParameters()
    results = materials.run(given, Job(Path("out"), lambda *told: None))
    found = materials.report(results, given).findings
    lines = [one for one in found if one.what.endswith("radial stretch") or "index" in one.what]
    printed = [one for one in lines if one.met is not None]  # errata left out
    yield at_least(
        f"lines of Tables 3.1 and 3.2 in print, {len(lines) - len(printed)} erratum left out",
        sum(one.met is True for one in printed),
        "",
        len(printed),
    )


def _choices(seed: int) -> Iterator[dict[str, Any]]:
    """The least height by the command against that among all heights that keep both bounds."""
    random = np.random.default_rng(seed)
    off, refused, named = 0.0, 0, 0
    for _ in range(REQUESTS):
        curvature = float(np.exp(random.uniform(np.log(20.0), np.log(400.0))))
        stiffness = float(np.exp(random.uniform(np.log(2e-4), np.log(3e-2))))
        for choice in choose(curvature, stiffness):
            least = _brute(choice.rubber, curvature, stiffness)
            if choice.suits:
                off = max(off, abs(choice.lowest.height / least - 1.0))
            else:
                refused += 1
                named += np.isinf(least) and _bound_does(choice, stiffness)
    yield at_most(f"least height against brute force, {REQUESTS} requests", 100.0 * off, "%", 0.1)
    yield at_least("refused rubbers, none of which brute force finds to do", named, "", refused)


def _brute(rubber: Rubber, curvature: float, stiffness: float) -> float:
    """Least height [m] with d <= h/2 and a stretch that the rubber bears; infinity if none."""
    heights = np.geomspace(1e-3, 1.0, GRID)
    walls = stiffness / (2.0 * rubber.shear_modulus * heights**3)
    good = (walls <= heights / 2.0) & (1.0 + curvature * heights <= rubber.max_stretch)
    return float(heights[good].min()) if good.any() else np.inf


def _bound_does(choice: Choice, stiffness: float) -> bool:
    """Whether the curvature that a refusal names would do."""
    most = float(choice.refused.split("curvature at most ")[1].split(" ")[0])
    found = choose(most, stiffness, rubbers=[choice.rubber])
    return found[0].suits
