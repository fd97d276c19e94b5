"""The force at which a held cylinder slides (Fig. 7.10): predicted and measured, in units of the
measurement's uncertainty.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from softhand_common.documents.output_file import write_file
from thesis.chapter_3_and_5.disturbance import (
    DIRECTIONS,
    HAND,
    JUDGED,
    LARGEST,
    OUTER_PALM,
    PLACE,
    pushed,
    sliding_force,
)
from thesis.chapter_3_and_5.held_cylinder import Grasp, HeldCylinder
from thesis.chapter_7.candidates import Candidate
from thesis.chapter_7.kept import kept
from thesis.frame import Array

MEASURED, UNCERTAINTY = 7.0, 1.0  # [N]: 6 to 8 N, taken as one standard deviation to either side
BASE = "base"


def forces(
    folder: Path,
    rate: float,
    pressure: float = JUDGED,
    segments: int = 5,
    effect: tuple[Candidate, float] | None = None,
) -> Array:
    """Forces (directions,) [N] at which the cylinder has slid by 3 mm, `LARGEST` where it has not,
    at a gauge pressure [Pa] of fingers, thumb and inner palm; rate [N/s]: by which forces grow.

    effect: a candidate and its value. What has been computed is kept in the folder.
    """
    name = f"{pressure / 1e3:g}kPa_{segments}_{rate:g}"
    model = BASE
    if effect is not None:
        candidate, value = effect
        name += f"_{candidate.label.replace(' ', '_')}_{value:.4g}"
        model = str(folder / f"{name}.yaml")
        lines = ["format: softhand-model/1", "base: pneuflex", "effects:", candidate.entry(value)]
        write_file(Path(model), "\n".join(lines) + "\n")

    def push() -> list[float]:
        """In each direction."""
        grasp = Grasp(HAND, PLACE, (*3 * (pressure,), OUTER_PALM * pressure), segments, model)
        found = []
        with HeldCylinder(grasp) as held:
            saved = held.simulation.save()
            for direction in DIRECTIONS.values():
                held.simulation.restore(saved)
                found.append(min(sliding_force(pushed(held, direction, rate)), LARGEST))
        return found

    return np.array(kept(folder / f"{name}.json", push))


def z_values(predicted: Array, uncertainty: float) -> Array:
    """How far predicted forces [N] are above the measured one, over the root of both variances;
    uncertainty [N]: one standard deviation of the prediction.

    >>> z_values(np.array([7.0, 9.0]), 0.0).tolist()
    [0.0, 2.0]
    """
    return np.asarray((predicted - MEASURED) / np.hypot(UNCERTAINTY, uncertainty))


def misfit(predicted: Mapping[float, Array], uncertainty: float) -> tuple[float, float]:
    """Least sum of squared z-values over the pressure, which the thesis does not give, and that
    pressure [Pa]; predicted: forces (directions,) [N] by pressure [Pa], linear between them.

    >>> forces = {40e3: np.array([5.0, 5.0]), 60e3: np.array([9.0, 9.0])}
    >>> misfit(forces, 0.0)
    (0.0, 50000.0)
    """
    known = sorted(predicted)
    fine = np.linspace(known[0], known[-1], 201)
    table = np.array([predicted[pressure] for pressure in known])
    between = np.stack([np.interp(fine, known, column) for column in table.T], axis=1)
    squares = np.sum(z_values(between, uncertainty) ** 2, axis=1)
    best = int(np.argmin(squares))
    return float(squares[best]), float(fine[best])
