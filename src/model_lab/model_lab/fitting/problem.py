"""Fit problem of a diagnosis: data, base model, effects and noise floor."""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

import numpy as np

from model_lab.aliases import Array
from model_lab.experiments.base_torque import torque_errors
from model_lab.experiments.forward import Forward
from model_lab.experiments.hand_grasp import (
    closer_grasp,
    grasp_errors,
    weighted,
    within_simulated,
)
from model_lab.experiments.hand_motion import own_errors
from model_lab.experiments.hand_pose import HAND_WEIGHT, in_lane, own_error, with_weight
from model_lab.experiments.hand_press import closer_press, press_errors
from model_lab.experiments.own_errors import OwnErrors
from model_lab.fitting.between_samples import with_input_between
from model_lab.fitting.fit import Fit, Likelihood, fit
from model_lab.fitting.noise_floor import NoiseFloor, Spectrum, make_spectrum, noise_floor
from model_lab.measurements.hands import GRASP, HAND_MOTION, HAND_POSE, PRESS
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.measurements.preprocess import without_input_noise
from model_lab.measurements.specimens import DOCUMENT, made_of
from model_lab.measurements.unrounded import without_rounding
from model_lab.measurements.wild_samples import without_wild_samples
from model_lab.rules import RULES, Rules
from softhand_model.effects import Effect, Parameter
from softhand_model.effects.effect import OUTPUT_UNIT
from softhand_model.effects.hand import at_places
from softhand_model.hand.joint_stiffness import THESIS, SpringModel
from softhand_model.model_file import Model

SMALLEST_SCALE = 1e-9  # of a largest value, where nothing was measured
MOST_WEIGHT = 3.0  # of a hand over the stated one

OWN_ERRORS: Mapping[str, Callable[[MeasurementSet, Model], float | OwnErrors]] = {
    "base_torque": torque_errors,
    HAND_MOTION: own_errors,
    PRESS: press_errors,
    GRASP: grasp_errors,
}  # of predictions; those of other experiments are `own_error`

Closer = Callable[
    [MeasurementSet, Mapping[str, Array], Sequence[Effect], Array],
    tuple[Array, OwnErrors | None],
]
"""Predictions and their errors at the values of a fitted model; None: errors as before."""

CLOSER: Mapping[str, Closer] = {PRESS: closer_press, GRASP: closer_grasp}
INTERPOLATED = (GRASP,)  # experiments whose predictions are, between simulated values
CLOSER_FITS = {PRESS: 1, GRASP: 3}  # at most: predictions err at the new values, too
SETTLED_MOVE = 0.3  # of its standard error, by which no parameter moves any more; by hand

Result = TypeVar("Result")


@dataclass(frozen=True)
class FitProblem:
    """Everything that a diagnosis needs to fit models: data, base model, effects, noise.

    fixed: effects with fixed parameters. classes: classes of effects by name. fitted: parameter
    values of the model before the diagnosis, by name. joints: spring model of chains. rules:
    thresholds. floor_as_is: noise floor estimated with the model before the diagnosis, if a better
    model has a lower noise floor; otherwise None. own_error: error of the predictions, see
    `noise_floor`. known: results that `once` has computed; None: results are not kept.
    """

    data: MeasurementSet
    base: str
    fixed: tuple[Effect, ...]
    classes: Mapping[str, type[Effect]]
    spectrum: Spectrum
    floor: NoiseFloor
    fitted: Mapping[str, float]
    joints: SpringModel = THESIS
    rules: Rules = RULES
    floor_as_is: NoiseFloor | None = None
    own_error: float | OwnErrors = 0.0
    known: dict[Hashable, Any] | None = field(default=None, compare=False)

    def likelihood(self, effects: Iterable[str]) -> Likelihood:
        """The likelihood of the model in which the parameters of these effects are free."""
        forward = self.forward(tuple(effects), self.data)
        own = self.own_error if isinstance(self.own_error, OwnErrors) else None
        return Likelihood(forward, self.spectrum, self.floor.variance, self.floor.gain_known, own)

    def forward(self, effects: Collection[str], data: MeasurementSet) -> Forward:
        """The predictions of a set by the model in which the parameters of these effects are free,
        also where the model has them with fixed ones.
        """
        chosen = [self.classes[name] for name in effects]
        fixed = [effect for effect in self.fixed if effect.name not in effects]
        return Forward(data, self.base, chosen, fixed, joints=self.joints)

    def once(self, make: Callable[[], Result], *key: Hashable) -> Result:
        """The result of `make`, or the kept result of an earlier call with the same key and noise
        floor. Therefore many rules can judge one set with few fits.
        """
        if self.known is None:
            return make()
        whole = (*key, self.floor.variance.tobytes(), self.floor.gain_known)
        if whole not in self.known:
            self.known[whole] = make()
        found: Result = self.known[whole]
        return found


