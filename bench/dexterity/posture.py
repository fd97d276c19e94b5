"""Posture against actuation: the analysis on made-up postures, then the criteria of the experiment.

The experiment is judged as `python -m thesis run posture` has left it in out/thesis.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from bench.grasps.maps import rows
from bench.row import at_least
from thesis.chapter_8.posture_variance import INTERACTION, LINEAR, NONLINEAR, GraspPostures

TAKES = "half a minute"
KINDS = (LINEAR, NONLINEAR, INTERACTION)
SETS, GRASPS = 50, 30  # made-up sets of a kind, and grasps in each
RIGHT = 0.9  # of the sets of a kind, at least: tests at a level of 5 % err
RESAMPLES = 500
CHANNELS, COORDINATES = 4, 15
NOISE = 5e-4  # of a trial [m]


def run() -> list[dict[str, Any]]:
    """A row per kind: share of the sets that are classified correctly; then a row per criterion."""
    told = [
        at_least(
            f"made-up postures, {kind}: told",
            float(np.mean([made_up(kind, seed).kind == kind for seed in range(SETS)])),
            "",
            RIGHT,
        )
        for kind in KINDS
    ]
    return told + rows("posture")


def made_up(kind: str, seed: int, count: int = GRASPS, held_noise: float = NOISE) -> GraspPostures:
    """Synthetic postures of a kind: linear in actuation; nonlinear in actuation; or dependent on
    the object as well, whose shape moves the fingertips in directions of its own. `held_noise` [m]
    is the noise of their trials.
    """
    draw = np.random.default_rng([seed, KINDS.index(kind)])
    actuation = draw.uniform(0.0, 1.0, (count, CHANNELS))
    empty = actuation @ draw.normal(0.0, 0.04, (CHANNELS, COORDINATES))
    if kind != LINEAR:
        waves = np.sin(2.5 * actuation @ draw.normal(0.0, 1.0, (CHANNELS, 6)))
        empty = empty + waves @ draw.normal(0.0, 0.01, (6, COORDINATES))
    held = empty
    if kind == INTERACTION:
        shapes = draw.normal(0.0, 1.0, (count, 4))
        held = held + shapes @ draw.normal(0.0, 0.005, (4, COORDINATES))
    size = (2, count, COORDINATES)
    return GraspPostures(
        actuation,
        held + draw.normal(0.0, held_noise, size),
        empty + draw.normal(0.0, NOISE, size),
        RESAMPLES,
        seed,
    )
