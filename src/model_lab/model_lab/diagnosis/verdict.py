"""Verdict: the model is good enough, what is missing is named, or nothing known explains it."""

from __future__ import annotations

from collections.abc import Sequence
from math import isclose

from model_lab.diagnosis.black_boxes import BlackBox
from model_lab.diagnosis.errors import (
    NEAR_FLOOR,
    OF_ANOTHER_FORM,
    SHAPE_MARGIN,
    STILL_NEAR,
    SURE,
    beyond_repeats,
    error_of,
    excess,
    foretells,
    has_few_folds,
    is_noise,
    material,
    shape_error,
)
from model_lab.diagnosis.result import ADEQUATE, EFFECTS_MISSING, UNEXPLAINED, estimate
from model_lab.diagnosis.search import Scored
from model_lab.diagnosis.selection import Selection
from model_lab.fitting.noise_floor import SPLINE
from model_lab.fitting.problem import FitProblem
from model_lab.localisation.axes import axes_of
from model_lab.localisation.localise import Localisation
from model_lab.measurements.measurement_set import MeasurementSet
from softhand_model.effects import Effect

LEFT_OVER_OF_KIND = 0.4  # as OF_ANOTHER_FORM, where memory has the same part in rest and effect
LEFT_OVER_MENDED = 0.45  # the same where a black box of its kind explains the rest
MERE_REST = 0.2  # the same whatever the calibration
BLACK_BOX_MARGIN = 0.85  # held-out error of a black box over the model's, below which it knows more
BLACK_BOX_FAR = 0.65  # the same where the model is within the floor
BEYOND_SPLINES = 2.0  # held-out error over the floor of splines that is no noise they have missed
SESSION = ("time_in_run", "run_order")  # what no effect depends on by itself


def verdict_of(problem: FitProblem, selection: Selection, black_boxes: Sequence[BlackBox]) -> str:
    """The verdict on a model after the search, beside what black boxes make of the rest."""
    base, final = selection.base, selection.final
    if final is base:
        return UNEXPLAINED if _fails(problem, base, black_boxes) else ADEQUATE
    explained = is_noise(problem, final) or _another_form(problem, base, final, black_boxes)
    if has_few_folds(problem):  # the error is that of the fit
        explained = explained and foretells(problem, final, base)
    return EFFECTS_MISSING if explained else UNEXPLAINED


def _another_form(
    problem: FitProblem, base: Scored, final: Scored, black_boxes: Sequence[BlackBox]
) -> bool:
    """Whether effects explain the error but for what another equation for them would change.

    That is little; or somewhat more, if a black box that remembers, or not, as they do, takes it
    down to the floor.
    """
    floor = problem.floor.total
    share = excess(problem, final) / excess(problem, base)
    error = error_of(problem, final)
    if share <= MERE_REST and error <= STILL_NEAR * floor:
        return True
    if error > STILL_NEAR * floor or _at_a_bound(problem, final):
        return False
    if _of_the_session(problem, final, black_boxes):
        return False
    remembers = any(problem.classes[name].has_memory for name in final.effects)
    if not black_boxes or black_boxes[0].remembers != remembers:
        return share <= OF_ANOTHER_FORM
    mended = black_boxes[0].rmse <= NEAR_FLOOR * floor
    return share <= (LEFT_OVER_MENDED if mended else LEFT_OVER_OF_KIND)


def _at_a_bound(problem: FitProblem, scored: Scored) -> bool:
    """Whether a parameter lies on a bound, or the interval of an effect's reaches one: for all that
    the data tell it would go on beyond.

    A modulus at its upper one is none beside a rubber that relaxes: it stands for the stress that
    relaxes too slowly for these runs, which an equation with another course of time would have.
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
    """Whether what is left goes with the time of a run or of the session, and little beside: no
    other equation of an effect that knows nothing of them would take it.
    """
    if not black_boxes or black_boxes[0].name not in SESSION:
        return False
    best = black_boxes[0].rmse
    return best <= max(NEAR_FLOOR * problem.floor.total, BLACK_BOX_FAR * error_of(problem, final))


def _fails(problem: FitProblem, scored: Scored, black_boxes: Sequence[BlackBox]) -> bool:
    """Whether the error is beyond the floor for certain: by repeats, or as a black box shows.

    A floor by splines is not certain: they take noise that is alike in neighbouring samples for the
    course. A black box that is far better counts even where repeats scatter as much as the model
    errs.
    """
    floor = problem.floor.total
    if scored.held_out.rmse <= floor:
        return False
    far = bool(black_boxes) and black_boxes[0].rmse < BLACK_BOX_FAR * scored.held_out.rmse
    if far and not has_few_folds(problem):
        return True
    if not material(problem, scored):
        return False
    if problem.floor.gain_known:
        lost = len(scored.fit.values) / max(len(problem.data.runs) - len(scored.fit.values), 1)
        return beyond_repeats(problem, scored.held_out.residual, lost) < SURE
    seen = any(box.rmse <= BLACK_BOX_MARGIN * scored.held_out.rmse for box in black_boxes[:1])
    near = problem.floor.source == SPLINE and scored.held_out.rmse < BEYOND_SPLINES * floor
    return (seen or not near) and shape_error(problem, scored) > SHAPE_MARGIN * floor


def depends_on(
    data: MeasurementSet,
    final: Scored,
    black_boxes: Sequence[BlackBox],
    localised: Localisation,
) -> tuple[str, ...]:
    """What the rest varies with: the black boxes that beat the model, best first; else the axes
    against which the model fails, or the one that comes nearest to that.
    """
    varied = {axis.name for axis in axes_of(data)}
    beaten = [
        black_box.against
        for black_box in black_boxes
        if black_box.rmse < BLACK_BOX_MARGIN * final.held_out.rmse and black_box.against in varied
    ]
    failing = localised.failures or localised.axes[:1]
    return tuple(dict.fromkeys(beaten or [axis.against for axis in failing]))[:3]
