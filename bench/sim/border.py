"""Where a grasp begins to fail, at 1, 2 and 5 ms: the object lies beside where it is seen.

The strategy goes by the seen place, so the error of the seen place across the object (x) is what
decides. A grasp near a border of success is sensitive: tries that differ by a fraction of a
millimetre end differently at any step. So success at an error is a share, of the scattered tries
within a millimetre of it, and a border lies where that share crosses one half at 1 ms. Tries have
the same errors at every step. A border has moved as far as the farthest error at which the likely
outcome is another one.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.row import at_least, at_most, stated
from grasp_strategies.in_process_scene import InProcessScene
from grasp_strategies.scene import Array, Observation
from grasp_strategies.sequencer import Sequencer
from softhand_trials.trials import Placement, TrialSettings, started_scene

FINEST, STEPS = 0.001, (0.002, 0.005)
SEARCH = (-0.060, 0.061, 0.010)  # [m] first look: from, to, by
MARGIN = 0.008  # [m] looked at on both sides of where the first look saw a border
SPACING, SCATTER = 0.0005, 0.0005  # [m] from try to try in x; width of the scatter in x and y
NEAR = 5  # tries around an error that make its share
MOVE_TARGET, AGREE_TARGET = 3.0, 95.0  # [mm], [%]

Outcomes = NDArray[np.bool_]


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


def gripped(error: Array, step: float) -> bool:
    """Whether the grasp succeeds with this error (2,) [m] of the seen place along x and y."""
    started = started_scene(TrialSettings(step=step))
    scene = MisplacedScene(started.place(Placement()), np.array([*error, 0.0]))
    return Sequencer(scene, started.strategy).run().gripped


def outcomes(errors: Array, step: float) -> Outcomes:
    """`gripped` of every error (n, 2) [m]."""
    return np.array([gripped(error, step) for error in errors])


def changes(errors: Array, success: Outcomes) -> list[tuple[float, float]]:
    """Pairs of neighbouring errors (n,) between which the outcome changes."""
    pairs = zip(errors[:-1], errors[1:], success[:-1], success[1:], strict=True)
    return [(float(a), float(b)) for a, b, first, second in pairs if first != second]


def tries(low: float, high: float) -> Array:
    """Scattered errors (n, 2) [m] in x and y, with x in order between two errors along x."""
    along = np.arange(low, high + 0.5 * SPACING, SPACING)
    scatter = np.random.default_rng(0).uniform(-0.5, 0.5, (len(along), 2)) * SCATTER
    return scatter + np.stack([along, np.zeros_like(along)], axis=1)


def shares(success: Outcomes) -> Array:
    """Share of successes around each try but the outermost: (n - NEAR + 1,)."""
    return np.convolve(success, np.full(NEAR, 1.0 / NEAR), "valid")


def middles(errors: Array) -> Array:
    """Errors along x [m] that belong to `shares` of tries (n, 2)."""
    return errors[NEAR // 2 : len(errors) - NEAR // 2, 0]


def moved(errors: Array, before: Array, after: Array, places: Array) -> float:
    """How far from the next border [m] the likely outcome changes from one row of shares to
    another, at the farthest; 0 where it does not. All (n,), and places of the borders (k,) [m].
    """
    changed = errors[(before > 0.5) != (after > 0.5)]
    return float(np.max(distance(changed, places), initial=0.0))


def distance(errors: Array, places: Array) -> Array:
    """Distance (n,) [m] of errors (n,) from the next place of a border (k,)."""
    return np.min(np.abs(errors[:, None] - places), axis=1)


def borders(errors: Array, success: Outcomes) -> Array:
    """Errors along x (k,) [m] at which the share of successes of tries (n, 2) crosses one half."""
    return np.array([0.5 * (a + b) for a, b in changes(middles(errors), shares(success) > 0.5)])


def rows(small: bool) -> list[dict[str, Any]]:
    """How far the borders move from 1 ms, and how often outcomes agree away from them."""
    coarse = np.arange(*SEARCH)
    first_look = outcomes(np.stack([coarse, np.zeros_like(coarse)], axis=1), FINEST)
    found = changes(coarse, first_look)[: 1 if small else None]
    errors = [tries(low - MARGIN, high + MARGIN) for low, high in found]
    truth = [outcomes(some, FINEST) for some in errors]
    places = np.concatenate([borders(*pair) for pair in zip(errors, truth, strict=True)])
    rows = _borders(places, truth)
    for step in STEPS:
        rows += _compared(step, errors, truth, places)
    return rows


def _borders(places: Array, truth: list[Outcomes]) -> list[dict[str, Any]]:
    share = np.concatenate([shares(success) for success in truth])
    unsure = SPACING * np.count_nonzero((share >= 0.3) & (share <= 0.7))
    name = "of success, 1 ms: error of the seen place"
    return [
        *(stated(f"border {k} {name}", 1e3 * place, "mm") for k, place in enumerate(places)),
        stated("errors of the seen place where 30 to 70 % succeed, 1 ms", 1e3 * unsure, "mm"),
    ]


def _compared(
    step: float, errors: list[Array], truth: list[Outcomes], places: Array
) -> list[dict[str, Any]]:
    other = [outcomes(some, step) for some in errors]
    farthest = max(
        moved(middles(some), shares(a), shares(b), places)
        for some, a, b in zip(errors, truth, other, strict=True)
    )
    count = sum(len(borders(*pair)) for pair in zip(errors, other, strict=True))
    far = distance(np.concatenate(errors)[:, 0], places) > 1e-3 * MOVE_TARGET
    agree = (np.concatenate(truth) == np.concatenate(other))[far]
    name = f"outcome of a grasp, {1e3 * step:g} ms against 1 ms"
    return [
        stated(f"{name}: borders of success", count, ""),
        at_most(f"{name}: border moves", 1e3 * farthest, "mm", MOVE_TARGET),
        at_least(f"{name}: agree beyond 3 mm", 100 * float(agree.mean()), "%", AGREE_TARGET),
        stated(f"{name}: tries beyond 3 mm", len(agree), ""),
    ]
