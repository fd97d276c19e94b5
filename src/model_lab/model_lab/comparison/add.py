"""Adding an effect to a model: fitted together with it, and written as a model file."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from model_lab.aliases import Tell, tell_nobody
from model_lab.diagnosis.forward_selection import closer
from model_lab.diagnosis.result import (
    Estimate,
    NamedEffect,
    calibration_of,
    modulus_of,
    named_effect,
)
from model_lab.diagnosis.search import (
    Scored,
    Unseen,
    invisible,
    score_all,
    score_base,
    score_with,
    signature,
    with_trials,
)
from model_lab.experiments.forward import inapplicable
from model_lab.experiments.hand_pose import HAND_WEIGHT, with_weight
from model_lab.fitting.fit import Likelihood, fit
from model_lab.fitting.held_out import hold_out
from model_lab.fitting.problem import FitProblem, pose_problem, with_lower_floor
from model_lab.measurements.measurement_set import MeasurementSet
from softhand_common.documents.output_file import check_new, plain, write_new
from softhand_common.documents.quoted import unknown
from softhand_model.effects import Effect
from softhand_model.effects.hand import HandEffect, at_places
from softhand_model.hand.joint_stiffness import THESIS
from softhand_model.model_file import FORMAT, Model

NOT_PHYSICS = "a generic term, not physics"


@dataclass(frozen=True)
class Addition:
    """One effect added to a model.

    problem: the fit problem. before, after: the fitted models without and with the effect. effect:
    the effect with its fitted parameters. model: the model with the effect, as its file will hold
    it.
    """

    problem: FitProblem
    before: Scored
    after: Scored
    effect: NamedEffect
    model: Model


def add_effect(
    name: str,
    data: MeasurementSet,
    model: Model,
    classes: Mapping[str, type[Effect]],
    tell: Tell = tell_nobody,
) -> Addition:
    """Add an effect to a model: calibration, effects that an earlier fit added, and the new effect
    are fitted together. For a hand, the name of an effect without a place adds it where it leaves
    the smallest held-out error. The `gravity` that every model of a hand has is fitted instead.

    Raises ValueError when the effect is unknown, already there, or cannot be seen in the data.
    """
    if data.of_hand:
        model = with_weight(data, model)
        classes = at_places(data.hand, classes, data.markers)
        name = _at_best_place(name, data, model, classes, tell)
    if name not in classes:
        known = ", ".join(sorted(classes))
        raise ValueError(f"effect: expected one of {known}, got {unknown(name, classes)}")
    there = any(effect.name == name for effect in model.effects)
    fixed_weight = there and data.of_hand and name == HAND_WEIGHT and name not in model.std
    if there and not fixed_weight:
        raise ValueError(f"effect: expected one that the model does not have yet, got {name}")
    reason = None if fixed_weight else inapplicable(classes[name], data, model.base)
    if reason is not None:
        raise ValueError(f"effect: expected one that can act in these data, got {name}: {reason}")
    tell("fitting the model as it is", 1, 2)
    problem, given = pose_problem(data, model, classes)
    tell(f"fitting {name}", 2, 2)
    names = [effect.name for effect in given]
    if fixed_weight:
        before = score_base(problem, names)
        after = _with_freed(problem, before, name)
    else:
        problem, before, after = _before_and_after(problem, names, name)
    named = [named_effect(after, effect) for effect in after.effects]
    kept = tuple(effect for effect in model.effects if effect.name not in after.effects)
    fitted = tuple(_instance(problem, entry) for entry in named)
    std = {
        entry.name: {key: estimate.std for key, estimate in entry.parameters.items()}
        for entry in named
        if problem.classes[entry.name].physical  # a generic term stays as it is from now on
    }
    calibration = _written(calibration_of(after), modulus_of(after, problem.data))
    new = Model(model.base, calibration, (*kept, *fitted), std, springs=model.springs)
    return Addition(problem, before, after, named[-1], new)


def _with_freed(problem: FitProblem, before: Scored, name: str) -> Scored:
    """The model `before` in which a fixed effect is free."""
    stated = {
        f"{name}.{key}": value
        for effect in problem.fixed
        if effect.name == name
        for key, value in effect.values.items()
    }
    stated |= dict(zip(before.fit.likelihood.names, before.fit.values.tolist(), strict=True))
    names = (*before.effects, name)
    start = np.array([stated[p.name] for p in problem.likelihood(names).parameters], float)
    return _predicting(problem, closer(problem, score_base(problem, names, start)))


def _at_best_place(
    name: str,
    data: MeasurementSet,
    model: Model,
    classes: Mapping[str, type[Effect]],
    tell: Tell,
) -> str:
    """The effect of a hand at the place where it leaves the smallest held-out error, if `name` is
    one without a place; else the name.
    """
    places = [one for one, effect in classes.items() if getattr(effect, "kind", "") == name]
    if not places:
        return name
    problem, given = pose_problem(data, model, classes)
    tried = score_all(problem, score_base(problem, [e.name for e in given]), places, tell=tell)
    shown = [scored for scored in tried if isinstance(scored, Scored)]
    if not shown:
        raise ValueError(
            f"effect {name}: expected an effect that changes a predicted output, got an effect "
            "that changes none, wherever in the hand it acts"
        )
    return min(shown, key=lambda scored: scored.held_out.rmse).added


def _written(calibration: dict[str, Any], modulus: Mapping[str, Estimate] | None) -> dict[str, Any]:
    """The calibration of a model file: a measured modulus is written as `modulus`, which applies to
    other specimens too; as one number for a single batch.
    """
    if not modulus:
        return calibration
    values = {batch: entry.value for batch, entry in modulus.items()}
    alone = next(iter(values.values())) if len(values) == 1 else values
    kept = {key: value for key, value in calibration.items() if key != "modulus_scale"}
    return {"modulus": alone, **kept}


def _before_and_after(
    problem: FitProblem, given: Sequence[str], name: str
) -> tuple[FitProblem, Scored, Scored]:
    """The model without and with an effect; the problem with the noise floor beside that model.

    Raises ValueError when the data do not show the effect.
    """
    before = score_base(problem, given)
    after = _scored(problem, before, name)
    if isinstance(after, Unseen):
        raise ValueError(
            f"effect {name}: expected an effect that is visible in these data, got one that "
            f"{after.reason}"
        )
    clearer = with_lower_floor(problem, after.fit)
    if clearer is not None:
        return _before_and_after(clearer, given, name)
    return problem, before, _predicting(problem, closer(problem, after))


def _predicting(problem: FitProblem, after: Scored) -> Scored:
    """The model, fitted by least squares if its error on all data is larger than the held-out one.

    The weights of the noise are right for a model that explains the data. One that does not may
    follow its fast changes and miss its course, while held-out fits are tried by least squares too.
    """
    if after.fit.rmse <= after.held_out.rmse:
        return after
    again = fit(_least_squares(problem, after.effects), after.fit.values[None])
    return replace(after, fit=again, held_out=hold_out(again))


def _least_squares(problem: FitProblem, effects: Sequence[str]) -> Likelihood:
    """The likelihood in which all samples have the same weight."""
    spectrum = problem.spectrum.in_one_band()
    white = np.full(spectrum.band_count, problem.floor.total**2)
    return Likelihood(problem.likelihood(effects).forward, spectrum, white)


def _scored(problem: FitProblem, before: Scored, name: str) -> Scored | Unseen:
    """The model with one effect more."""
    if problem.classes[name].physical:
        return score_with(problem, before, name)
    return _with_generic_term(problem, before, name)


def _with_generic_term(problem: FitProblem, before: Scored, name: str) -> Scored | Unseen:
    """The model with a generic term, fitted by least squares: it must reduce the error as much as
    possible, not explain it. Parameters that the data do not determine keep the value without
    effect.
    """
    effect = problem.classes[name]
    effects = (*before.effects, name)
    seen = signature(problem.likelihood(effects), before.fit, effect)
    reason = invisible(seen, problem.floor.total)
    if reason is not None:
        return Unseen(name, reason)
    idle = np.array([[parameter.neutral or 0.0 for parameter in effect.parameters]])
    squares = _least_squares(problem, effects)
    after = fit(squares, with_trials(squares, before.fit, name, idle))
    return Scored(effects, after, hold_out(after), signature=seen)


def _instance(problem: FitProblem, named: NamedEffect) -> Effect:
    effect = problem.classes[named.name]
    values = {
        # a logarithm's rounding may lead out of bounds
        p.name: min(max(named.parameters[p.name].value, p.low), p.high)
        for p in effect.parameters
    }
    return effect(**values)


def write_model(path: Path, model: Model, comment: str = "", force: bool = False) -> None:
    """Write a model file that `softhand_model.model_file.load_model` reads back equal.

    Paths of the effects' own files (`model.files`) are written relative to the model file, so that
    both can be moved together; files from outside its folder are copied into it.

    Args:
        path: the model file, `.yaml` or `.yml`.
        model: what it holds.
        comment: text of its first lines; each gets a #.
        force: whether a file there may be overwritten.

    Raises:
        ValueError: the file exists and `force` is false, its name does not end in .yaml or .yml, it
            cannot be written, or the copy of an effect's file would overwrite another file.
    """
    check_model_file(path, force)
    files = {name: _beside(path.parent, file, force) for name, file in model.files.items()}
    write_new(path, model_text(replace(model, files=files), path.parent, comment), force)


def _beside(folder: Path, file: Path, force: bool) -> Path:
    """A file in the model's folder: as it is, or copied there."""
    if file.resolve().is_relative_to(folder.resolve()):
        return file
    copy, text = folder / file.name, file.read_text(encoding="utf-8")
    if not (copy.is_file() and copy.read_text(encoding="utf-8") == text):
        write_new(copy, text, force)
    return copy


