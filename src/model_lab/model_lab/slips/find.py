"""Search for slips: which mistake in how the data are stated explains the error of the model.

A slip has no free parameter: the data are corrected, and the calibration alone is fitted again. So
the whole search is one prediction for each slip, and a fit to thinned data for those with the least
error.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from model_lab.aliases import Array, Tell, tell_nobody
from model_lab.experiments.forward import FREE_MODULUS_RANGE, Forward, FreeParameter
from model_lab.experiments.samples import USUAL_MODULUS_SCALES
from model_lab.fitting.fit import fit
from model_lab.fitting.held_out import hold_out
from model_lab.fitting.noise_floor import REPEATS, make_spectrum, noise_floor, spline_levels
from model_lab.fitting.problem import FitProblem, base_starts, pose_problem
from model_lab.fitting.recording_notices import seem_absolute
from model_lab.measurements.measurement_set import TIP_POSE, MeasurementSet
from model_lab.measurements.preprocess import thinned
from model_lab.measurements.rows import is_possible
from model_lab.measurements.specimens import made_of
from model_lab.rules import RULES
from model_lab.slips.candidates import candidates
from model_lab.slips.columns import Candidate
from model_lab.slips.factor import factor_left, is_mere_factor, is_other_factor
from model_lab.slips.mislabelled import exchanged_inputs, mislabelled
from model_lab.slips.outside import below_ambient, dead_readings
from model_lab.slips.pulses import agreeing_units, contradict
from model_lab.slips.slip import Slip
from model_lab.slips.units_of_runs import units_of_runs
from softhand_model.effects import Effect
from softhand_model.model_file import Model

SLIP_SAMPLES = 40  # that are compared
PREDICTED_SAMPLES = 15  # of a run, of those that are predicted only
PRESSURE_SIGN = ("sign", "pressure")  # the only slip by which pressures are below the air's
TURN_OF_ANGLE = 2.0 * np.pi  # [rad] by which a wrapped angle jumps
FITTED = 6  # slips that are fitted: those whose predictions come nearest
LIKE_WEAKNESS = ("chord", "curvature")  # slips that look like an effect of another size


@dataclass(frozen=True)
class Checked:
    """A measurement set without the slips that were found in it.

    relative_error: held-out error on this set over the size of the outputs; NaN if no slip was
    found by the error. instead: effects, or pairs of effects, that explain the set as it was stated
    as well as the slips do. problem: of this set, with all that was fitted to it, if that was the
    whole set.
    """

    data: MeasurementSet
    slips: tuple[Slip, ...] = ()
    relative_error: float = np.nan
    instead: tuple[str, ...] = ()
    problem: tuple[FitProblem, tuple[Effect, ...]] | None = None


@dataclass(frozen=True)
class Score:
    """How well a model with its calibration fitted predicts a set.

    rmse, floor: held-out error and noise floor. size: root mean square of the outputs; all three in
    the SI unit of the outputs. at_bound: whether a parameter of the calibration lies on a bound.
    scaled: of a free modulus, the logarithm of its ratio to the stated one, without sign. factor:
    that the outputs lack, see `slips.factor`. modulus: the ratio itself, if there is only one; else
    1.
    """

    rmse: float
    floor: float
    size: float
    at_bound: bool = False
    scaled: float = 0.0
    factor: float = 1.0
    modulus: float = 1.0

    @property
    def relative(self) -> float:
        """Held-out error over the size of the outputs: a number that does not depend on
        their unit.
        """
        return self.rmse / self.size if self.size > 0.0 else np.inf

    @property
    def excess(self) -> float:
        """Excess error over the size of the outputs, where all that may be noise counts as left: a
        corrected set that contains only noise still has the error of this noise.
        """
        least = max(self.rmse, RULES.material_error * self.floor)
        return float(np.sqrt(least**2 - self.floor**2)) / self.size if self.size > 0.0 else np.inf

    @property
    def explains(self) -> bool:
        """Whether the error is at most `Rules.explained_error` times the floor."""
        return self.rmse <= RULES.explained_error * self.floor

    @property
    def is_noise(self) -> bool:
        """Whether the error is at most `Rules.material_error` times the floor, and so may be noise
        alone.
        """
        return self.rmse <= RULES.material_error * self.floor


def find_slips(data: MeasurementSet, model: Model, tell: Tell = tell_nobody) -> Checked:
    """Search for slips, one after the other, and take them out of the set.

    Raises ValueError for data that the model cannot use.
    """
    found: list[Slip] = []
    error = np.nan
    while len(found) < RULES.most_slips:
        tell("looking for wrong units and the like", 0, 0)
        best = best_slip(data, model)
        if best is None:
            break
        slip, data, error = best
        found.append(slip)
    return Checked(data, tuple(found), error)


def best_slip(data: MeasurementSet, model: Model) -> tuple[Slip, MeasurementSet, float] | None:
    """(slip, set without it, relative error that is left) of the slip without which the data fit
    best; None if no slip is found.
    """
    if data.doubts:
        return _possible_reading(data, model)
    shown = shown_by_readings(data, model)
    if shown is not None:
        return shown
    before = score(data, model)
    if before.explains or scatters(data, _scatter(data, before.floor)) or dead_readings(data):
        return None
    absolute = absolute_pressures(data, model, before)
    if absolute is not None:
        return absolute
    alike = _best(scored(data, model), before)
    if not alike:
        alike = _best(_of_runs(data, model, before), before)
    if not alike:
        return None
    (candidate, after), *_ = alike
    if below_ambient(data, model.base) and (candidate.name, candidate.column) != PRESSURE_SIGN:
        return None
    slip, mended, error = _told([one for one, _ in alike], before.rmse, after)
    return replace(slip, modulus=_of_another_mix(data, model, after)), mended, error


def shown_by_readings(
    data: MeasurementSet, model: Model
) -> tuple[Slip, MeasurementSet, float] | None:
    """The slip that readings show by themselves, as `best_slip` returns it: an angle that jumps,
    units of pulses that contradict each other, or repeats in different units. It is a slip even if
    the model explains little of the data; None if there is none.
    """
    return (
        _jumping_angle(data, model)
        or _contradicting_units(data, model)
        or _runs_in_other_unit(data, model)
    )


def _runs_in_other_unit(
    data: MeasurementSet, model: Model
) -> tuple[Slip, MeasurementSet, float] | None:
    """The slip of runs in another unit than their repeats, which lowers the error; None if none."""
    for candidate in units_of_runs(data):
        before, after = score(data, model), score(candidate.mended, model)
        if after.relative < before.relative:
            return _told([candidate], before.rmse, after)
    return None


def _contradicting_units(
    data: MeasurementSet, model: Model
) -> tuple[Slip, MeasurementSet, float] | None:
    """The slip of units of pulses that contradict each other; None if no others agree."""
    alike = agreeing_units(data) if contradict(data) else []
    return _told(alike, score(data, model).rmse, score(alike[0].mended, model)) if alike else None


def _jumping_angle(data: MeasurementSet, model: Model) -> tuple[Slip, MeasurementSet, float] | None:
    """The slip of a tip angle that jumps by 360 deg between samples; None if no angle jumps, or the
    data fit no better without the jumps.
    """
    if not any(_jumps(run.columns["tip_angle"]) for run in data.runs if "tip_angle" in run.columns):
        return None
    wrapped = next((one for one in candidates(data) if one.name == "wrapped"), None)
    if wrapped is None:
        return None
    before, after = score(data, model), score(wrapped.mended, model)
    return _told([wrapped], before.rmse, after) if after.relative < before.relative else None


def absolute_pressures(
    data: MeasurementSet, model: Model, before: Score
) -> tuple[Slip, MeasurementSet, float] | None:
    """The slip of absolute pressures that are stated as gauge pressures, as `best_slip` returns it;
    None if the pressures at rest do not show this slip, or if its correction does not lower the
    error. The corrected data may still have a large error, as the model may also lack effects.
    """
    if not seem_absolute(data):
        return None
    found = next((one for one in candidates(data) if one.name == "absolute"), None)
    if found is None:
        return None
    after = score(found.mended, model)
    better = after.relative <= RULES.slip_absolute_share * before.relative
    return _told([found], before.rmse, after) if better else None


def _jumps(angle: Array) -> bool:
    """Whether an angle [rad] of a run (samples,) stays within a turn, and all its steps are either
    short or nearly a whole turn.
    """
    steps = np.abs(np.diff(angle))
    jumps = steps > TURN_OF_ANGLE - RULES.longest_step
    within = np.ptp(angle) < TURN_OF_ANGLE + RULES.longest_step
    return bool(within and jumps.any() and np.all(steps[~jumps] < RULES.longest_step))


def scatters(data: MeasurementSet, floor: float) -> bool:
    """Whether the readings scatter by so large a share of their standard deviation that no slip can
    be found. A noise floor far above that deviation does not count: it comes from inputs in a wrong
    unit.
    """
    spread = float(np.std(data.table.value))
    return RULES.slip_noise * spread < floor < RULES.slip_foreign_noise * spread


def _best(tried: Sequence[tuple[Candidate, Score]], before: Score) -> list[tuple[Candidate, Score]]:
    """The slips that fit about as well as the best one does, none if that is no slip: first those
    that need no modulus at the end of what is usual, of these those with a free modulus about the
    stated one, of these the commonest.
    """
    least = min((after.relative for _, after in tried), default=np.inf)
    alike = [pair for pair in tried if pair[1].relative <= RULES.slip_alike * least]
    alike.sort(key=lambda pair: (pair[1].at_bound, round(pair[1].scaled), pair[0].rare))
    if not alike or not is_slip(alike[0][0].name, before, alike[0][1]):
        return []
    (best, after), *_ = alike
    return [] if is_other_factor(best.name, best.column, after.factor) else alike


def _of_runs(data: MeasurementSet, model: Model, before: Score) -> list[tuple[Candidate, Score]]:
    """Runs that belong to other specimens, orientations of the wrist, or inputs of other runs than
    stated, where that lowers the error enough. Of specimens it tells little whether the error is
    then about the floor, which depends on which runs are repeats.
    """
    calibrated = replace(model, calibration={"modulus_scale": before.modulus})
    labels = mislabelled(data, calibrated if data.of_hand else model)
    tried = _scores([*labels, *exchanged_inputs(data, model)], model)
    most = RULES.slip_share * before.relative
    return [
        (one, after)
        for one, after in tried
        if after.relative <= most or (data.of_hand and after.is_noise)
    ]


def words(candidate: Candidate) -> str:
    """A slip in words, such as `pressure is inHg, not kPa`."""
    return f"{candidate.column} is {candidate.fits}, not {candidate.said}"


def _possible_reading(data: MeasurementSet, model: Model) -> tuple[Slip, MeasurementSet, float]:
    """The slip of a set with values that cannot be what their column is named: the reading that
    fits best of those that are possible. As no model can use the data as stated, their error is
    the size of the outputs. Raises ValueError if there is none.
    """
    tried = scored(data, model)
    if not tried:
        raise ValueError(data.doubts[0])
    candidate, after = min(tried, key=lambda pair: pair[1].relative)
    size = float(np.sqrt(np.mean(data.table.value**2)))
    slip, mended, error = _told([candidate], size, after)
    return slip, replace(mended, doubts=()), error


def _told(
    alike: Sequence[Candidate], before: float, after: Score
) -> tuple[Slip, MeasurementSet, float]:
    """The first of some slips that explain the data about as well, with the others beside it;
    before: error of the data as stated; after: score without the first.
    """
    candidate, *others = alike
    slip = Slip(
        candidate.name,
        candidate.column,
        candidate.said,
        candidate.fits,
        before,
        after.rmse,
        candidate.mend,
        alike=tuple(map(words, others)),
        factor=after.factor if is_mere_factor(candidate.name, candidate.column) else 1.0,
    )
    return slip, candidate.mended, after.relative


def is_slip(name: str, before: Score, after: Score) -> bool:
    """Whether the error falls so far without a slip that hardly any effect could do the same.

    The slip must remove most of a large error, or all of a small one, and still more if the
    calibration ends on a bound. The slips `chord` and `curvature` must explain the data to the
    noise floor, as a weak or strong actuation scales angles, too.

    name: kind of the slip. before, after: scores of the model with and without it.
    """
    if name in LIKE_WEAKNESS and not after.explains:
        return False
    if after.excess > RULES.slip_share * before.excess:
        return False
    if after.at_bound and after.relative > RULES.slip_share_at_bound * before.relative:
        return after.is_noise
    return before.relative > RULES.slip_error or after.is_noise


def scored(data: MeasurementSet, model: Model) -> list[tuple[Candidate, Score]]:
    """The slips of `nearest` with the scores that the fitted model has without them."""
    return _scores(nearest(data, model), model)


def _scores(tried: Sequence[Candidate], model: Model) -> list[tuple[Candidate, Score]]:
    """Slips with their scores, without those whose data the model refuses: some poses may be out of
    reach that no prediction of a few samples saw.
    """
    found = []
    for one in tried:
        try:
            found.append((one, score(one.mended, model)))
        except ValueError:  # such data the model refuses: so that is not the slip
            continue
    return found


def nearest(data: MeasurementSet, model: Model) -> list[Candidate]:
    """The slips (mistakes in units, signs or names) with the least error before any fit, at most
    `FITTED` of them, in the order of `candidates`.
    """
    tried = [one for one in candidates(data) if not data.doubts or is_possible(one.mended)]
    errors = [_predicted_error(candidate.mended, model) for candidate in tried]
    chosen = sorted(np.argsort(errors, kind="stable")[:FITTED].tolist())
    return [tried[n] for n in chosen if np.isfinite(errors[n])]


def _predicted_error(data: MeasurementSet, model: Model) -> float:
    """Relative error of a model that is not fitted, but for a common factor that the calibration
    may have.
    """
    data, joints = made_of(thinned(data, 1, PREDICTED_SAMPLES), model), model.springs
    try:
        forward = Forward(data, model.base, (), model.effects, model.calibration, joints=joints)
    except ValueError:  # such data the model refuses: so that is not the slip
        return np.inf
    with np.errstate(all="ignore"):
        predicted = forward.predict(forward.start()[None])[0]
    if not np.all(np.isfinite(predicted)) or not np.any(forward.measured):
        return np.inf
    measured, square = forward.measured, float(predicted @ predicted)
    factor = float(predicted @ forward.measured) / square if square > 0.0 else 1.0
    low, high = FREE_MODULUS_RANGE if data.free_modulus else USUAL_MODULUS_SCALES
    left = measured - np.clip(factor, low, high) * predicted
    return float(np.linalg.norm(left) / np.linalg.norm(measured))


def score(data: MeasurementSet, model: Model) -> Score:
    """Score of the model on thinned data, with its calibration fitted."""
    problem, given = pose_problem(thinned(data, 1, SLIP_SAMPLES), model, {})
    likelihood = problem.likelihood([effect.name for effect in given])
    found = fit(likelihood, base_starts(likelihood.parameters))
    size = float(np.sqrt(np.mean(problem.data.table.value**2)))
    free = [parameter.effect is None for parameter in likelihood.parameters]
    at_bound = bool(np.any(found.at_limit & np.array(free, bool)))
    scales = np.abs(np.log(found.values[free])) if data.free_modulus else np.zeros(1)
    return Score(
        hold_out(found).rmse,
        _floor(problem),
        size,
        at_bound,
        float(np.max(scales)),
        factor_left(problem.data, problem.data.table.value - found.residual),
        _modulus(likelihood.parameters, found.values),
    )


def _modulus(parameters: Sequence[FreeParameter], values: Array) -> float:
    """The one shear modulus over the stated one; 1 if there is none, or several."""
    found = [
        value
        for parameter, value in zip(parameters, values.tolist(), strict=True)
        if parameter.name.startswith("modulus_scale")
    ]
    return float(found[0]) if len(found) == 1 else 1.0


def _of_another_mix(data: MeasurementSet, model: Model, after: Score) -> float:
    """Factor on the shear modulus with which the data as stated fit about as well as without a
    slip, whose score is `after`; 1 if there is none, or rubber hardly differs so much.
    """
    if data.free_modulus:
        return 1.0
    free = score(replace(data, free_modulus=True), model)
    largest = RULES.other_mix
    likely = 1.0 / largest <= free.modulus <= largest
    return free.modulus if likely and free.relative <= RULES.slip_alike * after.relative else 1.0


def _floor(problem: FitProblem) -> float:
    """The noise floor [SI unit of the outputs]; of a set in poses that may be wrong, at most what
    the readings of repeats scatter by themselves.
    """
    data, total = problem.data, problem.floor.total
    if problem.floor.source != REPEATS or not _in_unsure_poses(data):
        return total
    readings = data.table.value
    return min(total, noise_floor(data, make_spectrum(data.table, readings), readings).total)


def _scatter(data: MeasurementSet, floor: float) -> float:
    """How much readings scatter [SI unit of the outputs]: the noise floor; of a set in poses that
    may be wrong, at most what smoothing splines through the readings leave.
    """
    short = max(run.samples for run in data.runs) < RULES.spline_samples
    if short or not _in_unsure_poses(data):
        return floor
    readings = data.table.value
    levels = spline_levels(data, make_spectrum(data.table, readings), readings)
    return min(floor, float(np.sqrt(np.mean(levels**2))))


def _in_unsure_poses(data: MeasurementSet) -> bool:
    """Whether a model is driven by the measured pose of a tip, of which no noise is stated.

    In a pose that is wrong a chain is bent so far that small differences of repeats become large
    ones of the prediction, which are no noise of the readings.
    """
    return set(TIP_POSE) <= set(data.inputs) and not any(data.noise.get(name) for name in TIP_POSE)
