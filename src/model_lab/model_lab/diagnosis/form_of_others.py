"""Named effects that may stand for no effect of their own, but make up for the form of the equation
of another one: creep that acts on the angle is not quite creep of the modulus, and a gain of the
sensor or its drift mends most of the difference.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from model_lab.aliases import Array
from model_lab.diagnosis.criteria import excess, share_left
from model_lab.diagnosis.search import Scored, score_without
from model_lab.fitting.problem import FitProblem
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.rules import RULES
from softhand_model.effects.hand import HandEffect


def only_mending(problem: FitProblem, base: Scored, final: Scored) -> dict[str, tuple[str, ...]]:
    """For each such effect among those of the final model, the others whose form it may mend.

    Without it the others explain the error up to the form of an equation (`Rules.left_share`; with
    the gains of runs `Rules.form_left`), and it brings little of what all gain (`Rules.form_gain`).
    An effect of temperature or weight, where these differ between runs, is not such a one, nor is
    one of ageing or of one part of a hand: no form of another effect follows them.
    """
    added = [name for name in final.effects if name not in base.effects]
    if len(added) < 2:
        return {}
    classes = problem.classes
    able = [
        name
        for name in added
        if "run_order" not in classes[name].axes and not issubclass(classes[name], HandEffect)
    ]
    mending = [name for name in able if _mends(problem, base, final, name)]
    return {name: tuple(n for n in added if n not in mending) for name in mending}


def _mends(problem: FitProblem, base: Scored, final: Scored, name: str) -> bool:
    without = score_without(problem, final, name)
    gained = without.fit.deviance - final.fit.deviance
    whole = base.fit.deviance - final.fit.deviance
    rules = problem.rules
    if share_left(problem, without, base) > rules.left_share or gained > rules.form_gain * whole:
        return False
    if excess(problem, without) > rules.form_left * excess(problem, base):
        return False
    return not _follows_surroundings(problem, final, without)


def _follows_surroundings(problem: FitProblem, final: Scored, without: Scored) -> bool:
    """Whether what the final model adds to the one without an effect would be another, were all
    runs at one temperature and all specimens mounted alike.
    """
    even = _in_one_place(problem.data)
    if even is problem.data:
        return False
    added, added_even = (
        _predicted(problem, final, data) - _predicted(problem, without, data)
        for data in (problem.data, even)
    )
    moved = float(np.sqrt(np.mean((added_even - added) ** 2)))
    return moved > RULES.form_follows * float(np.std(added))


def _predicted(problem: FitProblem, scored: Scored, data: MeasurementSet) -> Array:
    """Prediction (samples,) of a fitted model for the runs of another set."""
    forward = replace(problem, data=data).likelihood(scored.effects).forward
    fitted = dict(zip(scored.fit.likelihood.names, scored.fit.values.tolist(), strict=True))
    return np.asarray(forward.predict(np.array([[fitted[p.name] for p in forward.parameters]]))[0])


def _in_one_place(data: MeasurementSet) -> MeasurementSet:
    """The set as if all runs had the temperature of the first and all specimens its mount; the set
    itself where they do.
    """
    first = data.runs[0]
    mount = data.specimens[first.specimen].mount
    alike = all(run.temperature == first.temperature for run in data.runs)
    if alike and all(specimen.mount == mount for specimen in data.specimens.values()):
        return data
    mounted = {name: replace(one, mount=mount) for name, one in data.specimens.items()}
    runs = tuple(replace(run, temperature=first.temperature) for run in data.runs)
    return replace(data, specimens=mounted, runs=runs)