def check_model_file(path: Path, force: bool = False) -> None:
    """Raise ValueError if no model file can be written at this path, or if its name does not end in
    .yaml or .yml, without which it could not be loaded.
    """
    if path.suffix not in (".yaml", ".yml"):
        raise ValueError(
            f"{path}: expected a name that ends in .yaml or .yml, got {path.suffix or 'no'} suffix"
        )
    check_new(path, force)


def model_text(model: Model, folder: Path, comment: str = "") -> str:
    """The text of a model file that is to lie in `folder`, to which paths of effect files are
    relative; `comment` becomes its first lines.
    """
    lines = [f"# {line}".rstrip() for line in comment.splitlines()]
    lines += [f"format: {FORMAT}", f"base: {model.base}"]
    if model.calibration:
        lines.append(f"calibration: {_in_one_line(model.calibration)}")
    if model.springs != THESIS:
        lines.append(f"springs: {_in_one_line(asdict(model.springs))}")
    if model.effects:
        lines.append("effects:")
        lines += [
            f"  - {_in_one_line(_entry(model, effect, folder))}"
            f"{'' if effect.physical else f'  # {NOT_PHYSICS}'}"
            for effect in model.effects
        ]
    return "\n".join(lines) + "\n"


def _entry(model: Model, effect: Effect, folder: Path) -> dict[str, Any]:
    entry: dict[str, Any] = {"name": effect.name}
    if isinstance(effect, HandEffect):
        entry = {"name": effect.kind} | ({"where": dict(effect.where)} if effect.where else {})
    if effect.name in model.files:
        file = os.path.relpath(model.files[effect.name].resolve(), folder.resolve())
        entry["file"] = Path(file).as_posix()
    if effect.values:
        entry["parameters"] = dict(effect.values)
    std = plain(dict(model.std.get(effect.name, {})))
    known = {name: value for name, value in std.items() if value is not None}
    return entry | ({"std": known} if known else {})


def _in_one_line(value: Mapping[str, Any]) -> str:
    text = yaml.safe_dump(
        plain(_as_dict(value)),
        default_flow_style=True,
        sort_keys=False,
        allow_unicode=True,
        width=float("inf"),
    )
    return str(text).strip()


def _as_dict(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _as_dict(entry) for key, entry in value.items()}
    return value
