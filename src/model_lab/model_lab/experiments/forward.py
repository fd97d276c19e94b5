"""Predictions of a model for a whole measurement set, for many values of its parameters at once."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from model_lab.aliases import Array, Indices, Mask
from model_lab.experiments.base_torque import BaseTorque
from model_lab.experiments.blocked_tip import BlockedTip
from model_lab.experiments.free_bending import FreeBending
from model_lab.experiments.hand_grasp import HandGrasp
from model_lab.experiments.hand_motion import HandMotion
from model_lab.experiments.hand_pose import HandPose
from model_lab.experiments.hand_press import HandPress
from model_lab.experiments.linear import LinearBase
from model_lab.experiments.rubber import Rubber
from model_lab.experiments.samples import USUAL_MODULUS_SCALES
from model_lab.experiments.uniaxial import Uniaxial
from model_lab.experiments.valve_pulse import ValvePulse
from model_lab.measurements.bent_input import with_bends
from model_lab.measurements.held_input import DRIVING_COLUMN, with_jumps
from model_lab.measurements.lead import with_lead
from model_lab.measurements.measurement_set import INPUTS, MeasurementSet
from model_lab.measurements.preconditioning import with_preconditioning
from model_lab.measurements.specimens import MOUNTS
from model_lab.rules import RULES
from softhand_model.bending.balance import grows
from softhand_model.effects import Effect, Parameter
from softhand_model.effects.effect import BASES
from softhand_model.effects.pipeline import in_order
from softhand_model.hand.joint_stiffness import THESIS, SpringModel

Calibration = Mapping[str, float | Mapping[str, float]]
"""As in a model file: numbers, or numbers by batch, specimen or direction."""

USUAL_MODULUS = (0.9, 1.1)
MODULUS_SPREAD = 0.15 / np.sqrt(3.0)  # of a scale that is uniform within 15 %
FREE_MODULUS_RANGE, USUAL_FREE = (0.02, 50.0), (0.5, 2.0)  # where the modulus is what is sought
COEFFICIENT_RANGE, USUAL_COEFFICIENT_RANGE = (
    4.0,
    0.2,
)  # of coefficients about their least-squares start, over their size


class Experiment(Protocol):
    """The interface of the classes that predict one kind of experiment each."""

    def calibration(self, effects: Sequence[type[Effect] | Effect]) -> dict[str, float]:
        """Start values, by name, of the calibration parameters of a model with these effects."""
        ...

    def predict(self, calibration: Mapping[str, Array], effects: Sequence[Effect]) -> Array:
        """Predictions (lanes or 1, samples) for calibration (lanes,) and effects in lanes."""
        ...


EXPERIMENTS: Mapping[str, Callable[[MeasurementSet], Experiment]] = {
    "free_bending": FreeBending,
    "blocked_tip": BlockedTip,
    "uniaxial": Uniaxial,
    "rubber": Rubber,
    "valve_pulse": ValvePulse,
    "base_torque": BaseTorque,
    "hand_pose": HandPose,
    "hand_motion": HandMotion,
    "press": HandPress,
    "grasp": HandGrasp,
}


@dataclass(frozen=True)
class FreeParameter:
    """A parameter to fit, such as `modulus_scale[A]` or `gent_stiffening.jm` (effect and
    parameter).

    low, high: bounds. start: where a search starts. typical: usual range. logarithmic: whether it
    is searched by its logarithm. effect: name of its effect; None for the calibration. spread:
    standard deviation of its prior about 1; infinite for no prior.
    """

    name: str
    unit: str
    low: float
    high: float
    start: float
    typical: tuple[float, float]
    logarithmic: bool
    effect: str | None
    spread: float = np.inf


class Forward:
    """A model's predictions for a measurement set, in the order of its sample table.

    Args:
        data: the measurement set.
        base: name of the base model.
        effects: classes of effects whose parameters are free.
        fixed: effects with fixed parameters; those that do not act in the experiment are ignored.
        calibration: values from a model file, from which a search starts.
        free_calibration: whether the calibration is free; if not, it keeps the values given.
        springs: for a blocked tip, `exact` or `linear`.
        joints: spring model of the joints of a chain (base torque).

    Attributes: parameters, the free ones, first those of the calibration, then those of effects in
    the order of stages; measured (samples,), the values of the sample table; slope_step, the share
    of a parameter's usual range over which slopes are differences, None for the smallest.

    Raises ValueError for an effect that cannot act in the set, an unknown base, and anything that
    the set lacks.
    """

    def __init__(
        self,
        data: MeasurementSet,
        base: str = "pneuflex",
        effects: Sequence[type[Effect]] = (),
        fixed: Sequence[Effect] = (),
        calibration: Calibration | None = None,
        free_calibration: bool = True,
        springs: str = "exact",
        joints: SpringModel = THESIS,
    ) -> None:
        self._data = data
        self._fixed = [effect for effect in fixed if data.experiment in effect.experiments]
        self._free = in_order(effects)
        for effect in [*map(type, self._fixed), *self._free]:
            check_applicable(effect, data, base)
        driven, self._own = self._between_samples()
        self._experiment = experiment_of(driven, base, springs, joints)
        known = self._experiment.calibration([*self._free, *self._fixed])
        self._calibration = {**known, **_named(calibration or {}, known)}
        calibrated = (
            _calibrated(self._calibration, _unit(data), data.free_modulus)
            if free_calibration
            else []
        )
        free = (_free_parameter(e, parameter) for e in self._free for parameter in e.parameters)
        lowest: Mapping[str, float] = getattr(self._experiment, "lowest", {})
        self.parameters = (*calibrated, *(_from(lowest.get(p.name), p) for p in free))
        self.measured = data.table.value
        self.slope_step: float | None = getattr(self._experiment, "slope_step", None)
        self._moved: Array | float = 0.0

    def _between_samples(self) -> tuple[MeasurementSet, Indices | slice]:
        """The set with what its input did before the first sample and, where that matters, between
        samples, and the places of its own ones. What remembers without a time of its own follows
        the path alone.
        """
        if any(run.stretched_to > 1.0 for run in self._data.runs):
            pulled, own = with_preconditioning(self._data)
            driven, places = self._driven(pulled)
            return driven, np.arange(driven.table.samples)[places][own]
        return self._driven(self._data)

    def _driven(self, data: MeasurementSet) -> tuple[MeasurementSet, Indices | slice]:
        """The set with its leads and what is between samples, and the places of its own."""
        led, own = with_lead(data)
        if led.jumps:
            driven, places = with_jumps(led)
            return driven, places[own]
        effects: list[type[Effect] | Effect] = [*self._fixed, *self._free]
        timed = any(e.has_memory and p.unit == "s" for e in effects for p in e.parameters)
        if timed and self._data.experiment in DRIVING_COLUMN:
            driven, places = with_bends(led)
            return driven, places[own]
        return led, own

    def start(self) -> Array:
        """Values (k,) from which a search starts."""
        return np.array([parameter.start for parameter in self.parameters])

    def predict(self, values: Array) -> Array:
        """Predictions (lanes, samples) for parameter values (lanes, k)."""
        values = np.asarray(values, float)
        found = self._experiment.predict(self.calibration_at(values), self.acting_at(values))
        whole = found[:, self._own] + self._moved
        return np.broadcast_to(whole, (len(values), self.measured.size))

    @property
    def unsettled(self) -> Mapping[int, str]:
        """Runs, by index, that the last prediction cannot follow, and why."""
        found: Mapping[int, str] = getattr(self._experiment, "unsettled", {})
        return found

    def calibration_at(self, values: Array) -> dict[str, Array]:
        """The calibration, free or not, with parameter values (lanes, k)."""
        columns = dict(zip((p.name for p in self.parameters), np.transpose(values), strict=True))
        return {
            name: columns.get(name, np.full(1, value)) for name, value in self._calibration.items()
        }

    def acting_at(self, values: Array) -> list[Effect]:
        """All effects, fixed or free, with parameter values (lanes, k)."""
        return [*self._fixed, *self.effects_at(values)]

    @property
    def is_moved(self) -> bool:
        """Whether `moved` has made it."""
        return bool(np.any(self._moved))

    def moved(self, by: Array) -> Forward:
        """The same with predictions that differ by (samples,)."""
        found = copy(self)
        found._moved = self._moved + by
        return found

    def grows(self, values: Array) -> Mask:
        """Whether the elastic stress rises with the stretch up to a stretch of 4, (lanes,) for
        parameter values (lanes, k).

        Where it does not, parameters count as out of bounds, though predictions are finite.
        """
        effects = self.acting_at(values)
        strained = getattr(self._experiment, "strained", None)
        found = grows(effects, *strained) if strained else np.ones(1, bool)
        return np.broadcast_to(found, len(values))

    def effects_at(self, values: Array) -> list[Effect]:
        """The free effects with parameter values (lanes, k)."""
        columns = dict(zip((p.name for p in self.parameters), np.transpose(values), strict=True))
        return [
            effect.in_lanes({p.name: columns[f"{effect.name}.{p.name}"] for p in effect.parameters})
            for effect in self._free
        ]


def experiment_of(
    data: MeasurementSet, base: str, springs: str = "exact", joints: SpringModel = THESIS
) -> Experiment:
    """The object that predicts the experiment of a set under a base model. springs, joints: as for
    `Forward`.
    """
    if base not in BASES:
        raise ValueError(f"base: expected one of {', '.join(BASES)}, got {base}")
    if base == "linear":
        return LinearBase(data)
    if data.experiment not in EXPERIMENTS:
        raise ValueError(
            f"experiment: expected one of {', '.join(EXPERIMENTS)}, got {data.experiment}"
        )
    if data.experiment == "blocked_tip":
        return BlockedTip(data, springs)
    if data.experiment == "base_torque":
        return BaseTorque(data, joints=joints)
    return EXPERIMENTS[data.experiment](data)


def inapplicable(effect: type[Effect], data: MeasurementSet, base: str) -> str | None:
    """Why an effect cannot show in this set, as a clause, found without any calculation; None if it
    may show.
    """
    if effect.unseen_in.get(data.experiment):
        return effect.unseen_in[data.experiment]
    if data.experiment not in effect.experiments:
        return f"does not act in {data.experiment}"
    if effect.has_memory and not data.has_time:
        return "the set has no time column, and it depends on what was before"
    weighs = effect.name in ("gravity", "tip_load")
    if weighs and data.experiment == "free_bending" and _is_level(data):
        return "no weight acts in the plane of bending: the mount is level, or not stated"
    if len(data.runs) < effect.fewest_runs:
        return "in a single run its time is one with what the input does"
    if base not in effect.bases:
        return f"has no meaning beside the base {base}"
    return None


def _is_level(data: MeasurementSet) -> bool:
    return all(data.specimens[run.specimen].mount == MOUNTS[0] for run in data.runs)


def not_searched(effect: type[Effect], data: MeasurementSet, base: str) -> str | None:
    """Why the search for missing effects leaves out an effect, as a clause; None if the effect is
    searched.
    """
    if effect.refines and effect.stage == "elastic" and not data.stretched:
        return f"a finer form of {effect.refines[0]}: tests of the rubber alone tell them apart"
    reason = inapplicable(effect, data, base)
    runs = max(Counter(run.specimen for run in data.runs).values())
    if reason is None and "run_order" in effect.axes and runs < RULES.trend_runs:
        return "two runs of a specimen show no trend beyond their scatter"
    if reason is None and effect.has_memory and _is_clock(data):
        return "the input rises evenly, at one rate: time and input are one"
    return reason


def _is_clock(data: MeasurementSet) -> bool:
    """Whether input and time are proportional: ramps in straight lines of about one rate."""
    if data.experiment == "base_torque":  # which the tip's pose drives too
        return False
    rest, rates = 1.0 if data.stretched else 0.0, []
    for run in data.runs:
        time, driving = run.columns["time"], np.abs(data.driving(run) - rest)
        duration, span = float(np.ptp(time)), float(np.ptp(driving))
        if not duration * span > 0.0:
            return False
        line = driving[0] + (driving[-1] - driving[0]) * (time - time[0]) / duration
        if driving[-1] <= driving[0] or np.max(np.abs(driving - line)) > RULES.straight_ramp * span:
            return False
        rates.append(span / duration)
    return max(rates) < RULES.one_rate * min(rates)


def check_applicable(effect: type[Effect], data: MeasurementSet, base: str) -> None:
    """Raise ValueError unless an effect can act in the experiment of a set and with the
    base model.
    """
    reason = None
    if data.experiment not in effect.experiments:
        reason = effect.unseen_in.get(data.experiment, f"it does not act in {data.experiment}")
    elif base not in effect.bases:
        reason = f"it has no meaning beside the base {base}"
    elif effect.has_memory and not data.has_time:
        reason = "it depends on what was before, and the set has no column time"
    if reason is not None:
        raise ValueError(f"effect {effect.name}: {reason}")


def _unit(data: MeasurementSet) -> str:
    """Unit of a coefficient of the calibration."""
    if data.experiment == "valve_pulse":
        return "kg/(s Pa)"
    return f"{data.unit}/Pa" if "pressure" in INPUTS[data.experiment] else data.unit


def _free_parameter(effect: type[Effect], parameter: Parameter) -> FreeParameter:
    """The parameter, starting in the middle of where it is usually found."""
    low, high = parameter.typical or (parameter.low, parameter.high)
    start = np.sqrt(low * high) if parameter.logarithmic else 0.5 * (low + high)
    return FreeParameter(
        f"{effect.name}.{parameter.name}",
        parameter.unit,
        parameter.low,
        parameter.high,
        float(start),
        (low, high),
        parameter.logarithmic,
        effect.name,
    )


def _from(lowest: float | None, parameter: FreeParameter) -> FreeParameter:
    """The parameter with a larger lower bound, if one is given; it is usual up to ten times it."""
    if lowest is None or not parameter.low < lowest < parameter.high:
        return parameter
    usual = lowest, min(10.0 * lowest, parameter.high)
    start = float(np.sqrt(usual[0] * usual[1]))
    return replace(parameter, low=lowest, start=start, typical=usual)


def _calibrated(
    calibration: Mapping[str, float], unit: str, free_modulus: bool
) -> list[FreeParameter]:
    return [_of_calibration(name, start, unit, free_modulus) for name, start in calibration.items()]


def _of_calibration(name: str, start: float, unit: str, free_modulus: bool) -> FreeParameter:
    """Bounds and start of a scale of the modulus, free or within 15 %, or of another coefficient,
    around its value by least squares.
    """
    if name.startswith("modulus_scale"):
        if free_modulus:
            return FreeParameter(name, "", *FREE_MODULUS_RANGE, start, USUAL_FREE, True, None)
        return FreeParameter(
            name, "", *USUAL_MODULUS_SCALES, start, USUAL_MODULUS, False, None, MODULUS_SPREAD
        )
    low, high = start - COEFFICIENT_RANGE * abs(start), start + COEFFICIENT_RANGE * abs(start)
    usual = (
        start - USUAL_COEFFICIENT_RANGE * abs(start),
        start + USUAL_COEFFICIENT_RANGE * abs(start),
    )
    return FreeParameter(name, unit, low, high, start, usual, False, None)


def _named(calibration: Calibration, known: Mapping[str, float]) -> dict[str, float]:
    """Values of a model file by the names of this set's calibration; those of others are left
    out.
    """
    found = {}
    for name in known:
        key, _, member = name.rstrip("]").partition("[")
        value = calibration.get(key)
        if isinstance(value, Mapping):
            value = value.get(member)
        if value is not None:
            found[name] = float(value)
    return found
