"""Search for effects in a set in whose series of runs something happened: an event, or an effect
with memory?

Events are taken out of the set, which is then searched. A step or drift is not believed if the
model is worse without it. An event is dropped if the effects that are found without it account for
it, or if effects explain the set as it is: effects may make repeats differ depending on earlier
runs (softening, ageing, a drifting sensor).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize_scalar

from model_lab.aliases import Array
from model_lab.diagnosis.judgement import Judgement
from model_lab.diagnosis.result import ADEQUATE, EFFECTS_MISSING
from model_lab.diagnosis.search import Scored, score_base, trial_values, with_trials
from model_lab.fitting.problem import FitProblem
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.series.events import (
    STEP_EVENT,
    STEP_OR_DRIFT,
    Event,
    examine,
    group_of_runs,
    of_the_other,
)
from model_lab.series.lowering import examine_lowering
from model_lab.series.mended import without_events
from model_lab.series.odd_run import error_of_runs, odd_run_slips
from model_lab.series.run_scale import LOAD_SCALE, OUTPUT_SCALE, run_values, within_groups
from model_lab.slips.slip import Slip

OF_ORDER = {"run_order", "session"}  # axes of effects that change from run to run
LOAD_OVER_OUTPUT = (0.2, 1.5)  # of logarithms, by hand: outputs grow by more than the load, or less
LOAD_TRIALS = 10

Pose = Callable[[MeasurementSet], tuple[FitProblem, Sequence[str]]]
"""The fit problem of a set, and the effects of the model that are fitted along."""
Judge = Callable[[FitProblem, Sequence[str]], Judgement]
"""The judgement on the search of a problem."""
Candidates = Callable[[FitProblem], Sequence[str]]
"""Effects that are searched."""


@dataclass(frozen=True)
class Faults:
    """Events in a series of runs, and a slip for each odd run or exchanged pair; if none is
    certain, possible events (`Series.doubted`).
    """

    events: tuple[Event, ...] = ()
    slips: tuple[Slip, ...] = ()
    doubted: Event | None = None


def judged_series(
    data: MeasurementSet, pose: Pose, candidates: Candidates, judge: Judge
) -> tuple[Judgement, Faults]:
    """(judgement on the set without the events in its series, what happened in the series).

    pose: makes the fit problem of a set. candidates: names of effects to search. judge: searches
    and judges a problem.
    """
    problem, given = pose(data)
    base = score_base(problem, given)

    def error_without(events: Sequence[Event]) -> float:
        scored = score_base(*pose(without_events(data, events))) if events else base
        return scored.held_out.rmse

    series = examine_lowering(problem.data, base.fit.residual, problem.floor, error_without)
    found = series.events
    if not found:
        return judge(problem, given), Faults(doubted=series.doubted)
    again = judge(*pose(without_events(data, found)))
    softened = _of_the_load(data, found, pose) if again.verdict != ADEQUATE else ()
    alone = judge(*pose(without_events(data, softened))) if softened else None
    if alone is not None and _is_all(alone, again):
        again, named = alone, softened
    else:
        named = _events_beside(problem, again)
        if named and _places(named) != _places(found):
            again = judge(*pose(without_events(data, named)))
    if named and not _may_explain(problem, base, candidates(problem)):
        return again, _faults(problem, again, named)
    first = judge(problem, given)
    if not named or _explains(first, again, named):
        return first, Faults()
    return again, _faults(problem, again, named)


def _of_the_load(data: MeasurementSet, events: Sequence[Event], pose: Pose) -> tuple[Event, ...]:
    """Steps and drifts of the scale as those of the load, with all their logarithms multiplied by
    what leaves the least error; empty if there are other events. Where outputs are not proportional
    to the pressure, rubber that softens changes their course, too, which a scale does not take out.
    """
    of_scale = all(e.kind in STEP_OR_DRIFT and e.quantity == OUTPUT_SCALE for e in events)
    if data.experiment != "free_bending" or not of_scale:
        return ()

    def loads(share: float) -> tuple[Event, ...]:
        sizes = [float(np.expm1(share * np.log1p(event.size))) for event in events]
        return tuple(
            replace(event, quantity=LOAD_SCALE, size=size)
            for event, size in zip(events, sizes, strict=True)
        )

    def error(share: float) -> float:
        return score_base(*pose(without_events(data, loads(share)))).held_out.rmse

    trials = {"maxiter": LOAD_TRIALS}
    best = minimize_scalar(error, bounds=LOAD_OVER_OUTPUT, method="bounded", options=trials)
    return loads(float(best.x))


def _is_all(alone: Judgement, again: Judgement) -> bool:
    """Whether an event of the load explains a set without any effect, nearly as well as effects do
    beside an event of the scale.
    """
    most = again.problem.rules.explained_error * max(
        again.problem.floor.total, again.named.held_out.rmse
    )
    return alone.verdict == ADEQUATE and alone.named.held_out.rmse <= most


def _places(events: Sequence[Event]) -> list[tuple[str, str]]:
    return sorted((event.kind, event.run) for event in events)


def _events_beside(problem: FitProblem, judged: Judgement) -> tuple[Event, ...]:
    """Events in a set under the model that was found without them; of two repeats of which one is
    odd, the one that the model does not predict.
    """
    residual_of = residual_of_named(problem, judged)
    found = examine(problem.data, residual_of(problem.data), problem.floor.within).events
    return tuple(_the_odd_one(event, problem.data, residual_of) for event in found)


def _the_odd_one(
    event: Event, data: MeasurementSet, residual_of: Callable[[MeasurementSet], Array]
) -> Event:
    if not event.other:
        return event
    errors = [error_of_runs(data, (name,), residual_of) for name in (event.run, event.other)]
    return event if errors[0] >= errors[1] else of_the_other(event, data)


def residual_of_named(problem: FitProblem, judged: Judgement) -> Callable[[MeasurementSet], Array]:
    """Residuals of the named model of a judgement on other sets of the same specimens."""
    fitted = judged.named.fit
    values = dict(zip(fitted.likelihood.names, fitted.values.tolist(), strict=True))

    def residual(data: MeasurementSet) -> Array:
        forward = problem.forward(judged.named.effects, data)
        at = np.array([[values.get(p.name, p.start) for p in forward.parameters]], float)
        return np.asarray(forward.measured - forward.predict(at)[0])

    return residual


def _faults(problem: FitProblem, judged: Judgement, events: Sequence[Event]) -> Faults:
    typical = max(judged.named.fit.rmse, judged.problem.floor.total)
    residual_of = residual_of_named(problem, judged)
    return Faults(*odd_run_slips(problem.data, events, residual_of, typical))


def _may_explain(problem: FitProblem, base: Scored, effects: Sequence[str]) -> bool:
    """Whether an effect at a usual value lets repeats differ by as large a share of what they do as
    an effect must remove of an error.
    """
    table, group = problem.data.table, group_of_runs(problem.data)
    predicted = table.value - base.fit.residual

    def differences(measured: Array) -> Array:
        found = run_values(table, measured, predicted, problem.data.of_hand)
        values = [one.values for one in found]
        return np.linalg.norm(within_groups(np.stack(values), group), axis=1)

    least = problem.rules.removed_share * differences(table.value)
    for name in effects:
        likelihood = problem.likelihood((*base.effects, name))
        lanes = with_trials(likelihood, base.fit, name, trial_values(problem.classes[name]))
        for residual in likelihood.residuals(lanes):
            made = predicted + base.fit.residual - residual
            if np.all(np.isfinite(made)) and np.any(differences(made) >= least):
                return True
    return False


def _explains(first: Judgement, again: Judgement, events: Sequence[Event]) -> bool:
    """Whether effects explain a set as it is: to about the floor, or nearly as well as others do
    without the events, unless the runs are strong evidence for these: effects have as many
    parameters as an event at least. Where events concern the first run of a specimen, which effects
    of first loading change whatever their equations, less than half of the error is reason enough.
    A drift does not explain a step that leaves less.
    """
    if first.verdict != EFFECTS_MISSING:
        return False
    rules, data = first.problem.rules, first.problem.data
    error, without = first.named.held_out.rmse, again.named.held_out.rmse
    drifts = {name for name in first.added if OF_ORDER & set(first.problem.classes[name].axes)}
    beside = set(first.added) - drifts <= set(again.added)
    if drifts and beside and all(event.kind == STEP_EVENT for event in events):
        return error < without
    if all(_of_first_loading(event, data) for event in events):
        return without > rules.removed_share * error
    evidence = 2.0 * len(data.runs) * np.log(error / without)  # each run counts once
    most = rules.explained_error * max(again.problem.floor.total, without)
    return bool(error <= most and evidence <= rules.event_evidence)


def _of_first_loading(event: Event, data: MeasurementSet) -> bool:
    """Whether an event is about the first run of a specimen, or lies just after it."""
    first: dict[str, str] = {}
    for run in data.runs:
        first.setdefault(run.specimen, run.name)
    return not {event.run, event.before, event.other}.isdisjoint(first.values())
