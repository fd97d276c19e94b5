"""Where a grasp begins to fail, at 1, 2 and 5 ms: the object lies beside where it is seen.

The strategy goes by the seen place, so the error of the seen place across the object (x) is what
decides. On a grid of errors around each border of success at 1 ms the other steps are compared; a
border moves by the difference in successes times the grid's width.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.row import at_least, at_most, stated
from grasp_strategies.scene import Array, Observation
from grasp_strategies.scene_in_process import InProcessScene
from grasp_strategies.sequencer import Sequencer
from grasp_strategies.trials import TrialSettings, started_scene

FINEST, STEPS = 0.001, (0.002, 0.005)
SEARCH = (-0.060, 0.061, 0.010)  # [m] first look: from, to, by
GRID = (-0.009, 0.0095, 0.002)  # [m] around a border
MOVE_TARGET, AGREE_TARGET = 3.0, 95.0  # [mm], [%]


class MisplacedScene:
    """A scene in which the object is seen beside its place by `error` (3,) [m]."""

    def __init__(self, scene: InProcessScene, error: Array) -> None:
        self._scene, self._error = scene, error
        self.channels, self.hand_bodies = scene.channels, scene.hand_bodies
        self.command_wrist, self.command_air = scene.command_wrist, scene.command_air
        self.vent, self.step, self.close = scene.vent, scene.step, scene.close

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._scene.time

    def observe(self) -> Observation:
        """What is seen now."""
        seen = self._scene.observe()
        return replace(seen, object_position=seen.object_position + self._error)


def gripped(error: float, step: float) -> bool:
    """Whether the grasp succeeds with this error [m] of the seen place along x."""
    started = started_scene(TrialSettings(step=step))
    scene = MisplacedScene(started.place((0.0, 0.0), 1.0), np.array([error, 0.0, 0.0]))
    return Sequencer(scene, started.strategy).run().gripped


def borders(errors: Array, outcomes: list[bool]) -> list[tuple[float, float]]:
    """Pairs of neighbouring errors between which the outcome changes."""
    pairs = zip(errors[:-1], errors[1:], outcomes[:-1], outcomes[1:], strict=True)
    return [(float(a), float(b)) for a, b, first, second in pairs if first != second]


def refine(low: float, high: float, step: float) -> float:
    """Border [m] between two errors of different outcome, to half a millimetre."""
    first = gripped(low, step)
    while high - low > 5e-4:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if gripped(middle, step) == first else (low, middle)
    return 0.5 * (low + high)


def rows(small: bool) -> list[dict[str, Any]]:
    """How far the borders move from 1 ms, and how often outcomes agree away from them."""
    coarse = np.arange(*SEARCH)
    found = borders(coarse, [gripped(error, FINEST) for error in coarse])
    places = [refine(low, high, FINEST) for low, high in found[: 1 if small else None]]
    grids = [place + np.arange(*GRID) for place in places]
    truth = _outcomes(grids, FINEST)
    beyond = [
        np.abs(grid - place) > 1e-3 * MOVE_TARGET for grid, place in zip(grids, places, strict=True)
    ]
    rows = [
        stated(f"border {k} of success, 1 ms: error of the seen place", 1e3 * place, "mm")
        for k, place in enumerate(places)
    ]
    for step in STEPS:
        other = _outcomes(grids, step)
        moved = [
            GRID[2] * abs(int(a.sum()) - int(b.sum())) for a, b in zip(truth, other, strict=True)
        ]
        agree = np.concatenate(
            [(a == b)[far] for a, b, far in zip(truth, other, beyond, strict=True)]
        )
        name = f"outcome of a grasp, {1e3 * step:g} ms against 1 ms"
        share = 100 * float(np.mean(agree))
        rows += [
            at_most(f"{name}: border moves", 1e3 * max(moved), "mm", MOVE_TARGET),
            at_least(f"{name}: agree beyond 3 mm, of {len(agree)}", share, "%", AGREE_TARGET),
        ]
    return rows


def _outcomes(grids: list[Array], step: float) -> list[NDArray[np.bool_]]:
    return [np.array([gripped(float(error), step) for error in grid]) for grid in grids]