def pose_problem(
    data: MeasurementSet,
    model: Model,
    classes: Mapping[str, type[Effect]],
    rules: Rules = RULES,
) -> tuple[FitProblem, tuple[Effect, ...]]:
    """(problem with its noise floor, effects of the model that are fitted with the calibration).

    The floor is estimated from the residual of the model as it is, with its calibration fitted.
    Before that, noise of the input and wild samples are removed, and runs that the model cannot
    follow. Raises ValueError if it can follow none.
    """
    model = with_weight(data, model)
    read = without_wild_samples(made_of(data, model))
    data, unrounded = without_input_noise(read), without_rounding(read)
    given = tuple(effect for effect in model.effects if effect.name in model.std)
    fixed = tuple(effect for effect in model.effects if effect.name not in model.std)
    known = {**classes, **{effect.name: type(effect) for effect in given}}
    known = in_the_range_of(
        data, at_places(data.hand, known, data.markers) if data.of_hand else known
    )
    if data.experiment == GRASP:
        known = within_simulated(known)
    if data.experiment == HAND_POSE:
        known = _about_stated_weight(known, fixed)
    free = [known[effect.name] for effect in given]

    def forward_of(data: MeasurementSet) -> Forward:
        return Forward(data, model.base, free, fixed, joints=model.springs)

    forward = forward_of(data)
    starts = _as_given(base_starts(forward.parameters), forward.parameters, given)
    data = with_input_between(
        data,
        lambda other: forward_of(other).predict(starts[:1])[0],
        None if unrounded is None else without_input_noise(unrounded),
    )
    forward = forward_of(data)
    predicted = forward.predict(starts[:1])[0]
    if forward.unsettled:
        data = _without_runs(data, forward.unsettled)
        forward = forward_of(data)
        predicted = forward.predict(starts[:1])[0]
    if data.experiment == GRASP:
        data = weighted(data, model)
        forward = forward_of(data)
        predicted = forward.predict(starts[:1])[0]
    spectrum = make_spectrum(data.table, predicted)
    rough = noise_floor(data, spectrum, forward.measured - predicted)
    better = fit(Likelihood(forward, spectrum, rough.variance, rough.gain_known), starts)
    if len(data.wild) > rules.frequent_wild * data.table.samples:
        data = without_wild_samples(data, forward.measured - better.residual)
        forward = forward_of(data)
        rough = noise_floor(data, spectrum, forward.measured - predicted)
        better = fit(Likelihood(forward, spectrum, rough.variance, rough.gain_known), starts)
    spectrum = make_spectrum(data.table, forward.measured - better.residual)
    own = OWN_ERRORS.get(data.experiment, own_error)(data, model)
    floor = noise_floor(data, spectrum, better.residual, _in_rows(own))
    fitted = dict(zip(better.likelihood.names, better.values.tolist(), strict=True))
    problem = FitProblem(
        data,
        model.base,
        fixed,
        known,
        spectrum,
        floor,
        fitted,
        model.springs,
        rules,
        own_error=own,
    )
    return problem, given


def _without_runs(data: MeasurementSet, why: Mapping[int, str]) -> MeasurementSet:
    """The set without runs, by index; it says which are left out, and why. Raises ValueError if
    none stays.
    """
    left_out = {data.runs[index].name: reason for index, reason in sorted(why.items())}
    runs = tuple(run for run in data.runs if run.name not in left_out)
    if not runs:
        name, reason = next(iter(left_out.items()))
        raise ValueError(
            f"{data.folder / DOCUMENT}: expected at least one run that the model can compute, "
            f"got none: in {name}, {reason}"
        )
    return replace(data, runs=runs, left_out={**data.left_out, **left_out})


def _in_rows(own: float | OwnErrors) -> float | Array:
    return own.rows if isinstance(own, OwnErrors) else own


def _as_given(starts: Array, parameters: Sequence[Any], given: Iterable[Effect]) -> Array:
    """Starts (n, k) with the effects of the model file at its values."""
    known = {
        f"{effect.name}.{key}": value for effect in given for key, value in effect.values.items()
    }
    return np.array(
        [[known.get(p.name, at) for p, at in zip(parameters, row, strict=True)] for row in starts]
    )


