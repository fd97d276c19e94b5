"""Ladder of errors: several models against one measurement set."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from model_lab.aliases import Tell, tell_nobody
from model_lab.comparison.compare import Errors, errors_of
from model_lab.fitting.noise_floor import NoiseFloor
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.measurements.units import display_of
from model_lab.report.text import text_table
from softhand_model.model_file import Model

FORMAT = "softhand-ladder/1"
BAR = 40  # characters of the largest error


@dataclass(frozen=True)
class Rung:
    """One model and its errors."""

    name: str
    errors: Errors


@dataclass(frozen=True)
class Ladder:
    """Models in the order in which they were named; floor: as the best of them shows it."""

    data: MeasurementSet
    rungs: tuple[Rung, ...]

    @property
    def best(self) -> Rung:
        """The model with the smallest held-out error."""
        return min(self.rungs, key=lambda rung: rung.errors.held_out.rmse)

    @property
    def floor(self) -> NoiseFloor:
        """The noise floor."""
        return self.best.errors.floor


def compare_models(
    data: MeasurementSet, models: Mapping[str, Model], tell: Tell = tell_nobody
) -> Ladder:
    """Compare each of the models (by name) with the set.

    Raises ValueError for data that a model cannot use, naming the model.
    """
    rungs = []
    for number, (name, model) in enumerate(models.items(), 1):
        tell(name, number, len(models))
        try:
            rungs.append(Rung(name, errors_of(data, model)))
        except ValueError as reason:
            raise ValueError(f"model {name}: {reason}") from reason
    return Ladder(data, tuple(rungs))


def ladder_text(ladder: Ladder) -> str:
    """What `ladder` prints."""
    display, floor = display_of(ladder.data.unit), ladder.floor
    largest = max(rung.errors.held_out.rmse for rung in ladder.rungs)
    unit = f"[{display.unit}]"
    rows = [["model", f"held out {unit}", "fit", f"all data {unit}", "over floor", ""]]
    for rung in ladder.rungs:
        held_out, as_is = rung.errors.held_out, rung.errors.as_is
        rows.append(
            [
                rung.name,
                display.number(held_out.rmse),
                f"{held_out.fit:.1f} %",
                display.number(as_is.rmse),
                f"{held_out.rmse / floor.total:.1f}",
                _bar(held_out.rmse / largest),
            ]
        )
    rows.append(
        ["noise floor", display.number(floor.total), "", "", "", _bar(floor.total / largest)]
    )
    title = ladder.data.title or ladder.data.experiment
    return f"{title}\n\n{text_table(rows)}\n"


def ladder_json(ladder: Ladder) -> dict[str, Any]:
    """What `ladder --json` writes; all in SI units."""
    floor = ladder.floor
    return {
        "format": FORMAT,
        "experiment": ladder.data.experiment,
        "unit": ladder.data.unit,
        "holdout": ladder.best.errors.holdout,
        "noise_floor": floor.total,
        "noise_floor_upper": floor.upper,
        "noise_floor_parts": {"within": floor.within, "between": floor.between},
        "best": ladder.best.name,
        "models": [_rung_json(rung) for rung in ladder.rungs],
    }


def _bar(share: float) -> str:
    return "#" * max(round(BAR * share), 1)


def _rung_json(rung: Rung) -> dict[str, Any]:
    errors = rung.errors
    return {
        "model": rung.name,
        "base": errors.model.base,
        "effects": [effect.name for effect in errors.model.effects],
        "calibration": errors.calibration,
        "rmse": errors.as_is.rmse,
        "rmse_heldout": errors.held_out.rmse,
        "fit_percent": errors.as_is.fit,
        "fit_percent_heldout": errors.held_out.fit,
    }
