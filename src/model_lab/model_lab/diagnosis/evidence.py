"""Evidence for a verdict: numbers without units, computed from the results of the search."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from model_lab.diagnosis.black_boxes import BlackBox
from model_lab.diagnosis.criteria import error_of, share_left
from model_lab.diagnosis.forward_selection import criterion
from model_lab.diagnosis.result import calibration_at_bound
from model_lab.diagnosis.search import Scored
from model_lab.diagnosis.selection import Selection
from model_lab.fitting.problem import FitProblem
from model_lab.measurements.sample_table import WHOLE_PROTOCOLS
from softhand_model.effects import Parameter

LARGEST_LOGARITHM = 5.0  # natural logarithms of ratios are cut off here
DIGITS = 4


def evidence_of(
    problem: FitProblem, selection: Selection, black_boxes: Sequence[BlackBox], notices: int = 0
) -> dict[str, float]:
    """Evidence for a verdict: numbers by name. Ratios are given as natural logarithms, cut off at
    LARGEST_LOGARITHM.

    The final model is the one with the effects that were found, whether they count as an
    explanation or not. The rival is the best model with as many effects that is not the final one
    and not tied with it. notices: number of notices.
    """
    base, final, floor = selection.base, selection.final, problem.floor.total
    rival, best = _rival(selection), black_boxes[0].rmse if black_boxes else base.held_out.rmse
    table = problem.data.table
    fold_ratio = final.held_out.mean_square / np.maximum(base.held_out.mean_square, 1e-300)
    size = float(np.sqrt(np.mean(problem.data.table.value**2)))
    found = {
        "before": _log(error_of(problem, base), floor),
        "size": _log(error_of(problem, base), size),
        "after": _log(error_of(problem, final), floor),
        "left": 1.0 if final is base else share_left(problem, final, base),
        "effects": len(final.effects) - len(base.effects),
        "ties": float(np.mean([len(names) for names in selection.ties] or [0])),
        "proof": _log(_weakest(selection), selection.threshold),
        "margin": _margin(base, final, rival),
        "lead": _log(rival.held_out.rmse, final.held_out.rmse) if rival else LARGEST_LOGARITHM,
        "folds_helped": float(np.mean(fold_ratio < 1.0)),
        "worst_fold": _log(float(np.max(fold_ratio)), 1.0),
        "black_box": _log(best, final.held_out.rmse),
        "black_box_floor": _log(best, floor),
        "single": min((_log(error_of(problem, s), floor) for s in selection.singles), default=0.0),
        "known": _known(problem, base, final),
        "unusual": _unusual(problem, final),
        "candidates": float(np.log1p(len(selection.singles))),
        "proven": float(np.log1p(len(selection.proven))),
        "folds": float(np.log(len(table.folds))),
        "runs": float(np.log(len(problem.data.runs))),
        "samples": float(np.log(table.samples)),
        "by_protocols": float(table.holdout == WHOLE_PROTOCOLS),
        "repeats": float(problem.floor.gain_known),
        "notices": float(notices),
        "base_at_bound": float(bool(calibration_at_bound(base))),
        "at_bound": float(bool(calibration_at_bound(final))),
    }
    return {name: round(float(value), DIGITS) for name, value in found.items()}


def _log(value: float, over: float) -> float:
    """Logarithm of a ratio, cut off at LARGEST_LOGARITHM."""
    ratio = np.log(max(value, 1e-300)) - np.log(max(over, 1e-300))
    return float(np.clip(ratio, -LARGEST_LOGARITHM, LARGEST_LOGARITHM))


def _weakest(selection: Selection) -> float:
    """Fall of the deviance by the last effect of the final model; by the best single without."""
    if selection.final is not selection.base:
        return selection.final.improvement
    return max((scored.improvement for scored in selection.singles), default=0.0)


def _rival(selection: Selection) -> Scored | None:
    """The best model of the same size that is neither the final one nor tied with it."""
    base, final = selection.base, selection.final
    added = [name for name in final.effects if name not in base.effects]
    groups = [{name, *ties} for name, ties in zip(added, selection.ties, strict=False)]
    same_size: Sequence[Scored] = selection.singles
    if len(added) > 1:
        same_size = selection.forward.sizes[len(added) - 1]
    others = [s for s in same_size if not all(group & set(s.effects) for group in groups)]
    return min(others, key=criterion, default=None) if added else None


def _margin(base: Scored, final: Scored, rival: Scored | None) -> float:
    """Share of what the final model gains over the base that its rival misses, 0 to 1."""
    gained = criterion(base) - criterion(final)
    if rival is None or gained <= 0.0:
        return 1.0
    return float(np.clip((criterion(rival) - criterion(final)) / gained, 0.0, 1.0))


def _known(problem: FitProblem, base: Scored, final: Scored) -> float:
    """Logarithm of the distance from no effect over the standard error, of the least known effect
    by its best known parameter.
    """
    scales, spread = final.fit.likelihood.scales, np.sqrt(np.diag(final.fit.covariance))
    best: dict[str, float] = {}
    for effect, index, parameter in _parameters(problem, final):
        if effect not in base.effects:
            distance = abs(final.fit.values[index] - (parameter.neutral or 0.0))
            size = 1.0 if scales.logarithmic[index] else distance
            best[effect] = max(best.get(effect, -LARGEST_LOGARITHM), _log(size, spread[index]))
    return min(best.values(), default=LARGEST_LOGARITHM)


def _unusual(problem: FitProblem, final: Scored) -> int:
    """Number of parameters of effects that lie outside of their typical ranges."""
    count = 0
    for _, index, parameter in _parameters(problem, final):
        low, high = parameter.typical or (parameter.low, parameter.high)
        count += not low <= final.fit.values[index] <= high
    return count


def _parameters(problem: FitProblem, scored: Scored) -> Iterator[tuple[str, int, Parameter]]:
    """Effects of a model with their parameters and where these stand in its fit."""
    place = {name: index for index, name in enumerate(scored.fit.likelihood.names)}
    for effect in scored.effects:
        for parameter in problem.classes[effect].parameters:
            yield effect, place[f"{effect}.{parameter.name}"], parameter
