"""Criteria by which fitted models are judged, and the verdict that follows from them.

All compare held-out errors with the noise floor, or with those of other models. Their thresholds
are the `Rules` of the problem.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from math import isclose

import numpy as np
from scipy.special import fdtrc

from model_lab.aliases import Array, Mask
from model_lab.diagnosis.black_boxes import BlackBox
from model_lab.diagnosis.result import ADEQUATE, EFFECTS_MISSING, UNEXPLAINED, estimate
from model_lab.diagnosis.search import Scored
from model_lab.fitting.problem import FitProblem
from model_lab.localisation.axes import axes_of
from model_lab.localisation.localise import Localisation
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.measurements.sample_table import BLOCKS
from model_lab.series.within_runs import residual_tests
from softhand_model.effects import Effect
from softhand_model.effects.hand import HandEffect

TIMES_OF_SESSION = ("time_in_run", "run_order")  # black boxes of what no effect depends on


# ---------------------------------------------------------------------- errors
def has_few_folds(problem: FitProblem) -> bool:
    """Whether there are so few folds that held-out errors say little: each fold is then a large
    part of the data.
    """
    return len(problem.data.table.folds) < problem.rules.fewest_folds


def error_of(problem: FitProblem, scored: Scored) -> float:
    """Error by which a model is judged: the held-out root mean square error. If folds are few, it
    is that of the fit to all data where this is smaller: it may be larger, as the fit weighs shapes
    more than sizes.
    """
    held_out = scored.held_out.rmse
    return min(scored.fit.rmse, held_out) if has_few_folds(problem) else held_out


def shape_error(problem: FitProblem, scored: Scored) -> float:
    """The error of `error_of` without the gain of each run, in which runs scatter most."""
    residual = scored.fit.residual if has_few_folds(problem) else scored.held_out.residual
    spectrum = problem.spectrum
    power = spectrum.power(spectrum.coefficients(residual[None]))[0]
    return float(np.sqrt(power[~_gains(problem)].sum() / problem.data.table.samples))


def _gains(problem: FitProblem) -> Mask:
    """Bands (bands,) of the gains of runs: the first of every output."""
    output = problem.spectrum.band_output
    return np.asarray(np.searchsorted(output, output) == np.arange(len(output)))


def excess(problem: FitProblem, scored: Scored) -> float:
    """Root of squared error less squared noise floor, in the SI unit of the outputs; 0 below the
    floor.
    """
    return _beyond(error_of(problem, scored), problem.floor.total)


def _beyond(error: float, floor: float) -> float:
    return float(np.sqrt(max(error**2 - floor**2, 0.0)))


def share_left(problem: FitProblem, after: Scored, before: Scored) -> float:
    """Share of the excess error of the model `before` that remains with the model `after`: computed
    from the whole error and from the error without the gains of runs; the smaller share is
    returned.
    """
    counts = problem.spectrum.counts() * ~_gains(problem)
    shape = float(np.sqrt(counts @ problem.floor.variance / problem.data.table.samples))
    left = [
        (excess(problem, after), excess(problem, before)),
        (_beyond(shape_error(problem, after), shape), _beyond(shape_error(problem, before), shape)),
    ]
    return min(part / whole if whole > 0.0 else 1.0 for part, whole in left)


def beyond_repeats(problem: FitProblem, residual: Array, lost: float = 0.0) -> float:
    """p-value of a residual (samples,) under the hypothesis that it scatters as repeats do: the
    smallest over all bands, and over bands of the same order of all outputs together, times the
    number of tests.

    lost: share by which the mean square of noise is larger in held-out data.
    """
    spectrum, floor = problem.spectrum, problem.floor
    power = spectrum.power(spectrum.coefficients(residual[None]))[0]
    seen = floor.dof > 0.0
    level = (1.0 + lost) * floor.variance[seen]
    counts, dof, power = spectrum.counts()[seen], floor.dof[seen], power[seen]
    chances = [fdtrc(counts, dof, power / counts / level)]
    first = np.searchsorted(spectrum.band_output, spectrum.band_output)
    order = (np.arange(spectrum.band_count) - first)[seen]
    for each in np.unique(order[order > 0]):  # gains of outputs go together: no test of them
        mine = order == each
        if mine.sum() < 2:
            continue
        whole, scatter = counts[mine].sum(), (dof * level)[mine].sum()
        ratio = power[mine].sum() / whole / (scatter / dof[mine].sum())
        chances.append(np.atleast_1d(fdtrc(whole, dof[mine].sum(), ratio)))
    tried = np.concatenate(chances)
    return float(min(np.min(tried) * len(tried), 1.0))


# ---------------------------------------------------------------------- is it noise?
def explains_all(problem: FitProblem, scored: Scored) -> bool:
    """Whether a model predicts held-out data to the noise floor, with no parameter on a bound.

    The search may have rejected such a model by its likelihood, on which an error of whole runs has
    hardly any influence.
    """
    most = problem.rules.material_error * problem.floor.total
    return scored.plausible and scored.held_out.rmse <= most


def material(problem: FitProblem, scored: Scored) -> bool:
    """Whether the error is at least so far above the noise floor that an effect may be missing
    (`Rules.material_error`).
    """
    return error_of(problem, scored) > problem.rules.material_error * problem.floor.total


def is_far(problem: FitProblem, scored: Scored) -> bool:
    """Whether the error is too far above the noise floor for the model to explain the data
    (`Rules.most_explained_error`).
    """
    return error_of(problem, scored) > problem.rules.most_explained_error * problem.floor.total


def is_noise(problem: FitProblem, scored: Scored) -> bool:
    """Whether the remaining error of a model may be noise alone (`Rules.explained_error`). If it is
    not known how much the gain differs between runs, an error that is small without the gains of
    the runs is enough (`Rules.explained_shape_error`).
    """
    rules, floor = problem.rules, problem.floor
    if error_of(problem, scored) <= rules.explained_error * floor.total:
        return True
    if floor.gain_known or problem.data.table.holdout == BLOCKS:  # one run has one gain
        return False
    return shape_error(problem, scored) <= rules.explained_shape_error * floor.total


def leaves_more_than_noise(problem: FitProblem, scored: Scored) -> bool:
    """Whether a model's fit is off by more than repeats scatter, or without any, by more than the
    floor: then its equation is not the one that is hidden, and what would be named in its absence
    may be as right.
    """
    if not problem.floor.gain_known:
        return not is_noise(problem, scored)
    return beyond_repeats(problem, scored.fit.residual) < problem.rules.misfit_p_value


def lowers(problem: FitProblem, after: Scored, before: Scored) -> bool:
    """Whether the error of the model `after`, with or without the gains of runs, is clearly below
    that of `before`.
    """
    least = problem.rules.material_error
    return any(
        error(problem, before) > least * error(problem, after) for error in (error_of, shape_error)
    )


# ---------------------------------------------------------------------- verdict
def verdict_of(
    problem: FitProblem, base: Scored, final: Scored, black_boxes: Sequence[BlackBox]
) -> str:
    """The verdict on a base model: adequate, effects_missing or unexplained.

    final: the model that the search chose, or the base model if the search found nothing.
    black_boxes: fitted to the remaining error of the final model, the best first.
    """
    if final is base:
        return UNEXPLAINED if _fails(problem, base, black_boxes) else ADEQUATE
    explained = is_noise(problem, final) or _of_another_form(problem, base, final, black_boxes)
    if has_few_folds(problem):  # then `explained` is about the fit, not about held-out data
        explained = explained and _predicts(problem, final, base)
    return EFFECTS_MISSING if explained else UNEXPLAINED


def _fails(problem: FitProblem, base: Scored, black_boxes: Sequence[BlackBox]) -> bool:
    """Whether a model is no explanation: its error is larger than repeats scatter beyond chance, or
    so far above the floor that however few repeats there are it cannot be called noise, or a black
    box predicts held-out data better, or even a constant for each output does.
    """
    rules, floor, error = problem.rules, problem.floor.total, base.held_out.rmse
    if error <= floor:
        return False
    best = black_boxes[0].rmse if black_boxes else np.inf
    if best < rules.black_box_much_better * error and not has_few_folds(problem):
        return True
    if not material(problem, base):
        return False
    if not has_few_folds(problem) and (
        is_far(problem, base) or constants_error(problem) < rules.black_box_better * error
    ):
        return True
    if problem.floor.gain_known:
        lost = len(base.fit.values) / max(len(problem.data.runs) - len(base.fit.values), 1)
        return beyond_repeats(problem, base.held_out.residual, lost) < rules.misfit_p_value
    return shape_error(problem, base) > rules.explained_shape_error * floor


def constants_error(problem: FitProblem) -> float:
    """Root mean square error of the mean of each output over the other folds as its prediction."""
    table = problem.data.table
    squares = np.empty(table.samples)
    for output, fold in product(np.unique(table.output), range(len(table.folds))):
        mine, held = table.output == output, table.fold == fold
        mean = np.mean(table.value[mine & ~held])
        squares[mine & held] = (table.value[mine & held] - mean) ** 2
    return float(np.sqrt(np.mean(squares)))


def _predicts(problem: FitProblem, after: Scored, before: Scored) -> bool:
    """Whether effects lower the held-out error too: a drift fitted to a slip in one of two runs
    does not predict the other run. Folds beyond the inputs of the others tell nothing of that.
    """
    rules, floor, inside = problem.rules, problem.floor.total, _inside(problem)
    error, error_before = (
        float(np.sqrt(np.mean(scored.held_out.residual[inside] ** 2))) for scored in (after, before)
    )
    removed = _beyond(error, floor) <= (1.0 - rules.removed_share) * _beyond(error_before, floor)
    return removed and error <= rules.most_explained_error * floor


def _inside(problem: FitProblem) -> Mask:
    """Samples (samples,) of folds whose inputs go hardly beyond those of the others: what begins
    beyond these, such as ballooning, no fit to the others knows.
    """
    data, table = problem.data, problem.data.table
    size = np.abs(np.concatenate([data.driving(run) for run in data.runs]))[table.row]
    largest = np.array([size[table.fold == fold].max() for fold in range(len(table.folds))])
    others = np.array([np.delete(largest, fold).max() for fold in range(len(largest))])
    return np.asarray((largest <= problem.rules.beyond_inputs * others)[table.fold])


def _of_another_form(
    problem: FitProblem, base: Scored, final: Scored, black_boxes: Sequence[BlackBox]
) -> bool:
    """Whether the rest is so small that the effects are right and only their equations differ from
    what the actuator does. Effects of a hand, such as a mass or a tilt, have no other equation.
    """
    rules = problem.rules
    if is_far(problem, final) or _strained(problem, base, final):
        return False
    if excess(problem, final) > (1.0 - rules.removed_share) * excess(problem, base):
        return False
    share = share_left(problem, final, base)
    if share <= rules.left_share_always:
        return True
    if _at_a_bound(problem, final) or _of_the_session(problem, final, black_boxes):
        return False
    added = (problem.classes[name] for name in final.effects if name not in base.effects)
    return share <= rules.left_share and not all(issubclass(one, HandEffect) for one in added)


def _strained(problem: FitProblem, base: Scored, final: Scored) -> bool:
    """Whether effects leave much of the error, in residuals that run on within runs, and need a
    parameter at or beyond the edge of its usual range: they stand in for something else. Of a
    hand at rest, or pressed at constant pressure, runs do not tell whether residuals run on.
    """
    rules, scales = problem.rules, final.fit.likelihood.scales
    if error_of(problem, final) <= rules.rest_error * problem.floor.total:
        return False
    within = residual_tests(problem.data, final.fit.residual)
    if within is None and not problem.data.of_hand:
        return False
    if within is not None and within.autocorrelation[1] < rules.running_residual:
        return False
    at, margin = scales.inward(final.fit.values), rules.limit_distance * scales.width
    ends = [p.typical or (p.low, p.high) for p in final.fit.likelihood.parameters]
    low, high = scales.inward(np.array(ends, float).T)
    edge = (at <= low + margin) | (at >= high - margin)
    added = [name for name in final.effects if name not in base.effects]
    return any(edge[index] for name in added for index in final.parameters_of(name))


def _at_a_bound(problem: FitProblem, scored: Scored) -> bool:
    """Whether a parameter lies on a bound, or the interval of an effect's parameter reaches one:
    the data may want a value beyond it, so the model is doubtful.

    Exception: the modulus at its upper bound together with an effect that relaxes. Stress that
    relaxes more slowly than the runs last looks like a stiffer material.
    """
    relaxes = any(_relaxes(problem.classes[name]) for name in scored.effects)
    for index, parameter in enumerate(scored.fit.likelihood.parameters):
        low, high = estimate(scored, index).interval  # which ends at the bounds
        if parameter.effect and (isclose(low, parameter.low) or isclose(high, parameter.high)):
            return True
        stiff = parameter.name.startswith("modulus_scale") and scored.fit.values[index] > 1.0
        if scored.fit.at_limit[index] and not (relaxes and stiff):
            return True
    return False


def _relaxes(effect: type[Effect]) -> bool:
    return effect.stage == "elastic" and any(p.unit == "s" for p in effect.parameters)


def _of_the_session(problem: FitProblem, final: Scored, black_boxes: Sequence[BlackBox]) -> bool:
    """Whether the rest depends mainly on the time in a run or in the session. Effects that do not
    depend on these would leave it whatever their equations.
    """
    if not black_boxes or black_boxes[0].name not in TIMES_OF_SESSION:
        return False
    rules = problem.rules
    near = rules.explained_error * problem.floor.total
    much_better = rules.black_box_much_better * error_of(problem, final)
    return black_boxes[0].rmse <= max(near, much_better)


def depends_on(
    data: MeasurementSet,
    final: Scored,
    black_boxes: Sequence[BlackBox],
    localised: Localisation,
) -> tuple[str, ...]:
    """Names of at most three axes on which the residual of a model depends.

    These are the axes of the black boxes that predict better than the model, the best first. If
    none does, they are the axes along which the residual varies beyond chance; if it varies along
    none, the first axis.
    """
    varied = {axis.name for axis in axes_of(data)}
    least = final.rules.black_box_better * final.held_out.rmse
    better = [box.against for box in black_boxes if box.rmse < least and box.against in varied]
    failing = localised.failures or localised.axes[:1]
    return tuple(dict.fromkeys(better or [axis.against for axis in failing]))[:3]