# ---------------------------------------------------------------------- usual ranges
def _about_stated_weight(
    classes: Mapping[str, type[Effect]], fixed: Iterable[Effect]
) -> dict[str, type[Effect]]:
    """Classes in which the weight of a hand may differ from that which the model states."""
    stated = {effect.name: effect for effect in fixed if effect.name == HAND_WEIGHT}
    found = dict(classes)
    for name in stated.keys() & classes.keys():
        kind, scale = classes[name], float(stated[name].values["mass_scale"])
        (parameter,) = kind.parameters
        usual = [factor * scale for factor in parameter.typical or (1.0, 1.0)]
        if usual[0] < usual[1]:  # not so for a hand without weight
            about = replace(
                parameter, high=MOST_WEIGHT * scale, typical=(usual[0], usual[1]), neutral=scale
            )
            parts = {"parameters": (about,), "__doc__": kind.__doc__}
            found[name] = type(kind.__name__, (kind,), parts)
    return found


def in_the_range_of(
    data: MeasurementSet, classes: Mapping[str, type[Effect]]
) -> dict[str, type[Effect]]:
    """Classes of effects whose usual parameter ranges and units are adapted to this set.

    Classes without a parameter relative to the range of the set stay as they are.
    """
    largest = {
        "pressure": _largest(data, ("pressure",)),
        "output": _largest(data, data.outputs),
    }
    return {name: _placed(effect, largest, data.unit) for name, effect in classes.items()}


def _largest(data: MeasurementSet, names: tuple[str, ...]) -> float:
    """Largest size of these columns over the set."""
    columns = [run.columns[name] for run in data.runs for name in names if name in run.columns]
    return max((float(np.max(np.abs(column))) for column in columns), default=0.0) or SMALLEST_SCALE


def _placed(effect: type[Effect], largest: Mapping[str, float], unit: str) -> type[Effect]:
    if not any(parameter.relative for parameter in effect.parameters):
        return effect
    placed = tuple(_in_range(parameter, largest, unit) for parameter in effect.parameters)
    return type(effect.__name__, (effect,), {"parameters": placed, "__doc__": effect.__doc__})


def _in_range(parameter: Parameter, largest: Mapping[str, float], unit: str) -> Parameter:
    if parameter.relative is None:
        return parameter
    of, *shares = parameter.relative
    low, high = np.clip(np.array(shares) * largest[of], parameter.low, parameter.high).tolist()
    if not low < high:
        return parameter
    shown = parameter.unit.replace(OUTPUT_UNIT, unit)
    return replace(parameter, unit=shown, typical=(low, high), relative=None)


# ---------------------------------------------------------------------- floor and starts
def with_lower_floor(problem: FitProblem, better: Fit) -> FitProblem | None:
    """The problem with the noise floor estimated with a better model; None if that floor is not
    clearly lower.

    It can be lower if repeats differ by an effect, such as what earlier runs have left in the
    rubber.
    """
    own = _in_rows(problem.own_error)
    floor = noise_floor(problem.data, problem.spectrum, better.residual, own)
    if floor.total >= problem.rules.lower_floor * problem.floor.total:
        return None
    return replace(problem, floor=floor, floor_as_is=problem.floor_as_is or problem.floor)


def fitted_closer(problem: FitProblem, found: Fit) -> Fit:
    """The fit, repeated with predictions whose numerical errors are evaluated at that fit, at most
    `CLOSER_FITS` times, until its parameters stay; the same for experiments without such, where
    closer predictions have no result, and if that was done before. It begins where it ended for
    another noise floor, as what was simulated there is kept.
    """
    experiment, likelihood = problem.data.experiment, found.likelihood
    if experiment not in CLOSER or not isinstance(likelihood.forward, Forward):
        return found
    forward, again = likelihood.forward, found
    if forward.is_moved:
        return found
    known: dict[Hashable, Any] = {} if problem.known is None else problem.known
    key = ("closer", *likelihood.names)
    at = known.get(key, found.values)
    for _ in range(CLOSER_FITS[experiment]):
        values, known[key] = at[None], at
        acting = [in_lane(effect, 0) for effect in forward.acting_at(values)]
        predicted, calibration = forward.predict(values)[0], forward.calibration_at(values)
        closer, own = CLOSER[experiment](problem.data, calibration, acting, predicted)
        if not np.isfinite(closer).all():
            return found
        moved = forward.moved(closer - predicted)
        again = fit(replace(likelihood, forward=moved, own=own or likelihood.own), values)
        inward = likelihood.scales.inward
        way = np.abs(inward(again.values) - inward(values[0]))
        if np.all(way <= SETTLED_MOVE * np.sqrt(np.diag(again.covariance))):
            break
        at = again.values
    return again


def base_starts(parameters: Sequence[Any]) -> Array:
    """Values (n, k) from which a search starts: the start values of the parameters; if batches have
    factors on their moduli, also with these 10 % smaller and 10 % larger.
    """
    start = np.array([p.start for p in parameters], float)
    scales = np.array([p.name.startswith("modulus_scale") for p in parameters], bool)
    if not scales.any():
        return start[None]
    return np.stack([np.where(scales, factor * start, start) for factor in (1.0, 0.9, 1.1)])
