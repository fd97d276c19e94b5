"""One run of a hand that does not fit with the others, such as the file of another pose.

Repeats show an odd run by themselves (`series.events`). Where a run has none, it is odd if the
others are explained without it, and if it then differs from their model by far more than they do.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from model_lab.diagnosis.criteria import has_few_folds, is_noise
from model_lab.diagnosis.judgement import Judgement
from model_lab.diagnosis.result import UNEXPLAINED
from model_lab.diagnosis.search import Scored, score_base
from model_lab.diagnosis.suspect_series import Faults, Judge, Pose, residual_of_named
from model_lab.fitting.problem import FitProblem
from model_lab.measurements.hands import GRASP
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.series.odd_run import error_of_runs, odd_run_slip

RUNS_TRIED = 2


def without_odd_run(
    data: MeasurementSet, judged: Judgement, pose: Pose, judge: Judge
) -> tuple[Judgement, Faults] | None:
    """(judgement on the set without the run that does not fit with the others, a slip that says
    so); None if there is none. Contacts let grasps differ anyway.

    judged: judgement on the set as it is. pose, judge: as of `judged_series`.
    """
    if not data.of_hand or data.experiment == GRASP or _is_explained(judged):
        return None
    for name, model in _most_unlike(judged)[:RUNS_TRIED]:
        others = replace(data, runs=tuple(run for run in data.runs if run.name != name))
        problem, given = pose(others)
        if has_few_folds(problem) or not is_noise(problem, score_base(problem, model.effects)):
            continue
        again = judge(problem, given)
        residual_of = residual_of_named(problem, again)
        usual = max(again.named.fit.rmse, again.problem.floor.total)
        far = problem.rules.odd_run_error * usual
        if _is_explained(again) and error_of_runs(data, (name,), residual_of) >= far:
            return again, Faults(slips=(odd_run_slip(data, name, residual_of, usual),))
    return None


def _is_explained(judged: Judgement) -> bool:
    return judged.verdict != UNEXPLAINED and is_noise(judged.problem, judged.named)


def _most_unlike(judged: Judgement) -> list[tuple[str, Scored]]:
    """Names of runs that one model or another predicts worst, each with the model that predicts the
    others best; the run first without which least is left.
    """
    selection, problem = judged.selection, judged.problem
    models = (selection.base, *(one for one in selection.singles if one.plausible), selection.final)
    found: dict[str, tuple[float, Scored]] = {}
    for model in models:
        name, left = _worst(problem, model)
        if name not in found or left < found[name][0]:
            found[name] = left, model
    order = sorted(found, key=lambda name: found[name][0])
    return [(name, found[name][1]) for name in order]


def _worst(problem: FitProblem, model: Scored) -> tuple[str, float]:
    """(name of the run that is predicted worst, root mean square error of the others)."""
    table, runs = problem.data.table, problem.data.runs
    squares = np.bincount(table.run, model.fit.residual**2, len(runs))
    worst = int(np.argmax(squares / np.bincount(table.run, minlength=len(runs))))
    others = table.run != worst
    return runs[worst].name, float(np.sqrt(np.mean(model.fit.residual[others] ** 2)))
