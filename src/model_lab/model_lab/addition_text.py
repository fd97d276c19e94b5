"""What `add` says of the effect that it added."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

from model_lab.add import Addition
from model_lab.display import display_of
from model_lab.model_writing import NOT_PHYSICS
from model_lab.report.sentence import effect_words

FORMAT = "softhand-addition/1"


def addition_text(addition: Addition, path: Path) -> str:
    """What is printed."""
    display = display_of(addition.question.data.unit)
    before, after = addition.before.held_out.rmse, addition.after.held_out.rmse
    floor = display.shown(addition.question.floor.total)
    if after < before:
        error = (
            f"The held-out error falls from {display.shown(before)} to {display.shown(after)}; "
            f"the noise floor is {floor}."
        )
    else:
        error = (
            f"The held-out error does not fall: {display.shown(before)} before, "
            f"{display.shown(after)} after; the noise floor is {floor}."
        )
    return f"{path}: added {_added(addition)}\n{error}\n"


def _added(addition: Addition) -> str:
    """The effect with its values; of a generic term they say nothing."""
    name = addition.effect.name
    if addition.question.classes[name].physical:
        return effect_words(addition.effect)
    return f"{name}, {NOT_PHYSICS}: it says how far the model is off, not why"


def addition_json(addition: Addition, path: str) -> dict[str, Any]:
    """What `--json` writes; all in SI units."""
    return {
        "format": FORMAT,
        "model": path,
        "effect": asdict(addition.effect),
        "physical": addition.question.classes[addition.effect.name].physical,
        "calibration": addition.model.calibration,
        "rmse_before": addition.before.held_out.rmse,
        "rmse_after": addition.after.held_out.rmse,
        "noise_floor": addition.question.floor.total,
        "unit": addition.question.data.unit,
    }
