"""Result of `learn` as JSON, `softhand-learned/1`."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np

from model_lab.aliases import Array
from model_lab.learning.learn import Candidate, Learning
from softhand_model.effects.curve import smooth_curve

LEARNED_FORMAT = "softhand-learned/1"
CURVE_POINTS = 41  # of the curve
BAND_SIGMA = 1.96  # sigma


def curve_points(candidate: Candidate) -> list[list[Any]]:
    """[place, value, low, high] along the curve, with its 95 % band; for an axis without order, one
    for each name.
    """
    shape = candidate.shape
    places = np.array(shape.places)
    if not shape.names:
        places = np.linspace(places[0], places[-1], CURVE_POINTS)
    weights = _weights(candidate, places)
    middle = weights @ candidate.values
    reach = BAND_SIGMA * np.sqrt(
        np.maximum(np.sum((weights @ candidate.covariance) * weights, 1), 0.0)
    )
    shown: list[Any] = list(shape.names) or places.tolist()
    rows = zip(shown, middle, middle - reach, middle + reach, strict=True)
    return [[place, *map(float, rest)] for place, *rest in rows]


def _weights(candidate: Candidate, places: Array) -> Array:
    """What each value of the curve counts at places (n, k)."""
    knots = candidate.shape.places
    names = [str(knot) for knot in knots]
    columns = [
        smooth_curve(knots, dict(zip(names, row, strict=True)), places)
        for row in np.eye(len(knots))
    ]
    return np.stack(columns, axis=1)


def learning_json(learning: Learning) -> dict[str, Any]:
    """The dictionary that `learn --json` writes.

    `rmse_after` is the held-out error with all learned curves; `further` has the curves besides the
    first, each with the remaining error after it was added.
    """
    problem = learning.problem
    common = {
        "format": LEARNED_FORMAT,
        "experiment": problem.data.experiment,
        "holdout": problem.data.table.holdout,
        "slips": [asdict(slip) for slip in learning.slips],
        "unit_of_errors": problem.data.unit,
        "rmse_before": learning.base.held_out.rmse,
        "noise_floor": problem.floor.total,
    }
    alternatives = [_alternative(learning, one) for one in learning.others]
    if not learning.curves:
        after = {"rmse_after": learning.base.held_out.rmse, "reason": learning.reason}
        return (
            common
            | {"stage": None, **after, "curve": []}
            | {
                "further": [],
                "alternatives": alternatives,
            }
        )
    first, *others = map(_curve, learning.curves)
    left = [one.scored.held_out.rmse for one in learning.further]
    further = [one | {"rmse_after": error} for one, error in zip(others, left, strict=True)]
    return (
        common
        | first
        | {
            "rmse_after": learning.final.held_out.rmse,
            "further": further,
            "alternatives": alternatives,
        }
    )


def _curve(candidate: Candidate) -> dict[str, Any]:
    shape = candidate.shape
    return {
        "stage": shape.stage,
        "form": shape.form,
        "against": shape.axis,
        "abscissa": shape.abscissa,
        "curve": curve_points(candidate),
        "unit": {"factor": "", "lag": "s"}.get(shape.form, shape.unit),
    }


def _alternative(learning: Learning, candidate: Candidate) -> dict[str, Any]:
    shape = candidate.shape
    return {
        "stage": shape.stage,
        "form": shape.form,
        "against": shape.axis,
        "rmse_after": candidate.scored.held_out.rmse,
        "tied": learning.is_tied(candidate),
    }
