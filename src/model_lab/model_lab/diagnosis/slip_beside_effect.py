"""Search for a slip together with a missing effect, where neither alone explains the data.

An example is a wrong finger size and a hysteresis: with the size corrected, the set still differs
much from the model, so a search for slips alone misses it. Here the best effect is found, on
thinned data, for the set as stated and for the set corrected by each plausible slip. A slip is
reported if one usual effect explains the corrected data, and no effect explains the data as stated.
Differences of repeats may hide that: rubber that softens raises the noise floor, within which a
mere stiffening then seems to explain what a slip and the softening explain far better.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from model_lab.aliases import Tell, tell_nobody
from model_lab.diagnosis.criteria import error_of
from model_lab.diagnosis.result import calibration_at_bound
from model_lab.diagnosis.search import Scored, score_all, score_base
from model_lab.experiments.forward import not_searched
from model_lab.fitting.noise_floor import REPEATS
from model_lab.fitting.problem import FitProblem, pose_problem, with_lower_floor
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.measurements.preprocess import thinned
from model_lab.rules import RULES
from model_lab.series.events import Event
from model_lab.series.lowering import examine_lowering
from model_lab.series.mended import without_events
from model_lab.slips.columns import Candidate
from model_lab.slips.factor import factor_left, is_other_factor
from model_lab.slips.find import (
    SLIP_SAMPLES,
    Checked,
    find_slips,
    nearest,
    scatters,
    shown_by_readings,
    words,
)
from model_lab.slips.outside import outside
from model_lab.slips.slip import Slip
from softhand_model.effects import Effect
from softhand_model.model_file import Model

FITTED_OF_HAND = 12  # of the many places of a hand, where otherwise all are fitted
LIKE_A_LAW = ("true_stress",)  # slips that a rubber which stiffens looks like
FITTED_EFFECTS = 5  # beside a slip that leaves much: those whose signatures promise most
FIRST_EFFECTS, SECOND_EFFECTS = 2, 3  # of pairs in the set as stated


@dataclass(frozen=True)
class _Searched:
    """A set with the model as it is, and with each effect, the least error first; given: effects of
    the model that are fitted with the calibration.
    """

    problem: FitProblem
    given: tuple[Effect, ...]
    base: Scored
    tried: tuple[Scored, ...]
    size: float

    @property
    def usual(self) -> Scored | None:
        """The best effect that is plausible at usual values of its parameters."""
        return next((scored for scored in self.tried if _is_usual(scored)), None)

    @property
    def likely(self) -> list[Scored]:
        """Effects whose parameters are off their limits and not far from usual."""
        return [one for one in self.tried if one.plausible and one.unusual < RULES.tie_deviance]

    @property
    def least(self) -> float:
        """Smallest relative error with a likely effect, or without any."""
        return min(map(self.relative, (self.base, *self.likely)))

    @property
    def factor_left(self) -> float:
        """The factor that the data lack without any effect (`slips.factor`)."""
        data = self.problem.data
        return factor_left(data, data.table.value - self.base.fit.residual)

    def error(self, scored: Scored) -> float:
        """Error by which the verdict judges. With two protocols that is the error of the fit: one
        protocol may end before an effect begins, and then cannot predict the other.
        """
        return error_of(self.problem, scored)

    def relative(self, scored: Scored) -> float:
        """Error over the size of the outputs, which does not depend on their unit."""
        return self.error(scored) / self.size if self.size > 0.0 else np.inf

    def explains(self, scored: Scored, most: float = RULES.explained_error) -> bool:
        """Whether an error is within a multiple of the floor."""
        return self.error(scored) <= most * self.problem.floor.total


@dataclass(frozen=True)
class _Found:
    candidate: Candidate
    searched: _Searched
    effect: Scored

    @property
    def error(self) -> float:
        """Relative error without the slip and with the effect."""
        return self.searched.relative(self.effect)


def find_all_slips(
    data: MeasurementSet,
    model: Model,
    classes: Mapping[str, type[Effect]],
    tell: Tell = tell_nobody,
) -> Checked:
    """Search for the slips of a set, and take them out: slips that explain the set, alone or with
    an effect; or else one slip and one effect that explain it together.

    classes: effects to try, by name. Raises ValueError for data that the model cannot use.
    """
    shown = None if data.doubts else shown_by_readings(data, model)
    if shown is not None:  # that is a slip whatever else is missing
        slip, mended, _ = shown
        rest = find_all_slips(mended, model, classes, tell)
        return replace(rest, slips=(slip, *rest.slips))
    checked = find_slips(data, model, tell)
    if data.doubts:
        return checked
    law = bool(checked.slips) and all(slip.name in LIKE_A_LAW for slip in checked.slips)
    if law and _law_explains(data, model, classes):
        return Checked(data)
    if checked.slips:
        left = _error_explained(checked.data, model, classes)
        if left is not None:
            return Checked(data) if _effect_alone(data, left, model, classes) else checked
    beside = find_slip_beside_effect(data, model, classes, tell)
    if beside.slips or not checked.slips:
        return beside
    rather = _effect_rather(data, checked.relative_error, model, classes)
    return Checked(data) if rather else checked


def find_slip_beside_effect(
    data: MeasurementSet,
    model: Model,
    classes: Mapping[str, type[Effect]],
    tell: Tell = tell_nobody,
) -> Checked:
    """Search for one slip that explains a set together with one effect, and take it out. If there
    is none, the result is the set as it is, without slips.

    classes: effects to try, by name. Raises ValueError for data that the model cannot use.
    """
    stated = _base_of(data, model, classes)
    whole = thinned(data, 1, SLIP_SAMPLES) is data
    none = Checked(data, problem=(stated.problem, stated.given) if whole else None)
    scattered = scatters(data, stated.problem.floor.total)
    if stated.explains(stated.base) or scattered or outside(data, model.base):
        return none
    tell("looking for wrong units and the like beside an effect", 0, 0)
    every = FITTED_OF_HAND if data.of_hand else 0
    for limit in (FITTED_EFFECTS, every):
        stated = _with_effects(stated, model, limit)
        explained = any(map(stated.explains, stated.likely))
        if explained and stated.problem.floor.source != REPEATS:
            return none
    found = list(_explained(data, model, classes, stated, every))
    if explained:
        found = [one for one in found if _explains_repeats(one, stated)]
    if not found:
        return none
    best, *others = _alike(found)
    if _event_explains(stated, best, model, classes):
        return none
    rivals = _pairs_as_good(stated, model, best)
    if rivals and not all(_is_gain(stated.problem, pair) for pair in rivals):
        return none  # two effects without a slip are as likely
    return Checked(
        best.candidate.mended,
        (replace(_slip(best, stated), alike=tuple(words(one.candidate) for one in others)),),
        best.error,
        tuple(" and ".join(pair.effects[-2:]) for pair in rivals),
    )


def _alike(found: list[_Found]) -> list[_Found]:
    """The slips that explain about as much as the best one does: first those that need no modulus
    at the end of what is usual, of these the commonest.
    """
    least = min(one.error for one in found)
    alike = [one for one in found if one.error <= RULES.slip_alike * least]
    return sorted(alike, key=lambda one: (_at_bound(one.effect), one.candidate.rare))


def _at_bound(scored: Scored) -> bool:
    return calibration_at_bound(scored) != ()


def _slip(found: _Found, stated: _Searched) -> Slip:
    candidate, after = found.candidate, found.effect
    return Slip(
        candidate.name,
        candidate.column,
        candidate.said,
        candidate.fits,
        stated.error(stated.base),
        found.searched.error(after),
        candidate.mend,
        beside=after.added,
    )


# ---------------------------------------------------------------------- with a slip
def _explained(
    data: MeasurementSet,
    model: Model,
    classes: Mapping[str, type[Effect]],
    stated: _Searched,
    every: int,
) -> Iterator[_Found]:
    """Slips beside which a usual effect explains so much more than any does in the set as stated;
    in the order of candidates. every: how many effects are fitted where most are; 0 for all.
    """
    for candidate in nearest(data, model):
        try:
            mended = _base_of(candidate.mended, model, classes)
        except ValueError:  # such data the model refuses: so that is not the slip
            continue
        left = mended.relative(mended.base) / stated.relative(stated.base)
        if left > RULES.slip_beside_worse or np.isclose(left, 1.0):
            continue  # what the calibration takes up whole is seen by no error
        if is_other_factor(candidate.name, candidate.column, mended.factor_left):
            continue
        limit = FITTED_EFFECTS if left > RULES.help_error else every
        mended = _with_effects(mended, model, limit)
        effect = mended.usual
        if effect is not None and _tells(stated, mended, effect):
            yield _Found(candidate, mended, effect)


def _tells(stated: _Searched, mended: _Searched, effect: Scored) -> bool:
    """Whether mended data with an effect are explained, and so much better than the data as stated
    are by any effect that no chance does the same. The farther from the floor, the larger that
    must be.
    """
    share = mended.relative(effect) / stated.least
    if mended.explains(effect):
        return share <= RULES.slip_beside_share
    return share <= RULES.slip_share and mended.explains(effect, RULES.most_explained_error)


def _explains_repeats(found: _Found, stated: _Searched) -> bool:
    """Whether a slip and an effect explain how repeats differ, and with that the set to the floor
    that is left then, which no effect does in the set as stated.
    """
    lower = with_lower_floor(found.searched.problem, found.effect.fit)
    if lower is None:
        return False
    most = RULES.explained_error * lower.floor.total / found.searched.size
    return found.error <= most < stated.least


def _is_usual(scored: Scored) -> bool:
    return scored.plausible and scored.unusual < RULES.tie_unusual


# ---------------------------------------------------------------------- without a slip
def _pairs_as_good(stated: _Searched, model: Model, found: _Found) -> list[Scored]:
    """Pairs of usual effects that explain a set as stated as well as a slip and an effect do, with
    one parameter in the place of the slip at most, and no modulus at the end of what is usual.
    """
    problem, names = stated.problem, _names(stated.problem, model)
    pairs = [
        scored
        for first in stated.tried[:FIRST_EFFECTS]
        for scored in score_all(
            problem, first, [n for n in names if n not in first.effects], limit=SECOND_EFFECTS
        )
        if isinstance(scored, Scored) and _is_usual(scored) and not _at_bound(scored)
    ]
    most = len(found.effect.fit.values) + 1
    as_good = [
        pair
        for pair in pairs
        if stated.relative(pair) <= RULES.slip_alike * found.error and len(pair.fit.values) <= most
    ]
    distinct = {frozenset(pair.effects): pair for pair in as_good}
    return sorted(distinct.values(), key=stated.error)


def _event_explains(
    stated: _Searched, found: _Found, model: Model, classes: Mapping[str, type[Effect]]
) -> bool:
    """Whether a set as stated, without the events in its series, is explained as well as by a slip
    and an effect: ageing beside a wrong size may look like a step in the series.
    """

    def without(events: Sequence[Event]) -> _Searched:
        cleaned = without_events(stated.problem.data, events)
        return _base_of(cleaned, model, classes) if events else stated

    series = examine_lowering(
        stated.problem.data,
        stated.base.fit.residual,
        stated.problem.floor,
        lambda events: without(events).base.held_out.rmse,
    )
    return bool(series.events) and (
        _with_effects(without(series.events), model).least <= RULES.slip_alike * found.error
    )


def _is_gain(problem: FitProblem, added: Scored) -> bool:
    """Whether one of at most two effects is a mere factor, as a slip is without a parameter."""
    return any(problem.classes[name].cause == "gain" for name in added.effects[-2:])


# ---------------------------------------------------------------------- fits
def _error_explained(
    data: MeasurementSet, model: Model, classes: Mapping[str, type[Effect]]
) -> float | None:
    """Relative error with a usual effect where the model explains a set only with one; 0 where it
    does so as it is, and None where it does not.
    """
    mended = _base_of(data, model, classes)
    if mended.explains(mended.base):
        return 0.0
    effect = _with_effects(mended, model).usual
    return mended.relative(effect) if effect is not None and mended.explains(effect) else None


def _effect_alone(
    data: MeasurementSet, left: float, model: Model, classes: Mapping[str, type[Effect]]
) -> bool:
    """Whether a usual effect alone explains a set as stated, and as well as slips and an effect do
    together, which leave the relative error `left`. A mere factor does not count, as a slip is one.
    """
    if left == 0.0:
        return False
    stated = _with_effects(_base_of(data, model, classes), model)
    return any(
        stated.explains(one) and stated.relative(one) <= left
        for one in stated.tried
        if _is_usual(one) and not _at_bound(one) and not _is_gain(stated.problem, one)
    )


def _law_explains(data: MeasurementSet, model: Model, classes: Mapping[str, type[Effect]]) -> bool:
    """Whether a law of the rubber, also one of a finer form, explains a set as stated."""
    stated = _base_of(data, model, classes)
    laws = [
        name
        for name, effect in stated.problem.classes.items()
        if effect.stage == "elastic"
        and not effect.has_memory
        and not_searched(effect, data, model.base) is None
    ]
    tried = score_all(stated.problem, stated.base, laws)
    scored = [one for one in tried if isinstance(one, Scored)]
    return any(stated.explains(one) and _is_usual(one) and not _at_bound(one) for one in scored)


def _effect_rather(
    data: MeasurementSet, left: float, model: Model, classes: Mapping[str, type[Effect]]
) -> bool:
    """Whether a likely effect about explains a set as stated, and removes at least half of the
    relative error `left` by slips that do not explain it.
    """
    stated = _with_effects(_base_of(data, model, classes), model)
    return any(
        stated.explains(one, RULES.most_explained_error)
        and stated.relative(one) <= (1.0 - RULES.removed_share) * left
        for one in stated.likely
    )


def _base_of(data: MeasurementSet, model: Model, classes: Mapping[str, type[Effect]]) -> _Searched:
    problem, given = pose_problem(thinned(data, 1, SLIP_SAMPLES), model, classes)
    problem = replace(problem, known={})
    base = score_base(problem, [effect.name for effect in given])
    size = float(np.sqrt(np.mean(problem.data.table.value**2)))
    return _Searched(problem, given, base, (), size)


def _with_effects(searched: _Searched, model: Model, limit: int = 0) -> _Searched:
    """The same with each effect added, or with so many that promise most."""
    problem, base = searched.problem, searched.base
    tried = score_all(problem, base, _names(problem, model), limit=limit)
    scored = [one for one in tried if isinstance(one, Scored)]
    scored.sort(key=searched.error)
    return replace(searched, tried=tuple(scored))


def _names(problem: FitProblem, model: Model) -> list[str]:
    """Plain effects that may be missing in a set."""
    present = {effect.name for effect in model.effects}
    return [
        name
        for name, effect in problem.classes.items()
        if name not in present
        and effect.physical
        and not effect.refines
        and not_searched(effect, problem.data, model.base) is None
    ]
