"""Runs of specimens that were new, though the set does not say so (`virgin: true`).

Rubber softens below its largest stretch so far, which the lab carries from run to run of a
specimen. Where each run was of a new specimen, that is wrong, and no effect explains the set.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from model_lab.diagnosis.result import EFFECTS_MISSING, SLIP, UNEXPLAINED, Diagnosis
from model_lab.diagnosis.search import Scored, score_base, score_with
from model_lab.fitting.problem import pose_problem
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.measurements.preprocess import thinned
from model_lab.rules import RULES
from model_lab.slips.columns import one_line
from model_lab.slips.slip import Slip
from softhand_model.effects import Effect
from softhand_model.model_file import Model

NEW_SPECIMENS = "virgin"  # name of the slip


def as_new(
    data: MeasurementSet, found: Diagnosis, model: Model, classes: Mapping[str, type[Effect]]
) -> MeasurementSet | None:
    """The set in which the specimen of each run is new; None unless nothing explains the set as
    stated, and an effect that remembers the largest stretch removes most error of the new one.
    """
    specimens = [run.specimen for run in data.runs]
    if (
        (found.verdict_mended or found.verdict) != UNEXPLAINED
        or len(set(specimens)) == len(specimens)
        or any(run.virgin for run in data.runs)
        or not data.has_time
    ):
        return None
    new = replace(data, runs=tuple(replace(run, virgin=True) for run in data.runs))
    problem, given = pose_problem(thinned(new), model, classes)
    base = score_base(problem, [effect.name for effect in given])
    added = {effect.name for effect in given}
    tried = [
        score_with(problem, base, name)
        for name, effect in problem.classes.items()
        if _remembers(effect) and data.experiment in effect.experiments and name not in added
    ]
    enough = RULES.slip_share * base.held_out.rmse
    explained = any(isinstance(one, Scored) and one.held_out.rmse <= enough for one in tried)
    return new if explained else None


def with_new_specimens(
    data: MeasurementSet,
    found: Diagnosis,
    renewed: Diagnosis,
    classes: Mapping[str, type[Effect]],
) -> Diagnosis | None:
    """The diagnosis of the set with new specimens, with the slip that says so; None if that is a
    guess, names no effect that remembers the largest stretch, or leaves much. found, renewed:
    diagnoses of the set as stated and of `as_new`.
    """
    softening = [one.name for one in renewed.effects if _remembers(classes.get(one.name))]
    little = renewed.rmse_after <= RULES.slip_share * found.rmse_before
    if renewed.verdict != EFFECTS_MISSING or renewed.guess or not softening or not little:
        return None
    slip = Slip(
        NEW_SPECIMENS,
        "virgin",
        "false",
        "true in each run (its specimen was new)",
        found.rmse_before,
        renewed.rmse_after,
        one_line({"runs": {run.name: {"virgin": True} for run in data.runs}}),
        softening[0],
    )
    return replace(renewed, verdict=SLIP, slips=(slip,), verdict_mended=renewed.verdict)


def _remembers(effect: type[Effect] | None) -> bool:
    """Whether an effect remembers what belongs to the specimen, such as its largest stretch."""
    return bool(getattr(effect, "largest", {}))
